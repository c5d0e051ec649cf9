// Prediction of what the camera sees of the model: the zero crossing along each pixel's ray, and its normal.
#pragma once

#include "kernels/brick_map.h"
#include "kernels/distance_sampler.h"
#include "kernels/integrate.h"
#include "kernels/lane.h"
#include "kernels/preprocess.h"
#include "kernels/voxel.h"
#include "plumbline/pinhole.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

constexpr int kRayTileShift = 3;
constexpr int kRayTile = 1 << kRayTileShift;  ///< pixels per side of a tile of rays

/// Per tile of the predicted image: between which depths its rays can meet a brick that holds a surface.
struct RaySpanView {
  float* nearest = nullptr;   ///< kNoRange where a tile sees no such brick
  float* farthest = nullptr;  ///< 0 there
  int columns = 0, rows = 0, stride = 0;
};

/// A rectangle of tiles, its last column and row included.
template <class F>
struct RayTiles {
  Int<F> x0, x1, y0, y1;
};

/// Finds them by projecting the bricks. Lanes run along x over bricks.
struct RaySpans {
  BrickMap volume;
  RaySpanView spans;
  Pinhole camera;
  RigidTransform camera_from_volume;
  float min_distance;  ///< metres

  /// `tiles` gets a call of widen(valid, rectangles, nearest, farthest) for bricks in view.
  template <class F, class Tiles>
  PL_HD void operator()(int x, int row, Tiles& tiles) const {
    const BrickLanes<F> bricks = volume.bricks_at<F>(x, row);
    auto seen = bricks.exist() && equal(bricks.states(), Int<F>(kBrickSolid));
    if (!any(seen)) return;
    const float half = 0.501f * volume.brick_size();  // a hair more than the brick
    const Vec3<F> centre = camera_from_volume.apply(bricks.centres());
    const float* r = camera_from_volume.r;
    const F reach(half * (abs(r[6]) + abs(r[7]) + abs(r[8])));
    const F near = max(centre.z - reach, F(min_distance)), far = centre.z + reach;
    seen = seen && far > F(min_distance);

    // A brick around the camera's plane may be anywhere.
    const auto beyond = centre.z - reach > F(1e-2f);
    F u0(1e30f), u1(-1e30f), v0(1e30f), v1(-1e30f);
    for (int corner = 0; corner < 8; ++corner) {
      const float dx = corner & 1 ? half : -half, dy = corner & 2 ? half : -half, dz = corner & 4 ? half : -half;
      const F inverse = F(1.0f) / select(beyond, centre.z + (r[6] * dx + r[7] * dy + r[8] * dz), F(1.0f));
      const F u = madd((centre.x + (r[0] * dx + r[1] * dy + r[2] * dz)) * inverse, F(camera.fx), F(camera.cx));
      const F v = madd((centre.y + (r[3] * dx + r[4] * dy + r[5] * dz)) * inverse, F(camera.fy), F(camera.cy));
      u0 = min(u0, u);
      u1 = max(u1, u);
      v0 = min(v0, v);
      v1 = max(v1, v);
    }
    const float last_u = static_cast<float>(camera.width - 1), last_v = static_cast<float>(camera.height - 1);
    seen = seen && (!beyond || (u0 <= F(last_u) && u1 >= F(0.0f) && v0 <= F(last_v) && v1 >= F(0.0f)));
    if (!any(seen)) return;
    const auto tile = [&](const F& pixel, float whole, float last) {
      return shift_right<kRayTileShift>(to_int(min(max(select(beyond, pixel, F(whole)), F(0.0f)), F(last))));
    };
    tiles.template widen<F>(
        seen, RayTiles<F>{tile(u0, 0, last_u), tile(u1, last_u, last_u), tile(v0, 0, last_v), tile(v1, last_v, last_v)},
        near, far);
  }
};

