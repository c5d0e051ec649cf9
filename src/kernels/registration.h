// What happens between the passes of a frame's registration: the solve, the step, the gates of the next pass, and
// whether a level is through (docs/method.md §1, "minimisation"; §3, §4 and §6). A host runs it between launches, a
// device without leaving the kernel: both ask `advance` what to sum up next until nothing is left.
#pragma once

#include <limits>

#include "kernels/icp.h"
#include "kernels/terms.h"
#include "plumbline/se3.h"

namespace plumbline::kernels {

constexpr int kMaxLevels = 8;

/// Whether the bin between these sums of counts holds the median.
PL_SHARED bool holds_median(long long before, long long below, long long total) {
  return 2 * below >= total && 2 * before < total;
}

/// Bin that holds the median of a distribution; the last one counts too. −1 if it is empty.
template <class Count>
PL_SHARED int median_bin(const Count* counts, int bins) {
  long long total = 0, below = 0;
  for (int bin = 0; bin < bins; ++bin) total += counts[bin];
  for (int bin = 0; bin < bins; ++bin) {
    const long long before = below;
    below += counts[bin];
    if (holds_median(before, below, total)) return bin;
  }
  return -1;
}

/// Centre of the bin of a distribution of `bins` bins and one for what lies beyond; metres. The range's end for the
/// latter, 0 without pairs.
PL_SHARED double median_distance(int bin, int bins, double bin_width) {
  if (bin < 0) return 0;
  return bin == bins ? bins * bin_width : (bin + 0.5) * bin_width;
}

/// AᵀWA of the sums of a pass.
PL_SHARED Matrix6d hessian(const double* slots) {
  Matrix6d h;
  int slot = icp_sum::kHessian;
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j) h(i, j) = h(j, i) = slots[slot++];
  return h;
}

/// AᵀWb.
PL_SHARED Vector6d gradient(const double* slots) {
  Vector6d b;
  for (int i = 0; i < 6; ++i) b[i] = slots[icp_sum::kGradient + i];
  return b;
}

/// `TrackingParameters`, as far as iterations are concerned, in the form that a device takes.
struct RegistrationRules {
  double distance_gate = 0, widest_gate = 0, gate_per_median = 0;  ///< metres, metres, 1
  float cos_normal_gate = 0;
  NoiseModel noise;
  float huber = kNoDistance;  ///< metres
  int bins = 0;
  float bins_per_metre = 0;
  bool median_filter = false;
  double median_band = 0;  ///< metres
  double max_condition = 0, converged_step = 0;
  int converged_after = 0, max_iterations = 0;
  bool every_distribution = false;  ///< whether each iteration needs the distances' distribution

  /// Of a pass at an estimate, after an iteration whose median distance was `previous_median`, metres; 0 before the
  /// first.
  PL_SHARED void set_gates(const SE3& model_from_live, double previous_median, IcpInput* in) const {
    in->model_from_live = to_kernel(model_from_live);
    const double widest = widest_gate > distance_gate ? widest_gate : distance_gate,
                 asked = gate_per_median * previous_median;
    in->distance_gate = static_cast<float>(asked < distance_gate ? distance_gate : (asked > widest ? widest : asked));
    in->cos_normal_gate = cos_normal_gate;
    in->band_low = 0;
    in->band_high = std::numeric_limits<float>::max();
    in->noise = noise;
    in->huber = huber;
    in->bins = bins;
    in->bins_per_metre = bins_per_metre;
  }

  /// The band of distances that the median filter keeps.
  PL_SHARED void set_band(double median, IcpInput* in) const {
    in->band_low = static_cast<float>(median - median_band);
    in->band_high = static_cast<float>(median + median_band);
  }
};

struct RegistrationLevel {
  IcpInput images;                  ///< gates left open
  PlaneView<float> distances = {};  ///< of every pixel's pair, metres: memory for the median filter
  double information = 1;           ///< of a pixel's squared residual
  int pixels = 0, iterations = 0;
  int min_inliers = 0;  ///< fewer end the level
};

