// Projective point-to-plane registration: association, gates, distance distribution and normal equations in one pass.
// docs/method.md §1 and §4; Low 2004 for the linearisation, Newcombe et al. 2011 for the projective association.
#pragma once

#include "kernels/lane.h"
#include "kernels/preprocess.h"
#include "plumbline/pinhole.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// Why a pixel was or was not used; the values of the image that explains a frame.
enum class PixelUse : std::uint8_t {
  used = 0,
  no_depth = 1,
  no_normal = 2,    ///< of the live pixel
  out_of_view = 3,  ///< projects outside the model's image or behind its camera
  no_model = 4,     ///< nothing predicted where it projects
  distance = 5,     ///< farther from the model's point than the gate
  angle = 6,        ///< normals differ by more than the gate
  filtered = 7      ///< outside the band around the median distance
};

/// Distance of what is no pair, metres.
constexpr float kNoDistance = 1e30f;

/// Slots of the sums that one pass makes.
namespace icp_sum {
constexpr int kHessian = 0;     ///< 21 of AᵀWA, upper triangle, row by row
constexpr int kGradient = 21;   ///< 6 of AᵀWb
constexpr int kSquares = 27;    ///< Σ r², not weighted
constexpr int kInliers = 28;    ///< pairs used
constexpr int kWithDepth = 29;  ///< live pixels that have depth
constexpr int kPairs = 30;      ///< pairs that enter the distance distribution
constexpr int kCount = 31;
}  // namespace icp_sum

/// σ(z) = base + slope (z − nearest)²: the axial noise of a structured-light sensor (Nguyen, Izadi, Lovell 2012), here
/// scaled so that the weight 1/σ² has no unit. The default weights all alike.
struct NoiseModel {
  float base = 1, slope = 0, nearest = 0;

  PL_HD bool is_uniform() const { return base == 1 && slope == 0; }

  template <class F>
  PL_HD F weight(const F& z) const {
    const F d = z - F(nearest);
    const F sigma = madd(d * d, F(slope), F(base));
    return F(1.0f) / (sigma * sigma);
  }
};

/// The pass's input, all images at one pyramid level.
struct IcpInput {
  PlaneView<const float> live_depth;
  PlaneView<const float> live_normal_x, live_normal_y, live_normal_z;
  PlaneView<const float> model_depth;
  PlaneView<const float> model_normal_x, model_normal_y, model_normal_z;
  Pinhole live_camera, model_camera;
  RigidTransform model_from_live;
  float distance_gate;        ///< metres
  float cos_normal_gate;      ///< cosine of the largest angle between normals
  float band_low, band_high;  ///< distances that the median filter keeps, metres
  float bins_per_metre;
  int bins;                   ///< of the distance distribution; 0: none is made
  NoiseModel noise;           ///< decides the weight of a pair
  float huber = kNoDistance;  ///< residuals beyond this count linearly, metres
};

/// A live pixel and the model's pixel it projects to. `use` holds per-lane PixelUse codes.
template <class F>
struct IcpPair {
  Vec3<F> point;   ///< live point, model camera's frame
  Vec3<F> normal;  ///< model's normal
  F residual;      ///< n·(q − p), metres
  F distance;      ///< ‖q − p‖, metres
  F weight;        ///< of the residual, for a pair that is used
  Mask<F> has_depth, in_distribution, used;
  F use;
};

/// Projective association: the live point is moved by the estimate, projected into the model's camera, and meets the
/// model's point at that pixel.
template <class F>
PL_HD IcpPair<F> associate(const IcpInput& in, int x, int y) {
  IcpPair<F> pair;
  const F u = Lane<F>::index() + static_cast<float>(x), v(static_cast<float>(y));
  const F depth = load<F>(in.live_depth.row(y) + x);
  const Vec3<F> live_normal = {load<F>(in.live_normal_x.row(y) + x), load<F>(in.live_normal_y.row(y) + x),
                               load<F>(in.live_normal_z.row(y) + x)};
  pair.has_depth = inside_row<F>(x, in.live_depth.width) && depth > F(0.0f);
  const auto has_normal = pair.has_depth && dot(live_normal, live_normal) > F(0.5f);

  pair.point = in.model_from_live.apply(in.live_camera.back_project(u, v, depth));
  const auto in_front = has_normal && pair.point.z > F(1e-3f);
  const F inverse_z = F(1.0f) / select(in_front, pair.point.z, F(1.0f));
  const F model_u = floor(madd(pair.point.x * inverse_z, F(in.model_camera.fx), F(in.model_camera.cx + 0.5f)));
  const F model_v = floor(madd(pair.point.y * inverse_z, F(in.model_camera.fy), F(in.model_camera.cy + 0.5f)));
  const auto in_view = in_front && model_u >= F(0.0f) && model_v >= F(0.0f) &&
                       model_u < F(static_cast<float>(in.model_camera.width)) &&
                       model_v < F(static_cast<float>(in.model_camera.height));

  const F safe_u = select(in_view, model_u, F(0.0f)), safe_v = select(in_view, model_v, F(0.0f));
  const Int<F> index = to_int(safe_v) * Int<F>(in.model_depth.stride) + to_int(safe_u);
  const F model_depth = gather(in.model_depth.data, index);
  pair.normal = {gather(in.model_normal_x.data, index), gather(in.model_normal_y.data, index),
                 gather(in.model_normal_z.data, index)};
  const auto has_model = in_view && model_depth > F(0.0f);

  const Vec3<F> difference = in.model_camera.back_project(safe_u, safe_v, model_depth) - pair.point;
  pair.residual = dot(pair.normal, difference);
  pair.distance = sqrt(dot(difference, difference));
  const auto near = has_model && pair.distance <= F(in.distance_gate);
  const auto aligned = near && dot(in.model_from_live.rotate(live_normal), pair.normal) >= F(in.cos_normal_gate);
  pair.in_distribution = has_model;
  pair.used = aligned && pair.distance >= F(in.band_low) && pair.distance <= F(in.band_high);

  // Huber's weight, δ/|r| beyond δ (Huber 1964; docs/method.md §6.1).
  const F huber(in.huber);
  pair.weight = F(1.0f);
  if (!in.noise.is_uniform()) pair.weight = in.noise.weight(depth);
  if (in.huber < kNoDistance) pair.weight = pair.weight * (huber / max(abs(pair.residual), huber));

  const auto code = [](PixelUse use) { return F(static_cast<float>(use)); };
  pair.use = select(pair.used, code(PixelUse::used), code(PixelUse::filtered));
  pair.use = select(aligned, pair.use, code(PixelUse::angle));
  pair.use = select(near, pair.use, code(PixelUse::distance));
  pair.use = select(has_model, pair.use, code(PixelUse::no_model));
  pair.use = select(in_view, pair.use, code(PixelUse::out_of_view));
  pair.use = select(has_normal, pair.use, code(PixelUse::no_normal));
  pair.use = select(pair.has_depth, pair.use, code(PixelUse::no_depth));
  return pair;
}

