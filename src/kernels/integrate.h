// Fusion of a depth image into the signed distance volume: Curless and Levoy 1996, in the projective form of Newcombe
// et al. 2011. Only bricks that the frame can change are touched.
#pragma once

#include "kernels/brick_map.h"
#include "kernels/lane.h"
#include "kernels/voxel.h"
#include "plumbline/pinhole.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

constexpr int kRangeTile = 8;  ///< pixels per side of a tile of the finest depth range
constexpr int kMaxRangeLevels = 14;
constexpr float kNoRange = 1e30f;
/// Of the sphere around a brick, in sides of it: √3/2.
constexpr float kBrickRadius = 0.8661f;

/// Nearest and farthest reading of every square tile, at tile sizes 8, 16, 32 … px until one tile is the image: what a
/// brick's footprint needs to be judged by four look-ups.
struct DepthRangeView {
  float* nearest = nullptr;   ///< kNoRange where a tile has no reading
  float* farthest = nullptr;  ///< 0 where a tile has no reading
  /// Per level: index of its first tile, and tiles from row to row (a multiple of 16). In device memory, as lanes
  /// differ in level.
  std::int32_t *first = nullptr, *stride = nullptr;
  int levels = 0;
};

/// The finest level from the depth image; one lane is one tile.
struct DepthRangeBase {
  PlaneView<const float> depth;
  DepthRangeView range;
  int stride;  ///< tiles from row to row; those beyond the image hold no reading

  template <class F>
  PL_HD void operator()(int x, int y) const {
    F nearest(kNoRange), farthest(0.0f);
    const F first_column = (Lane<F>::index() + static_cast<float>(x)) * static_cast<float>(kRangeTile);
    for (int j = 0; j < kRangeTile && kRangeTile * y + j < depth.height; ++j) {
      for (int i = 0; i < kRangeTile; ++i) {
        const F column = first_column + static_cast<float>(i);
        const auto inside = column < F(static_cast<float>(depth.width));
        const F z = gather(depth.row(kRangeTile * y + j), to_int(select(inside, column, F(0.0f))));
        const auto reading = inside && z > F(0.0f);
        nearest = min(nearest, select(reading, z, F(kNoRange)));
        farthest = max(farthest, select(reading, z, F(0.0f)));
      }
    }
    store(range.nearest + y * stride + x, nearest);
    store(range.farthest + y * stride + x, farthest);
  }
};

/// Level l from level l − 1; one lane is one tile of level l.
struct DepthRangeCoarser {
  DepthRangeView range;
  int fine_first, fine_stride, fine_rows, first, stride;

  template <class F>
  PL_HD void operator()(int x, int y) const {
    F nearest(kNoRange), farthest(0.0f);
    for (int k = 0; k < 4; ++k) {
      const int row = 2 * y + k / 2;
      if (row >= fine_rows) continue;
      const F column = (Lane<F>::index() + static_cast<float>(x)) * 2.0f + static_cast<float>(k % 2);
      const auto inside = column < F(static_cast<float>(fine_stride));
      const Int<F> tile = to_int(select(inside, column, F(0.0f))) + Int<F>(fine_first + row * fine_stride);
      nearest = min(nearest, select(inside, gather(range.nearest, tile), F(kNoRange)));
      farthest = max(farthest, select(inside, gather(range.farthest, tile), F(0.0f)));
    }
    store(range.nearest + first + y * stride + x, nearest);
    store(range.farthest + first + y * stride + x, farthest);
  }
};

/// What a frame sees of bricks, by spheres around them: in view, not wholly behind every reading, near some reading.
struct BrickSight {
  DepthRangeView range;
  Pinhole camera;
  float radius;      ///< of the spheres, metres
  float truncation;  ///< metres

  /// Of the `valid` lanes those whose sphere is in view and not wholly behind every reading; `near_surface`: those near
  /// some reading. Centres in the camera's frame.
  template <class F>
  PL_HD Mask<F> sees(const Vec3<F>& centre, const Mask<F>& valid, Mask<F>* near_surface) const {
    auto candidate = valid && centre.z > F(-radius);

    // Bounds of the sphere's projection: extremes of (x ± r)/(z ± r). A sphere around the camera may be anywhere.
    const auto beyond = centre.z > F(1.05f * radius);
    const F near_z = F(1.0f) / select(beyond, centre.z - radius, F(1.0f));
    const F far_z = F(1.0f) / select(beyond, centre.z + radius, F(1.0f));
    const float width = static_cast<float>(camera.width), height = static_cast<float>(camera.height);
    F u0, u1, v0, v1;
    bounds<F>(centre.x, radius, near_z, far_z, camera.fx, camera.cx, &u0, &u1);
    bounds<F>(centre.y, radius, near_z, far_z, camera.fy, camera.cy, &v0, &v1);
    u0 = select(beyond, max(u0, F(0.0f)), F(0.0f));
    v0 = select(beyond, max(v0, F(0.0f)), F(0.0f));
    u1 = select(beyond, min(u1, F(width - 1.0f)), F(width - 1.0f));
    v1 = select(beyond, min(v1, F(height - 1.0f)), F(height - 1.0f));
    candidate = candidate && u0 <= u1 && v0 <= v1;
    *near_surface = candidate;
    if (!any(candidate)) return candidate;

    F nearest(kNoRange), farthest(0.0f);
    footprint<F>(candidate, u0, u1, v0, v1, &nearest, &farthest);
    *near_surface = centre.z + radius >= nearest - truncation;
    return candidate && farthest > F(0.0f) && centre.z - radius <= farthest + truncation;
  }

