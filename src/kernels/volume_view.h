// The truncated signed distance volume as kernels see it: a dense cube stored in bricks of 8³ voxels.
#pragma once

#include "kernels/lane.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

constexpr int kBrickSide = 8;
constexpr int kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;
/// What `occupied` says of a brick. One that is solid holds a voxel behind a surface; one that is free held a surface
/// once, but now only voxels before it.
constexpr std::int32_t kBrickSolid = 1, kBrickFree = 2;
constexpr float kDistanceScale = 32767.0f;  ///< stored units per truncation distance

/// Voxel (i, j, k) is centred at (i + ½, j + ½, k + ½)·voxel_size in the volume's frame. A voxel is one 32-bit word:
/// the low half its signed distance in 1/32767 of the truncation distance (positive is free), the high half its weight;
/// zero is "never seen". All indexing stands here.
struct VolumeView {
  std::int32_t* voxels = nullptr;
  std::int32_t* colors = nullptr;    ///< null without colour; a byte each of red, green, blue and weight
  std::int32_t* occupied = nullptr;  ///< per brick: not 0 if it has held a surface
  int bricks = 0;                    ///< per side
  int brick_stride = 0;              ///< bricks from one row of bricks to the next, ≥ bricks, a multiple of 16
  float voxel_size = 0;              ///< metres
  float truncation = 0;              ///< metres

  PL_HD int resolution() const { return bricks * kBrickSide; }

  template <class I>
  PL_HD I brick_index(const I& bx, const I& by, const I& bz) const {
    return (bz * I(bricks) + by) * I(brick_stride) + bx;
  }
  // A voxel's index is the sum of one term an axis, so that neighbours share terms.
  template <class I>
  PL_HD I term_x(const I& x) const {
    return shift_left<9>(shift_right<3>(x)) + (x & I(7));
  }
  template <class I>
  PL_HD I term_y(const I& y) const {
    return shift_left<9>(shift_right<3>(y) * I(brick_stride)) + shift_left<3>(y & I(7));
  }
  template <class I>
  PL_HD I term_z(const I& z) const {
    return shift_left<9>(shift_right<3>(z) * I(brick_stride * bricks)) + shift_left<6>(z & I(7));
  }
  template <class I>
  PL_HD I index(const I& x, const I& y, const I& z) const {
    return term_x(x) + term_y(y) + term_z(z);
  }
};

/// Signed distance in truncation units, and weight.
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

/// Reads the signed distance between voxels. Grid coordinates: voxel centres lie at integers.
template <class F>
struct DistanceSampler {
  const VolumeView& volume;

  /// Lanes whose eight surrounding voxels exist.
  PL_HD Mask<F> inside(const Vec3<F>& grid) const {
    const F high(static_cast<float>(volume.resolution()) - 1.001f), zero(0.0f);
    return grid.x >= zero && grid.y >= zero && grid.z >= zero && grid.x <= high && grid.y <= high && grid.z <= high;
  }

  /// Trilinear signed distance in truncation units; `known` loses lanes with a voxel that was never seen. Lanes out of
  /// the volume must be masked out by `known` beforehand; they read voxel 0.
  PL_HD F trilinear(const Vec3<F>& grid, Mask<F>* known) const {
    const Cell cell = locate(grid, *known);
    F value[8];
    read(cell, value, known);
    return blend(value, cell);
  }

  /// Gradient of the signed distance in grid axes (unscaled) by differences over two voxels of the trilinear field. A
  /// missing outer voxel is extrapolated from the two inside it; the inner eight must be known.
  PL_HD Vec3<F> gradient(const Vec3<F>& grid, Mask<F>* known) const {
    const Cell cell = locate(grid, *known);
    F value[8];
    read(cell, value, known);
    const F ax = cell.fraction.x, ay = cell.fraction.y, az = cell.fraction.z;
    return {along(value, 1, ax, 2, ay, 4, az, outer(cell.first[0], 0), cell.y, cell.z),
            along(value, 2, ay, 1, ax, 4, az, outer(cell.first[1], 1), cell.x, cell.z),
            along(value, 4, az, 1, ax, 2, ay, outer(cell.first[2], 2), cell.x, cell.y)};
  }