/// A frame's registration, all levels that iterate, coarse to fine.
struct Registration {
  RegistrationRules rules;
  Terms terms;
  SE3 world_from_model;
  RegistrationLevel levels[kMaxLevels];
  int level_count = 0;
};

/// What is to be summed up next.
enum class RegistrationTask {
  pass,                ///< `IcpReduce` of the level
  correction,          ///< `IcpCorrection`: the pass had the band of the previous median, now its own median is known
  final_distribution,  ///< `IcpReduce` once more, for its distribution: the final iteration came sooner than expected
  finished
};

struct RegistrationPass {
  RegistrationTask task = RegistrationTask::finished;
  int level = 0;
  IcpInput in;
  float from_low = 0, from_high = 0;  ///< of the correction
};

struct RegistrationState {
  RegistrationPass next;
  SE3 model_from_live, before;  ///< the estimate, and that of the previous iteration's pass
  double median_distance = 0;   ///< of the latest distribution, metres
  double slots[icp_sum::kCount] = {};
  int bin = -1;            ///< of the median; of the latest distribution
  double h[36] = {};       ///< of the latest system, left increments of model_from_live, column by column
  double step[6] = {};     ///< of the latest iteration: radians, metres
  int rank = 0;            ///< of the latest system
  int made = 0, same = 0;  ///< iterations of this level; of these, with the previous one's median
  int previous_bin = -1;
  int iterations[kMaxLevels] = {};

  PL_SHARED int inliers() const { return static_cast<int>(slots[icp_sum::kInliers]); }
  PL_SHARED double rms() const {
    return inliers() > 0 ? std::sqrt(slots[icp_sum::kSquares] / inliers()) : 0;
  }  // metres
};