/// Casts one ray a pixel (Newcombe et al. 2011, §3.3). The ray parameter t is the depth along the optical axis, so the
/// parameter of the hit *is* the predicted depth. Bricks without a voxel behind a surface are skipped whole. Lanes are
/// a block of rays: neighbours are through after about as many steps.
struct Raycast {
  BrickMap volume;
  PlaneView<float> depth;
  NormalPlanes normals;  ///< in the camera's frame
  Pinhole camera;
  RigidTransform volume_from_camera;
  float min_distance, max_distance;  ///< metres along the optical axis
  RaySpanView spans = {};            ///< of the same camera and volume; without them rays are walked from end to end

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const float per_metre = 1.0f / volume.voxel_size;
    const F u = Block<F>::columns() + static_cast<float>(x), v = Block<F>::rows() + static_cast<float>(y);
    const Vec3<F> direction = volume_from_camera.rotate(camera.back_project(u, v, F(1.0f))) * per_metre;
    const Ray<F> ray = {{F(volume_from_camera.t[0] * per_metre), F(volume_from_camera.t[1] * per_metre),
                         F(volume_from_camera.t[2] * per_metre)},
                        direction,
                        reciprocal(direction)};

    F t(min_distance), end(max_distance);
    clip<F>(ray, &t, &end);
    if (spans.nearest != nullptr) {
      const int tile = (y >> kRayTileShift) * spans.stride + (x >> kRayTileShift);  // a block lies in one tile
      t = max(t, F(spans.nearest[tile]));
      end = min(end, F(spans.farthest[tile]));
    }
    const auto active = u < F(static_cast<float>(depth.width)) && v < F(static_cast<float>(depth.height)) && t < end;
    F before(0.0f), after(0.0f), t_before(0.0f);
    auto hit = march<F>(ray, active, end, &t, &t_before, &before, &after);