 private:
  template <class F>
  PL_HD static void bounds(const F& x, float radius, const F& near_z, const F& far_z, float f, float c, F* low,
                           F* high) {
    const F a = (x - radius) * f, b = (x + radius) * f;
    const F lower = min(a, b), upper = max(a, b);  // a negative focal length swaps them
    *low = floor(min(lower * near_z, lower * far_z) + c + 0.5f);
    *high = floor(max(upper * near_z, upper * far_z) + c + 0.5f);
  }

  /// Nearest and farthest reading in a rectangle of pixels: at the level whose tiles are at least as large as the
  /// rectangle it touches at most 2×2 of them.
  template <class F>
  PL_HD void footprint(const Mask<F>& valid, const F& u0, const F& u1, const F& v0, const F& v1, F* nearest,
                       F* farthest) const {
    const F extent = max(u1 - u0, v1 - v0) + 1.0f;
    // Exponent of the next power of two ≥ extent/8; an exact power gives one level more, which is merely coarser.
    const Int<F> exponent = shift_right<23>(bits_from_float(max(extent * (1.0f / kRangeTile), F(1.0f)))) - Int<F>(126);
    const Int<F> level =
        min_int(select_int(extent <= F(static_cast<float>(kRangeTile)), Int<F>(0), exponent), Int<F>(range.levels - 1));
    const Int<F> shift = level + Int<F>(3);
    const Int<F> first = gather_int(range.first, level), stride = gather_int(range.stride, level);
    const F zero(0.0f);
    const Int<F> x0 = shift_right_by(to_int(select(valid, u0, zero)), shift);
    const Int<F> x1 = shift_right_by(to_int(select(valid, u1, zero)), shift);
    const Int<F> y0 = shift_right_by(to_int(select(valid, v0, zero)), shift) * stride + first;
    const Int<F> y1 = shift_right_by(to_int(select(valid, v1, zero)), shift) * stride + first;
    const Int<F> tiles[4] = {y0 + x0, y0 + x1, y1 + x0, y1 + x1};
    for (const Int<F>& tile : tiles) {
      *nearest = min(*nearest, gather(range.nearest, tile));
      *farthest = max(*farthest, gather(range.farthest, tile));
    }
  }
};

/// Marks the bricks that the frame may change: in view, not wholly behind every reading, and near some reading – or
/// has held one already, so that free space seen now can carve what was there. Lanes run along x over bricks.
struct MarkBricks {
  BrickMap volume;
  DepthRangeView range;
  Pinhole camera;
  RigidTransform camera_from_volume;
  std::int32_t* marked;  ///< 1 or 0 per brick, `state_words()` of them

  template <class F>
  PL_HD void operator()(int x, int row) const {
    const BrickLanes<F> bricks = volume.bricks_at<F>(x, row);
    const BrickSight sight{range, camera, kBrickRadius * volume.brick_size(), volume.truncation};
    Mask<F> near_surface;
    const auto seen = sight.sees<F>(camera_from_volume.apply(bricks.centres()), bricks.exist(), &near_surface);
    if (!any(seen)) return bricks.store(marked, Int<F>(0));
    const auto has_data = to_float(bricks.states()) > F(0.5f);
    bricks.store(marked, to_int(select(seen && (near_surface || has_data), F(1.0f), F(0.0f))));
  }
};

/// Voxels of a brick as a camera sees them, a lane each.
template <class F>
struct SeenVoxels {
  F z;           ///< metres along the optical axis
  Mask<F> seen;  ///< lanes that project into the image
  Int<F> pixel;  ///< index from the image's first pixel on; 0 of the other lanes