 private:
  /// The eight voxels around a position: index terms of the lower and upper neighbour on each axis.
  struct Cell {
    Int<F> x[2], y[2], z[2];
    Int<F> first[3];
    Vec3<F> fraction;
  };
  /// Index terms of the voxels before and after a cell along one axis, clamped to the volume.
  struct Outer {
    Int<F> before, after;
  };

  PL_HD Cell locate(const Vec3<F>& grid, const Mask<F>& valid) const {
    const F zero(0.0f);
    const F x0 = floor(select(valid, grid.x, zero)), y0 = floor(select(valid, grid.y, zero)),
            z0 = floor(select(valid, grid.z, zero));
    const Int<F> x = to_int(x0), y = to_int(y0), z = to_int(z0), one(1);
    return {{volume.term_x(x), volume.term_x(x + one)},
            {volume.term_y(y), volume.term_y(y + one)},
            {volume.term_z(z), volume.term_z(z + one)},
            {x, y, z},
            {grid.x - x0, grid.y - y0, grid.z - z0}};
  }

  PL_HD void read(const Cell& cell, F (&value)[8], Mask<F>* known) const {
    for (int c = 0; c < 8; ++c) {
      const Voxel<F> voxel = unpack<F>(gather_int(volume.voxels, cell.x[c & 1] + cell.y[c >> 1 & 1] + cell.z[c >> 2]));
      value[c] = voxel.distance;
      *known = *known && voxel.weight > F(0.0f);
    }
  }

  PL_HD static F blend(const F (&v)[8], const Cell& cell) {
    const F ax = cell.fraction.x, ay = cell.fraction.y, az = cell.fraction.z;
    const F x00 = madd(ax, v[1] - v[0], v[0]), x10 = madd(ax, v[3] - v[2], v[2]);
    const F x01 = madd(ax, v[5] - v[4], v[4]), x11 = madd(ax, v[7] - v[6], v[6]);
    const F y0 = madd(ay, x10 - x00, x00), y1 = madd(ay, x11 - x01, x01);
    return madd(az, y1 - y0, y0);
  }

  PL_HD Outer outer(const Int<F>& first, int axis) const {
    const Int<F> before = max_int(first - Int<F>(1), Int<F>(0));
    const Int<F> after = min_int(first + Int<F>(2), Int<F>(volume.resolution() - 1));
    if (axis == 0) return {volume.term_x(before), volume.term_x(after)};
    if (axis == 1) return {volume.term_y(before), volume.term_y(after)};
    return {volume.term_z(before), volume.term_z(after)};
  }

  /// Difference along one axis, bilinear over the two others. `step`, `step_p` and `step_q` are the strides of the axes
  /// in `value`, `a`, `p` and `q` the fractions.
  PL_HD F along(const F (&value)[8], int step, const F& a, int step_p, const F& p, int step_q, const F& q,
                const Outer& outer, const Int<F> (&terms_p)[2], const Int<F> (&terms_q)[2]) const {
    F difference[4];
    for (int k = 0; k < 4; ++k) {
      const int base = (k & 1) * step_p + (k >> 1) * step_q;
      const F f0 = value[base], f1 = value[base + step];
      const Int<F> rest = terms_p[k & 1] + terms_q[k >> 1];
      const Voxel<F> before = unpack<F>(gather_int(volume.voxels, outer.before + rest));
      const Voxel<F> after = unpack<F>(gather_int(volume.voxels, outer.after + rest));
      const F fm = select(before.weight > F(0.0f), before.distance, f0 + f0 - f1);
      const F f2 = select(after.weight > F(0.0f), after.distance, f1 + f1 - f0);
      difference[k] = madd(a, (f2 - f0) - (f1 - fm), f1 - fm);
    }
    const F low = madd(p, difference[1] - difference[0], difference[0]);
    const F high = madd(p, difference[3] - difference[2], difference[2]);
    return madd(q, high - low, low);
  }
};

}  // namespace plumbline::kernels
