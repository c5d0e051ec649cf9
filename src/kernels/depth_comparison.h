// Whether what a camera measures is what the model shows at its pose: reading by reading along the same ray.
#pragma once

#include "kernels/lane.h"

namespace plumbline::kernels {

/// Slots of the sums that one comparison makes, in pixels.
namespace depth_comparison {
constexpr int kReadings = 0;    ///< live pixels with a reading
constexpr int kKnown = 1;       ///< of these, where the model has a surface
constexpr int kSeeThrough = 2;  ///< of these, measured behind the model's surface: the model is in free space
constexpr int kMatched = 3;     ///< of the known ones, measured at the model's surface
constexpr int kCount = 4;
}  // namespace depth_comparison

/// A tolerance in metres that grows with the depth, as a triangulating sensor's errors do.
struct DepthTolerance {
  float metres = 0, of_depth = 0;

  template <class F>
  PL_HD F at(const F& depth) const {
    return max(F(metres), depth * of_depth);
  }
};

/// Sums for two depth images of one camera at one pose, metres (docs/method.md §9).
struct CompareDepth {
  PlaneView<const float> live, model;
  DepthTolerance behind = {0.10f, 0.05f};  ///< beyond this a reading lies behind the surface
  DepthTolerance match = {0.05f, 0.03f};   ///< within this it lies on it

  template <class F, class Accumulator>
  PL_HD void operator()(int x, int y, Accumulator& sums) const {
    const F zero(0.0f), one(1.0f);
    const F measured = load<F>(live.row(y) + x), predicted = load<F>(model.row(y) + x);
    const auto reads = inside_row<F>(x, live.width) && measured > zero;
    if (!any(reads)) return;
    const auto known = reads && predicted > zero;
    const F difference = measured - predicted;
    sums.add(depth_comparison::kReadings, select(reads, one, zero));
    sums.add(depth_comparison::kKnown, select(known, one, zero));
    sums.add(depth_comparison::kSeeThrough, select(known && difference > behind.at<F>(predicted), one, zero));
    sums.add(depth_comparison::kMatched, select(known && abs(difference) < match.at<F>(predicted), one, zero));
  }
};

}  // namespace plumbline::kernels
