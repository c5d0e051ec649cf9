#include "run/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include "cli/console.h"
#include "core/median.h"
#include "plumbline/time.h"
#include "run/summary.h"
#include "tracking/starts.h"

namespace plumbline::app {
namespace {

constexpr double kGoodError = 0.05, kPoorError = 0.20;  // metres
constexpr double kFairShareLost = 0.005, kPoorShareLost = 0.1;
constexpr double kMaxWeight = 4;

double percent(double share) { return 100 * share; }

double share_of(std::ptrdiff_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// A figure of every frame that was registered and tracked.
template <class Figure>
std::vector<double> of_tracked(const Reconstruction& run, const Figure& figure) {
  std::vector<double> all;
  for (const FrameReport& frame : run.frames)
    if (frame.tracking.status == TrackingStatus::tracked && !frame.tracking.iterations.empty())
      all.push_back(figure(frame.tracking));
  return all;
}

/// Of the 6×6 system of the registration; a singular one leaves a direction open altogether.
double condition_of(const TrackingResult& tracking) {
  constexpr double kSingular = 1e6;
  return tracking.rank < 6 ? kSingular : tracking.condition;
}

/// How much farther apart than in the images that the limits were set on (320×240) the pixels lie on a surface: a pair
/// is the nearest pixel's, so that distances and contradictions grow with it, by seven tenths of them. 1 for finer
/// images.
double coarseness_of(const Pinhole& camera) {
  constexpr double kFocal = 262.5, kShare = 0.7;
  if (!(camera.fx > 0)) return 1;
  return std::max(1.0, 1 - kShare + kShare * kFocal / static_cast<double>(camera.fx));
}

void add_fit_doubts(const Reconstruction& run, std::vector<Doubt>* doubts) {
  const double coarseness = coarseness_of(run.sequence.camera);
  const double distance = median(of_tracked(run, [](const TrackingResult& t) { return t.median_distance; }));
  doubts->push_back({"median_distance_m", distance / coarseness, 0.018, 0.026,
                     fmt::format("The frames lie {} from the model (median): they do not fit it as a right path would.",
                                 length_text(distance))});
  const std::vector<double> agreements = of_tracked(run, [&](const TrackingResult& t) {
    return t.inlier_fraction - (t.inlier_fraction - agreement(t)) / coarseness;
  });
  const double disagreement = agreements.empty() ? 0 : 1 - median(agreements);
  doubts->push_back(
      {"disagreement", disagreement, 0.88, 0.97,
       "Half of the frames share hardly more with the model than they contradict it: the path is probably "
       "wrong."});
}

void add_tracking_doubts(const Reconstruction& run, std::vector<Doubt>* doubts) {
  const double lost = share_of(run.lost(), run.frames.size());
  doubts->push_back({"lost", lost, kFairShareLost, kPoorShareLost, ""});  // the verdict begins with it
  const auto retried = std::count_if(run.frames.begin(), run.frames.end(), [](const FrameReport& frame) {
    return !frame.is_after_interruption && frame.starts > 1;
  });
  const double retries = share_of(retried, run.frames.size());
  doubts->push_back(
      {"several_starts", retries, 0.1, 0.5,
       fmt::format("{:.0f}\u00a0% of the frames fitted only from another start than the expected one: the "
                   "motion was fast, or the view ambiguous.",
                   percent(retries))});
  const double condition = quantile(of_tracked(run, condition_of), 0.9);
  doubts->push_back(
      {"condition", condition, 500, 3000,
       "In a tenth of the frames or more the view left a direction nearly open (a bare wall, a corridor), "
       "along which the camera may have slid: look at edges and things as well."});
  add_fit_doubts(run, doubts);
  const double revoked = interruptions(run).revoked;
  doubts->push_back(
      {"revoked_places", revoked, 1, 5,
       fmt::format("A place that was recognised after an interruption had to be taken back {:.0f} times.", revoked)});
}

void add_model_doubts(const ModelConsistency& model, std::vector<Doubt>* doubts) {
  const bool is_compared = model.views > 1;
  doubts->push_back(
      {"see_through", is_compared ? model.see_through : 0, 0.05, 0.15,
       fmt::format(
           "The model contradicts the views that it was made of: {:.0f}\u00a0% of their readings lie behind its "
           "surface. Surfaces may be there twice (drift, or a wrong place).",
           percent(model.see_through))});
  const double unmatched = is_compared ? 1 - model.matched : 0;
  doubts->push_back(
      {"unmatched", unmatched, 0.35, 0.6,
       fmt::format("{:.0f}\u00a0% of the readings do not lie on the model's surface: check the intrinsics "
                   "and the depth's scale.",
                   percent(unmatched))});
  const double unknown = is_compared ? 1 - model.known : 0;
  doubts->push_back({"outside_model", unknown, 0.5, 0.85,
                     fmt::format("The model holds nothing for {:.0f}\u00a0% of the readings: the scene is larger than "
                                 "the volume, or mostly out of range.",
                                 percent(unknown))});
}

void add_input_doubts(const Reconstruction& run, std::vector<Doubt>* doubts) {
  const auto warnings = static_cast<double>(run.sequence.warnings.size());
  doubts->push_back({"input_warnings", warnings, 1, 4,
                     run.sequence.warnings.empty()
                         ? ""
                         : fmt::format("The input does not add up: {}.", run.sequence.warnings.front().what)});
  doubts->push_back({"sensor_warnings", run.orientation_message.empty() ? 0.0 : 1.0, 1, 4, run.orientation_message});
  const auto unread = static_cast<std::ptrdiff_t>(run.skipped.size());
  const double skipped = share_of(unread, run.frames.size() + run.skipped.size());
  doubts->push_back({"unreadable", skipped, 0.02, 0.3,
                     fmt::format("{} frames could not be read, so that the camera moved on unseen.", unread)});
}

std::vector<Doubt> doubts_of(const Reconstruction& run) {
  std::vector<Doubt> doubts;
  add_tracking_doubts(run, &doubts);
  add_model_doubts(run.consistency, &doubts);
  add_input_doubts(run, &doubts);
  return doubts;
}

Verdict::Level level_by_doubts(const std::vector<Doubt>& doubts) {
  double worst = 0;
  for (const Doubt& doubt : doubts) worst = std::max(worst, doubt.weight());
  return worst > 2 ? Verdict::Level::poor : worst >= 1 ? Verdict::Level::fair : Verdict::Level::good;
}

Verdict::Level level_by_truth(const Reconstruction& run) {
  const double lost = share_of(run.lost(), run.frames.size()), error = run.ate->translation.rmse;
  if (lost > kPoorShareLost || error > kPoorError) return Verdict::Level::poor;
  return lost >= kFairShareLost || error > kGoodError ? Verdict::Level::fair : Verdict::Level::good;
}

Verdict::Level level_of(const Reconstruction& run, const std::vector<Doubt>& doubts) {
  if (!run.failure.empty()) return Verdict::Level::poor;
  const Verdict::Level level = run.ate ? level_by_truth(run) : level_by_doubts(doubts);
  return run.signal != 0 ? std::max(level, Verdict::Level::fair) : level;
}

std::string tracked_text(const Reconstruction& run) {
  if (run.lost() == 0) return fmt::format("all {} frames were tracked", run.frames.size());
  return fmt::format("{} of {} frames were lost", run.lost(), run.frames.size());
}

/// What to say against the result; nothing where the truth has decided.
std::vector<std::string> reasons_of(const Reconstruction& run, const std::vector<Doubt>& doubts) {
  std::vector<std::string> reasons;
  for (const Doubt& doubt : doubts)
    if (!run.ate && doubt.weight() >= 1 && !doubt.text.empty()) reasons.push_back(doubt.text);
  return reasons;
}

std::string text_of(const Reconstruction& run, const std::vector<Doubt>& doubts) {
  std::string text = tracked_text(run);
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  if (run.ate)
    text +=
        fmt::format(", and the camera's path is within {} (rmse) of the truth", length_text(run.ate->translation.rmse));
  text += '.';
  if (const auto from = lost_to_the_end(run))
    text += fmt::format(" From {:.1f}\u00a0s to the end it was lost: no known place was seen.", *from);
  for (const std::string& reason : reasons_of(run, doubts)) text += " " + reason;
  if (!run.failure.empty()) return "The run broke off. Until then: " + text;
  return run.signal != 0 ? "The run was interrupted. Until then: " + text : text;
}

}  // namespace

double Doubt::weight() const {
  const double weight = value < fair ? value / fair : 1 + (value - fair) / (poor - fair);
  return std::clamp(weight, 0.0, kMaxWeight);
}

std::string_view to_string(Verdict::Level level) {
  constexpr std::string_view kNames[] = {"none", "good", "fair", "poor"};
  return kNames[static_cast<int>(level)];
}

Verdict verdict_of(const Reconstruction& run) {
  Verdict verdict;
  verdict.doubts = doubts_of(run);
  verdict.level = level_of(run, verdict.doubts);
  verdict.reasons = reasons_of(run, verdict.doubts);
  verdict.text = text_of(run, verdict.doubts);
  // Many small doubts are no large one: the fourth power lets the worst count.
  double sum = 0;
  for (const Doubt& doubt : verdict.doubts) sum += std::pow(doubt.weight(), 4);
  verdict.doubt = std::pow(sum, 0.25);
  return verdict;
}

}  // namespace plumbline::app