  /// `first`: the first lane's voxel in the camera's frame; `off`: what the lanes are off from it, camera's axes.
  PL_HD SeenVoxels(const Vec3<float>& first, const Vec3<F>& off, const Pinhole& camera, int stride) {
    const Vec3<F> p = {off.x + first.x, off.y + first.y, off.z + first.z};
    const auto in_front = p.z > F(1e-3f);
    const F inverse_z = F(1.0f) / select(in_front, p.z, F(1.0f));
    const F u = madd(p.x * inverse_z, F(camera.fx), F(camera.cx + 0.5f));
    const F v = madd(p.y * inverse_z, F(camera.fy), F(camera.cy + 0.5f));
    seen = in_front && u >= F(0.0f) && v >= F(0.0f) && u < F(static_cast<float>(camera.width)) &&
           v < F(static_cast<float>(camera.height));
    const F zero(0.0f);
    pixel = to_int(select(seen, v, zero)) * Int<F>(stride) + to_int(select(seen, u, zero));
    z = p.z;
  }
};

/// Running average of the projective signed distance (Newcombe et al. 2011, eq. 11–13) and of colour. The launcher
/// runs `is_near_surface` over a brick that has held no surface yet, and `update` over bricks that hold one or
/// just got one: free space alone leaves no trace, so that rays can skip it.
struct Integrate {
  BrickMap volume;
  PlaneView<const float> depth;         ///< raw metres, not smoothed
  PlaneView<const std::int32_t> color;  ///< 0x00BBGGRR per pixel, null without
  Pinhole camera;
  RigidTransform camera_from_volume;
  float max_weight;

  /// What the two below take of a brick.
  PL_HD int at(int brick) const { return brick; }

  /// `offset` is the first lane's voxel within the brick, a multiple of the lane's width.
  template <class F>
  PL_HD Mask<F> is_near_surface(int brick, int offset) const {
    Int<F> pixel;
    F distance;
    const auto visible = measure<F>(brick, offset, &distance, &pixel);
    return visible && abs(distance) < F(volume.truncation);
  }

  /// Returns the lanes whose voxel lies behind a surface afterwards.
  template <class F>
  PL_HD Mask<F> update(int brick, int offset) const {
    Int<F> pixel;
    F distance;
    const auto visible = measure<F>(brick, offset, &distance, &pixel);
    const auto changes = visible && distance >= F(-volume.truncation);
    std::int32_t* address = volume.voxels_of(brick) + offset;
    const Int<F> word = load_int<F>(address);
    if (!any(changes)) return is_behind<F>(word);
    const Voxel<F> old = unpack<F>(word);
    const F measured = min(distance * (1.0f / volume.truncation), F(1.0f));
    const F weight = old.weight + 1.0f;
    const Voxel<F> fused = {madd(old.distance, old.weight, measured) / weight, min(weight, F(max_weight))};
    const Int<F> changed = select_int(changes, pack<F>(fused), word);
    store_int(address, changed);
    if (volume.has_color() && !color.is_null()) {
      const auto near = changes && distance <= F(volume.truncation);
      if (any(near)) update_color<F>(volume.colors_of(brick) + offset, pixel, near);
    }
    return is_behind<F>(changed);
  }

 private:
  template <class F>
  PL_HD static Mask<F> is_behind(const Int<F>& word) {
    return distance_of<F>(word) < F(0.0f);
  }

  /// Signed distance of each voxel from the reading at its pixel, metres, positive in front of the surface.
  template <class F>
  PL_HD Mask<F> measure(int brick, int offset, F* distance, Int<F>* pixel) const {
    const SeenVoxels<F> voxels(camera_from_volume.apply(volume.centre_of(brick, offset)),
                               camera_from_volume.rotate(volume.lane_offsets<F>()), camera, depth.stride);
    *pixel = voxels.pixel;
    const F reading = gather(depth.data, *pixel);
    *distance = reading - voxels.z;
    return voxels.seen && reading > F(0.0f);
  }

  template <class F>
  PL_HD void update_color(std::int32_t* address, const Int<F>& pixel, const Mask<F>& near) const {
    constexpr float kMaxColorWeight = 32.0f;  // beyond it an 8-bit average no longer moves
    const Int<F> word = load_int<F>(address), seen = gather_int(color.data, pixel), byte(0xFF);
    const F weight = to_float(shift_right<24>(word) & byte);
    const F inverse = F(1.0f) / (weight + 1.0f);
    const auto channel = [&](const Int<F>& old, const Int<F>& now) {
      return to_int(floor(madd(madd(to_float(old), weight, to_float(now)), inverse, F(0.5f))));
    };
    const Int<F> red = channel(word & byte, seen & byte);
    const Int<F> green = channel(shift_right<8>(word) & byte, shift_right<8>(seen) & byte);
    const Int<F> blue = channel(shift_right<16>(word) & byte, shift_right<16>(seen) & byte);
    const Int<F> fused = red | shift_left<8>(green) | shift_left<16>(blue) |
                         shift_left<24>(to_int(min(weight + 1.0f, F(kMaxColorWeight))));
    store_int(address, select_int(near, fused, word));
  }
};

}  // namespace plumbline::kernels
