// Prediction of what the camera sees of the model: the zero crossing along each pixel's ray, and its normal.
#pragma once

#include "core/pinhole.h"
#include "core/vec3.h"
#include "kernels/lane.h"
#include "kernels/preprocess.h"
#include "kernels/volume_view.h"

namespace plumbline::kernels {

/// Casts one ray a pixel (Newcombe et al. 2011, §3.3). The ray parameter t is the depth along the optical axis, so the
/// parameter of the hit *is* the predicted depth. Bricks that hold no surface are skipped whole.
struct Raycast {
  VolumeView volume;
  PlaneView<float> depth;
  NormalPlanes normals;  ///< in the camera's frame
  Pinhole camera;
  RigidTransform volume_from_camera;
  float min_distance, max_distance;  ///< metres along the optical axis

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const float per_metre = 1.0f / volume.voxel_size;
    const F u = Lane<F>::index() + static_cast<float>(x);
    const Vec3<F> direction =
        volume_from_camera.rotate(camera.back_project(u, F(static_cast<float>(y)), F(1.0f))) * per_metre;
    const Ray<F> ray = {{F(volume_from_camera.t[0] * per_metre), F(volume_from_camera.t[1] * per_metre),
                         F(volume_from_camera.t[2] * per_metre)},
                        direction,
                        reciprocal(direction)};

    F t(min_distance), end(max_distance);
    clip<F>(ray, &t, &end);
    const auto active = inside_row<F>(x, depth.width) && t < end;
    F before(0.0f), after(0.0f), t_before(0.0f);
    auto hit = march<F>(ray, active, end, &t, &t_before, &before, &after);

    Vec3<F> normal = {F(0.0f), F(0.0f), F(0.0f)};
    if (any(hit)) {
      t = refine<F>(ray, t_before, t, before, after, &hit);
      normal = surface_normal<F>(ray, t, u, static_cast<float>(y), &hit);
    }
    store_masked<F>(depth.row(y) + x, t, hit);
    store_normal<F>(normals, x, y, normal, hit);
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

  /// Depth at which the ray leaves the brick that holds p.
  template <class F>
  PL_HD static F leaves_brick_at(const Ray<F>& ray, const F& bx, const F& by, const F& bz) {
    const float side = static_cast<float>(kBrickSide);
    const auto far_side = [&](const F& brick, const F& direction, const F& origin, const F& inverse) {
      const F plane = (brick + select(direction > F(0.0f), F(1.0f), F(0.0f))) * side;
      return (plane - origin) * inverse;
    };
    return min(min(far_side(bx, ray.direction.x, ray.origin.x, ray.inverse_direction.x),
                   far_side(by, ray.direction.y, ray.origin.y, ray.inverse_direction.y)),
               far_side(bz, ray.direction.z, ray.origin.z, ray.inverse_direction.z));
  }

  /// Steps along the rays until the signed distance turns from positive to negative between two voxels that were seen.
  /// On return `t` lies behind the crossing and `t_before` before it.
  template <class F>
  PL_HD Mask<F> march(const Ray<F>& ray, Mask<F> active, const F& end, F* t, F* t_before, F* before, F* after) const {
    const F zero(0.0f), voxel_step = F(1.0f) / sqrt(dot(ray.direction, ray.direction));
    const float truncation_voxels = volume.truncation / volume.voxel_size;
    const F highest(static_cast<float>(volume.resolution() - 1));
    auto hit = active && !active;
    F previous = zero, t_previous = *t;
    while (any(active)) {
      const Vec3<F> p = ray.at(*t);
      const auto clamped = [&](const F& c) { return min(max(floor(c), zero), highest); };
      const Int<F> x = to_int(clamped(p.x)), y = to_int(clamped(p.y)), z = to_int(clamped(p.z));
      const Int<F> bx = shift_right<3>(x), by = shift_right<3>(y), bz = shift_right<3>(z);
      const auto occupied = active && to_float(gather_int(volume.occupied, volume.brick_index(bx, by, bz))) > F(0.5f);
      // An empty brick is left by a hair's breadth, so that the next look-up falls into its neighbour.
      F step = max(leaves_brick_at(ray, to_float(bx), to_float(by), to_float(bz)) - *t, zero) + voxel_step * 0.01f;
      F value = zero;
      if (any(occupied)) {
        const Voxel<F> voxel = unpack<F>(gather_int(volume.voxels, volume.index(x, y, z)));
        const auto known = occupied && voxel.weight > zero;
        value = select(known, voxel.distance, zero);
        const auto crossing = known && previous > zero && value < zero;
        // A projective distance over-estimates when seen from elsewhere, hence the factor.
        const F stride = max(value * (0.7f * truncation_voxels), F(1.0f)) * voxel_step;
        step = select(occupied, stride, step);
        *t_before = select(crossing, t_previous, *t_before);
        *before = select(crossing, previous, *before);
        *after = select(crossing, value, *after);
        hit = hit || crossing;
        // From inside the surface outwards: the back of something, nothing to predict (KinFu stops here too).
        const auto back = known && previous < zero && value > zero;
        active = active && !crossing && !back;
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
  PL_HD Vec3<F> surface_normal(const Ray<F>& ray, const F& t, const F& u, float v, Mask<F>* hit) const {
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
    *hit = *hit && dot(normal, camera.back_project(u, F(v), F(1.0f))) < F(0.0f);
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