    Vec3<F> normal = {F(0.0f), F(0.0f), F(0.0f)};
    if (any(hit)) {
      t = refine<F>(ray, t_before, t, before, after, &hit);
      normal = surface_normal<F>(ray, t, u, v, &hit);
    }
    store_block<F>(depth, x, y, t, hit);
    store_block<F>(normals.x, x, y, normal.x, hit);
    store_block<F>(normals.y, x, y, normal.y, hit);
    store_block<F>(normals.z, x, y, normal.z, hit);
  }

 private:
  /// A ray in units of voxels; its direction is that of one metre of depth.
  template <class F>
  struct Ray {
    Vec3<F> origin, direction, inverse_direction;

    PL_HD Vec3<F> at(const F& t) const {
      return {madd(direction.x, t, origin.x), madd(direction.y, t, origin.y), madd(direction.z, t, origin.z)};
    }
    /// Where the centres of voxels are integers.
    PL_HD Vec3<F> grid_at(const F& t) const {
      const Vec3<F> p = at(t);
      return {p.x - 0.5f, p.y - 0.5f, p.z - 0.5f};
    }
  };

  template <class F>
  PL_HD static Vec3<F> reciprocal(const Vec3<F>& d) {
    const F tiny(1e-12f), one(1.0f);
    return {one / select(abs(d.x) > tiny, d.x, tiny), one / select(abs(d.y) > tiny, d.y, tiny),
            one / select(abs(d.z) > tiny, d.z, tiny)};
  }

  /// Keeps the part of the ray inside the volume (slab test).
  template <class F>
  PL_HD void clip(const Ray<F>& ray, F* start, F* end) const {
    const float high = static_cast<float>(volume.resolution());
    const F o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
    const F inverse[3] = {ray.inverse_direction.x, ray.inverse_direction.y, ray.inverse_direction.z};
    for (int axis = 0; axis < 3; ++axis) {
      const F t0 = (F(0.0f) - o[axis]) * inverse[axis], t1 = (F(high) - o[axis]) * inverse[axis];
      *start = max(*start, min(t0, t1));
      *end = min(*end, max(t0, t1));
    }
  }

  /// The depth at which a ray leaves brick b is, on each axis, b·per_brick + from_origin.
  template <class F>
  struct BrickEnd {
    Vec3<F> per_brick, from_origin;

    PL_HD explicit BrickEnd(const Ray<F>& ray) {
      const float side = static_cast<float>(kBrickSide);
      const auto axis = [&](const F& direction, const F& origin, const F& inverse, F* per, F* from) {
        *per = inverse * side;
        *from = (select(direction > F(0.0f), F(side), F(0.0f)) - origin) * inverse;
      };
      axis(ray.direction.x, ray.origin.x, ray.inverse_direction.x, &per_brick.x, &from_origin.x);
      axis(ray.direction.y, ray.origin.y, ray.inverse_direction.y, &per_brick.y, &from_origin.y);
      axis(ray.direction.z, ray.origin.z, ray.inverse_direction.z, &per_brick.z, &from_origin.z);
    }
    PL_HD F leaves_at(const Vec3<F>& brick) const {
      return min(min(madd(brick.x, per_brick.x, from_origin.x), madd(brick.y, per_brick.y, from_origin.y)),
                 madd(brick.z, per_brick.z, from_origin.z));
    }
  };

  /// Steps along the rays until the signed distance turns from positive to negative between two voxels that were seen.
  /// On return `t` lies behind the crossing and `t_before` before it.
  template <class F>
  PL_HD Mask<F> march(const Ray<F>& ray, Mask<F> active, const F& end, F* t, F* t_before, F* before, F* after) const {
    const F zero(0.0f), one(1.0f), voxel_step = one / sqrt(dot(ray.direction, ray.direction));
    const F longest(0.85f * volume.truncation / volume.voxel_size);
    const BrickEnd<F> brick_end(ray);
    auto hit = active && !active;
    F previous = zero, t_previous = *t;
    while (any(active)) {
      const VoxelLanes<F> here = volume.voxels_at<F>(ray.at(*t));
      const auto solid = active && equal(volume.states_of(here), Int<F>(kBrickSolid));
      F value = zero, step = zero;
      if (any(solid)) {
        value = select(solid, distance_of<F>(volume.words_of(here)), zero);
        // A projective distance over-estimates when seen from elsewhere, hence the factor.
        step = max(value * longest, one) * voxel_step;
        const auto inside = solid && value < zero;
        if (any(inside)) {
          // The first voxel of a solid brick may lie behind the surface already.
          const auto unseen = inside && previous == zero;
          if (any(unseen)) {
            const F back = *t - voxel_step;
            const F seen = distance_of<F>(volume.words_of(volume.voxels_at<F>(ray.at(back))));
            previous = select(unseen, seen, previous);
            t_previous = select(unseen, back, t_previous);
          }
          const auto crossing = inside && previous > zero;
          *t_before = select(crossing, t_previous, *t_before);
          *before = select(crossing, previous, *before);
          *after = select(crossing, value, *after);
          hit = hit || crossing;
          active = active && !crossing;
        }
        // From inside the surface outwards: the back of something, nothing to predict (KinFu stops here too).
        active = active && !(previous < zero && value > zero);
      }
      if (any(active && !solid)) {
        // A brick is left by a hair's breadth, so that the next look-up falls into its neighbour.
        const F leaves = brick_end.leaves_at(here.brick_position());
        step = select(solid, step, madd(voxel_step, F(0.01f), max(leaves - *t, zero)));
      }
      previous = select(active, value, previous);
      t_previous = select(active, *t, t_previous);
      *t = select(active, *t + step, *t);
      active = active && *t < end;
    }
    return hit;
  }

  /// The crossing between two samples, first by their nearest voxels, then by two secant steps on the trilinear field.
  template <class F>
  PL_HD F refine(const Ray<F>& ray, const F& t_before, const F& t_after, const F& before, const F& after,
                 Mask<F>* hit) const {
    const DistanceSampler<F> sampler{volume};
    const F zero(0.0f), voxel_step = F(1.0f) / sqrt(dot(ray.direction, ray.direction));
    const F low = t_before - voxel_step, high = t_after + voxel_step;
    F t0 = t_before + (t_after - t_before) * before / select(*hit, before - after, F(1.0f));
    *hit = *hit && sampler.inside(ray.grid_at(t0));
    const F f0 = sampler.trilinear(ray.grid_at(t0), hit);
    // Seen from where it was measured, the distance falls by one truncation per truncation of depth.
    F t1 = min(max(madd(f0, F(volume.truncation), t0), low), high);
    *hit = *hit && sampler.inside(ray.grid_at(t1));
    const F f1 = sampler.trilinear(ray.grid_at(t1), hit);
    const F slope = f1 - f0;
    const auto usable = abs(slope) > abs(f1) * 0.3f && abs(slope) > F(1e-6f);
    const F t2 = t1 - select(usable, f1 * (t1 - t0) / select(usable, slope, F(1.0f)), zero);
    return min(max(t2, low), high);
  }

  template <class F>
  PL_HD Vec3<F> surface_normal(const Ray<F>& ray, const F& t, const F& u, const F& v, Mask<F>* hit) const {
    const DistanceSampler<F> sampler{volume};
    const Vec3<F> grid = ray.grid_at(t);
    *hit = *hit && sampler.inside(grid);
    const Vec3<F> g = sampler.gradient(grid, hit);
    *hit = *hit && dot(g, g) > F(1e-10f);
    const float* r = volume_from_camera.r;  // its transpose turns into the camera's frame
    const Vec3<F> in_camera = {r[0] * g.x + r[3] * g.y + r[6] * g.z, r[1] * g.x + r[4] * g.y + r[7] * g.z,
                               r[2] * g.x + r[5] * g.y + r[8] * g.z};
    const F scale = F(1.0f) / sqrt(select(*hit, dot(in_camera, in_camera), F(1.0f)));
    const Vec3<F> normal = in_camera * scale;
    // The distance grows towards the camera; a normal that looks away belongs to a surface seen from behind.
    *hit = *hit && dot(normal, camera.back_project(u, v, F(1.0f))) < F(0.0f);
    return normal;
  }
};

