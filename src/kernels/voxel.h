// One voxel: what its 32-bit word holds.
#pragma once

#include "kernels/lane.h"

namespace plumbline::kernels {

constexpr float kDistanceScale = 32767.0f;  ///< stored units per truncation distance

/// Signed distance in truncation units (positive is free), and weight. Stored as one word: the low half the distance in
/// 1/32767 of the truncation distance, the high half the weight; zero is "never seen".
template <class F>
struct Voxel {
  F distance, weight;
};

/// The distance alone, in truncation units; 0 of what was never seen.
template <class F>
PL_HD F distance_of(const Int<F>& word) {
  return to_float(shift_left<16>(word)) * (1.0f / (65536.0f * kDistanceScale));
}
template <class F>
PL_HD Voxel<F> unpack(const Int<F>& word) {
  return {distance_of<F>(word), to_float(shift_right<16>(word) & Int<F>(0xFFFF))};
}
template <class F>
PL_HD Int<F> pack(const Voxel<F>& voxel) {
  const Int<F> distance = to_int(floor(madd(voxel.distance, F(kDistanceScale), F(0.5f))));
  return (distance & Int<F>(0xFFFF)) | shift_left<16>(to_int(voxel.weight));
}

}  // namespace plumbline::kernels