namespace detail {

PL_SHARED bool is_final_level(const Registration& r, const RegistrationState& s) {
  return s.next.level + 1 == r.level_count;
}

/// Whether the next iteration may be the frame's final one, so that its distribution is told.
PL_SHARED bool may_be_final(const Registration& r, const RegistrationState& s) {
  return is_final_level(r, s) && s.made + 1 >= r.levels[s.next.level].iterations;
}

/// The input of an iteration at the estimate.
PL_SHARED void prepare_pass(const Registration& r, RegistrationState* s) {
  s->next.task = RegistrationTask::pass;
  s->next.in = r.levels[s->next.level].images;
  r.rules.set_gates(s->model_from_live, s->median_distance, &s->next.in);
  if (!r.rules.every_distribution && !may_be_final(r, *s)) s->next.in.bins = 0;
  if (r.rules.median_filter) r.rules.set_band(s->median_distance, &s->next.in);
}

/// The final iteration's pass once more, only for its distribution. Without a band: only pairs
/// count.
PL_SHARED void prepare_final_distribution(const Registration& r, RegistrationState* s) {
  s->next.task = RegistrationTask::final_distribution;
  s->next.in = r.levels[s->next.level].images;
  r.rules.set_gates(s->before, 0, &s->next.in);
}

/// The pass was made with the band around the previous median; whether its own asks for another one.
PL_SHARED bool prepare_correction(const Registration& r, double median, RegistrationState* s) {
  IcpInput in = s->next.in;
  r.rules.set_band(median, &in);
  if (in.band_low == s->next.in.band_low) return false;
  s->next.task = RegistrationTask::correction;
  s->next.from_low = s->next.in.band_low;
  s->next.from_high = s->next.in.band_high;
  s->next.in = in;
  return true;
}

/// The normal equations of the sums and the terms, the step, and the estimate after it. The terms' equations are in
/// left increments of world_from_camera, the registration's in left increments of model_from_live; they differ by the
/// adjoint of world_from_model.
PL_SHARED void take_step(const Registration& r, RegistrationState* s) {
  const RegistrationLevel& level = r.levels[s->next.level];
  NormalEquations system;
  system.h = level.information * hessian(s->slots);
  system.b = level.information * gradient(s->slots);
  if (!r.terms.empty()) {
    const NormalEquations term =
        r.terms.evaluate({r.world_from_model * s->model_from_live, {s->inliers(), level.pixels, level.information}});
    const Matrix6d world_from_model_increment = r.world_from_model.adjoint();
    system.h += world_from_model_increment.transpose() * term.h * world_from_model_increment;
    system.b += world_from_model_increment.transpose() * term.b;
  }
  const Solution solution = solve(system.h, system.b, r.rules.max_condition);
  s->before = s->model_from_live;
  s->model_from_live = (SE3::exp(solution.step) * s->model_from_live).normalized();
  s->rank = solution.rank;
  for (int i = 0; i < 36; ++i) s->h[i] = system.h.data()[i];
  for (int i = 0; i < 6; ++i) s->step[i] = solution.step[i];
}

/// What is at the usual distance of a scene still moves.
PL_SHARED bool still_moves(const RegistrationRules& rules, const double* step) {
  constexpr double kUsualDistance = 1.5;  // metres
  const Eigen::Map<const Vector6d> xi(step);
  return kUsualDistance * xi.head<3>().norm() + xi.tail<3>().norm() >= rules.converged_step;
}

/// The median's bin has not changed over so many successive iterations (docs/method.md §4).
PL_SHARED bool median_stands_still(const RegistrationRules& rules, RegistrationState* s) {
  if (rules.converged_after == 0) return false;
  s->same = s->bin == s->previous_bin ? s->same + 1 : 1;
  s->previous_bin = s->bin;
  return s->same >= rules.converged_after;
}

PL_SHARED bool level_is_through(const Registration& r, RegistrationState* s) {
  const int min_iterations = r.levels[s->next.level].iterations,
            max_iterations = r.rules.converged_step > 0 ? r.rules.max_iterations : min_iterations;
  if (median_stands_still(r.rules, s)) return true;
  return s->made >= min_iterations && (s->made >= max_iterations || !still_moves(r.rules, s->step));
}

PL_SHARED void end_iteration(const Registration& r, RegistrationState* s) {
  const RegistrationLevel& level = r.levels[s->next.level];
  const bool with_distribution = s->next.in.bins > 0;
  take_step(r, s);
  ++s->made;
  ++s->iterations[s->next.level];
  const bool through = level_is_through(r, s), nothing_to_hold = s->inliers() < level.min_inliers;
  if (!through && !nothing_to_hold) return prepare_pass(r, s);
  if (!is_final_level(r, *s)) {
    ++s->next.level;
    s->made = s->same = 0;
    s->previous_bin = -1;
    return prepare_pass(r, s);
  }
  if (!with_distribution && r.rules.bins > 0) return prepare_final_distribution(r, s);
  s->next.task = RegistrationTask::finished;
}

}  // namespace detail

/// Before the first pass.
PL_SHARED RegistrationState begin(const Registration& r, const SE3& model_from_live) {
  RegistrationState state;
  state.model_from_live = state.before = model_from_live;
  if (r.level_count > 0) detail::prepare_pass(r, &state);
  return state;
}

/// What follows from the sums that `s->next` asked for, and the bin of their median (−1 without a distribution).
PL_SHARED void advance(const Registration& r, const double* slots, int bin, RegistrationState* s) {
  const double bin_width = s->next.in.bins > 0 ? 1.0 / static_cast<double>(s->next.in.bins_per_metre) : 0;
  const double median = median_distance(bin, s->next.in.bins, bin_width);
  switch (s->next.task) {
    case RegistrationTask::pass:
      for (int i = 0; i < icp_sum::kCount; ++i) s->slots[i] = slots[i];
      s->bin = bin;
      s->median_distance = median;
      if (r.rules.median_filter && detail::prepare_correction(r, median, s)) return;
      return detail::end_iteration(r, s);
    case RegistrationTask::correction:
      for (int i = 0; i < icp_sum::kCount; ++i) s->slots[i] += slots[i];
      return detail::end_iteration(r, s);
    case RegistrationTask::final_distribution:
      s->median_distance = median;
      s->next.task = RegistrationTask::finished;
      return;
    case RegistrationTask::finished:
      return;
  }
}

}  // namespace plumbline::kernels