/// Adds the pairs of `chosen`, times `sign`, to the normal equations. With p ← exp(ξ) p the residual n·(q − p) changes
/// by −[(p × n)·ω + n·v], so a row of A is (p × n, n) and b is the residual (Low 2004).
template <class F, class Accumulator>
PL_HD void add_equations(const IcpPair<F>& pair, const Mask<F>& chosen, const F& sign, Accumulator& sums) {
  const F zero(0.0f);
  const Vec3<F> moment = cross(pair.point, pair.normal);
  const F a[6] = {select(chosen, moment.x, zero),      select(chosen, moment.y, zero),
                  select(chosen, moment.z, zero),      select(chosen, pair.normal.x, zero),
                  select(chosen, pair.normal.y, zero), select(chosen, pair.normal.z, zero)};
  const F b = select(chosen, pair.residual, zero);
  const F weight = select(chosen, pair.weight * sign, zero);
  const F wb = weight * b;
  int slot = icp_sum::kHessian;
  for (int i = 0; i < 6; ++i) {
    const F wa = weight * a[i];
    for (int j = i; j < 6; ++j) sums.add_product(slot++, wa, a[j]);
    sums.add_product(icp_sum::kGradient + i, a[i], wb);
  }
  sums.add_product(icp_sum::kSquares, b * sign, b);
  sums.add(icp_sum::kInliers, select(chosen, sign, zero));
}

/// One iteration's sums. If `distances` has memory, each pixel gets the distance of its pair, or infinity, for
/// `IcpCorrection`.
struct IcpReduce {
  IcpInput in;
  PlaneView<float> distances = {};

  template <class F, class Accumulator>
  PL_HD void operator()(int x, int y, Accumulator& sums) const {
    const F zero(0.0f), one(1.0f);
    if (!any(inside_row<F>(x, in.live_depth.width) && load<F>(in.live_depth.row(y) + x) > zero)) {
      if (distances.data != nullptr)
        store_masked<F>(distances.row(y) + x, F(kNoDistance), inside_row<F>(x, distances.width));
      return;
    }
    const IcpPair<F> pair = associate<F>(in, x, y);
    if (distances.data != nullptr)
      store_masked<F>(distances.row(y) + x, select(pair.in_distribution, pair.distance, F(kNoDistance)),
                      inside_row<F>(x, distances.width));
    sums.add(icp_sum::kWithDepth, select(pair.has_depth, one, zero));
    if (!any(pair.in_distribution)) return;
    sums.add(icp_sum::kPairs, select(pair.in_distribution, one, zero));
    if (in.bins > 0) {
      // Bin `bins` counts what lies beyond the range, bin `bins + 1` what is no pair at all.
      const F bin = min(pair.distance * in.bins_per_metre, F(static_cast<float>(in.bins)));
      sums.count(to_int(select(pair.in_distribution, bin, F(static_cast<float>(in.bins + 1)))));
    }
    if (any(pair.used)) add_equations(pair, pair.used, one, sums);
  }
};

/// What a pass with the band [`from_low`, `from_high`] must be given to become one with the band of `in`: the median
/// filter needs the median of the same iteration, which is known only when the pass is through (docs/method.md §4).
/// Only the few pixels between the bands are associated again; their equations are added or taken away.
struct IcpCorrection {
  IcpInput in;
  float from_low, from_high;
  PlaneView<const float> distances;  ///< of the pass

  template <class F, class Accumulator>
  PL_HD void operator()(int x, int y, Accumulator& sums) const {
    const F distance = load<F>(distances.row(y) + x);
    const auto was_in = distance >= F(from_low) && distance <= F(from_high);
    const auto is_in = distance >= F(in.band_low) && distance <= F(in.band_high);
    const auto joins = is_in && !was_in, leaves = was_in && !is_in;
    if (!any(joins || leaves)) return;
    IcpInput open = in;
    open.band_low = 0;
    open.band_high = kNoDistance;
    const IcpPair<F> pair = associate<F>(open, x, y);
    add_equations(pair, pair.used && (joins || leaves), select(joins, F(1.0f), F(-1.0f)), sums);
  }
};

/// Writes why each pixel was or was not used.
struct ExplainPixels {
  IcpInput in;
  PlaneView<std::uint8_t> use;

  template <class F>
  PL_HD void operator()(int x, int y) const {
    store_u8(use.row(y) + x, select(inside_row<F>(x, use.width), associate<F>(in, x, y).use, F(0.0f)));
  }
};

}  // namespace plumbline::kernels
