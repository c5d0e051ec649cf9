// The signed distance between voxels.
#pragma once

#include "kernels/brick_map.h"
#include "kernels/lane.h"
#include "kernels/voxel.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// Reads the signed distance between voxels. Grid coordinates: voxel centres lie at integers.
template <class F>
struct DistanceSampler {
  const BrickMap& volume;

  /// Lanes whose eight surrounding voxels exist.
  PL_HD Mask<F> inside(const Vec3<F>& grid) const {
    const F high(static_cast<float>(volume.resolution()) - 1.001f), zero(0.0f);
    return grid.x >= zero && grid.y >= zero && grid.z >= zero && grid.x <= high && grid.y <= high && grid.z <= high;
  }

  /// Trilinear signed distance in truncation units; `known` loses lanes with a voxel that was never seen. Lanes out of
  /// the volume must be masked out by `known` beforehand; they read voxel 0.
  PL_HD F trilinear(const Vec3<F>& grid, Mask<F>* known) const {
    const Cell cell(volume, grid, *known);
    F value[8];
    cell.read(value, known);
    return blend(value, cell.fraction);
  }

  /// Gradient of the signed distance in grid axes (unscaled) by differences over two voxels of the trilinear field. A
  /// missing outer voxel is extrapolated from the two inside it; the inner eight must be known.
  PL_HD Vec3<F> gradient(const Vec3<F>& grid, Mask<F>* known) const {
    const Cell cell(volume, grid, *known);
    F value[8];
    cell.read(value, known);
    const F ax = cell.fraction.x, ay = cell.fraction.y, az = cell.fraction.z;
    return {along(value, 1, ax, 2, ay, 4, az, cell.voxels, 0), along(value, 2, ay, 1, ax, 4, az, cell.voxels, 1),
            along(value, 4, az, 1, ax, 2, ay, cell.voxels, 2)};
  }

 private:
  /// The voxels around a position, and where it lies between them.
  struct Cell {
    Vec3<F> lowest;
    VoxelNeighbours<F> voxels;
    Vec3<F> fraction;

    PL_HD Cell(const BrickMap& map, const Vec3<F>& grid, const Mask<F>& valid)
        : lowest{floor(select(valid, grid.x, F(0.0f))), floor(select(valid, grid.y, F(0.0f))),
                 floor(select(valid, grid.z, F(0.0f)))},
          voxels(map, to_int(lowest.x), to_int(lowest.y), to_int(lowest.z)),
          fraction{grid.x - lowest.x, grid.y - lowest.y, grid.z - lowest.z} {}

    PL_HD void read(F (&value)[8], Mask<F>* known) const {
      for (int c = 0; c < 8; ++c) {
        const Voxel<F> voxel = unpack<F>(voxels.corner(c));
        value[c] = voxel.distance;
        *known = *known && voxel.weight > F(0.0f);
      }
    }
  };

  PL_HD static F blend(const F (&v)[8], const Vec3<F>& fraction) {
    const F ax = fraction.x, ay = fraction.y, az = fraction.z;
    const F x00 = madd(ax, v[1] - v[0], v[0]), x10 = madd(ax, v[3] - v[2], v[2]);
    const F x01 = madd(ax, v[5] - v[4], v[4]), x11 = madd(ax, v[7] - v[6], v[6]);
    const F y0 = madd(ay, x10 - x00, x00), y1 = madd(ay, x11 - x01, x01);
    return madd(az, y1 - y0, y0);
  }

  /// Difference along one axis, bilinear over the two others. `step`, `step_p` and `step_q` are the strides of the axes
  /// in `value`, `a`, `p` and `q` the fractions.
  PL_HD static F along(const F (&value)[8], int step, const F& a, int step_p, const F& p, int step_q, const F& q,
                       const VoxelNeighbours<F>& voxels, int axis) {
    Int<F> words_before[4], words_after[4];
    voxels.beyond(axis, words_before, words_after);
    F difference[4];
    for (int k = 0; k < 4; ++k) {
      const int base = (k & 1) * step_p + (k >> 1) * step_q;
      const F f0 = value[base], f1 = value[base + step];
      const Voxel<F> before = unpack<F>(words_before[k]), after = unpack<F>(words_after[k]);
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