/// The model's pyramid: depth and normal of 2×2 predicted pixels averaged where all four exist and lie on one surface.
struct DecimateModel {
  PlaneView<const float> fine_depth;
  PlaneView<const float> fine_x, fine_y, fine_z;
  PlaneView<float> coarse_depth;
  NormalPlanes coarse_normals;
  float range;  ///< largest spread of the four depths, metres

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const Int<F> even = shift_left<1>(Lane<F>::int_index());
    F low(1e30f), high(0.0f), sum(0.0f);
    Vec3<F> n = {F(0.0f), F(0.0f), F(0.0f)};
    for (int k = 0; k < 4; ++k) {
      const int fx = 2 * x + k % 2, fy = 2 * y + k / 2;
      const F z = gather(fine_depth.row(fy) + fx, even);
      low = min(low, z);
      high = max(high, z);
      sum = sum + z;
      n = n + Vec3<F>{gather(fine_x.row(fy) + fx, even), gather(fine_y.row(fy) + fx, even),
                      gather(fine_z.row(fy) + fx, even)};
    }
    const F squared = dot(n, n);
    const auto valid =
        inside_row<F>(x, coarse_depth.width) && low > F(0.0f) && high - low <= F(range) && squared > F(1e-6f);
    store_masked<F>(coarse_depth.row(y) + x, sum * 0.25f, valid);
    store_normal<F>(coarse_normals, x, y, n * (F(1.0f) / sqrt(select(valid, squared, F(1.0f)))), valid);
  }
};

}  // namespace plumbline::kernels
