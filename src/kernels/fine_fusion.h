// The final fusion, docs/method.md §10: what a frame says about the voxels of the fine map. A reading counts by its
// noise and by how steeply it meets the surface; what the camera sees through is counted apart.
#pragma once

#include "kernels/icp.h"
#include "kernels/integrate.h"
#include "kernels/lane.h"
#include "kernels/preprocess.h"
#include "kernels/sparse_bricks.h"
#include "plumbline/pinhole.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// A reading and how the camera looks at its surface, in one word for one look-up: the lower half is the reading as it
/// was taken, the upper half of a float n·r, with the unit normal n and the pixel's ray r of depth 1; 0 where only
/// what lies before the surface is known.
template <class F>
struct SurfaceReading {
  F depth;  ///< metres
  F slope;  ///< n·r: metres across the surface for a metre along the optical axis

  PL_HD static SurfaceReading unpack(const Int<F>& word, float metres_per_reading) {
    return {to_float(word & Int<F>(0xFFFF)) * metres_per_reading, float_from_bits(word & Int<F>(~0xFFFF))};
  }
};

/// The noise along the optical axis, and how far from a reading the distance to it is a distance to the surface.
struct FusionNoise {
  NoiseModel model;  ///< σ in metres
  float truncation;  ///< metres, at least
  float sigmas = 3;  ///< and so many standard deviations
  float best_sigma;  ///< metres: a reading with it weighs 1
  float max_sigma;   ///< metres: noisier readings only tell that space is free

  template <class F>
  PL_HD F sigma(const F& z) const {
    const F d = z - F(model.nearest);
    return madd(d * d, F(model.slope), F(model.base));
  }
  template <class F>
  PL_HD F reach(const F& sigma) const {
    return max(F(truncation), sigma * sigmas);
  }
};

/// Makes the words of a frame. A reading next to a much nearer one lies at the rim of what stands before it, or between
/// the two: it is left out, and so is one without neighbours.
struct WeighReadings {
  PlaneView<const std::uint16_t> raw;
  PlaneView<const float> depth;                         ///< metres; 0 where the reading does not count
  PlaneView<const float> normal_x, normal_y, normal_z;  ///< at `1 << normal_level` times fewer pixels a side
  PlaneView<std::int32_t> out;
  Pinhole camera;
  FusionNoise noise;
  int normal_level;  ///< 0 or 1
  float min_cosine;  ///< of the incidence of a reading that meets a surface

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F z = load<F>(depth.row(y) + x), zero(0.0f);
    const auto inside = inside_row<F>(x, depth.width) && z > zero;
    if (!any(inside)) return store_int(out.row(y) + x, Int<F>(0));
    const F sigma = noise.sigma<F>(z), gap = max(sigma * kRimSigmas, z * kRimShare);
    const auto clean = inside && z - nearest_around<F>(x, y, z) <= gap;

    const F u = Lane<F>::index() + static_cast<float>(x);
    const Vec3<F> ray = camera.back_project(u, F(static_cast<float>(y)), F(1.0f));
    const Vec3<F> n = normal<F>(u, y, inside);
    const F slope = abs(dot(n, ray));
    const auto known = clean && slope > zero;
    const auto vague = slope * slope < dot(ray, ray) * (min_cosine * min_cosine) || sigma > F(noise.max_sigma);
    const Int<F> upper = (bits_from_float(select(vague, zero, slope)) + Int<F>(0x8000)) & Int<F>(~0xFFFF);
    const Int<F> word = upper | to_int(load_u16<F>(raw.row(y) + x));
    store_int(out.row(y) + x, select_int(known, word, Int<F>(0)));
  }

 private:
  static constexpr float kRimSigmas = 4.0f, kRimShare = 0.02f;

  template <class F>
  PL_HD F nearest_around(int x, int y, const F& z) const {
    const int first = y > 0 ? y - 1 : y, final = y + 1 < depth.height ? y + 1 : y;
    F nearest = z;
    for (int row = first; row <= final; ++row) {
      for (int i = -1; i <= 1; ++i) {
        const F other = load<F>(depth.row(row) + x + i);
        nearest = min(nearest, select(other > F(0.0f), other, nearest));
      }
    }
    return nearest;
  }

  template <class F>
  PL_HD Vec3<F> normal(const F& u, int y, const Mask<F>& inside) const {
    const int row = y >> normal_level;
    if (row >= normal_x.height) return {F(0.0f), F(0.0f), F(0.0f)};
    const Int<F> whole = to_int(select(inside, u, F(0.0f)));
    const Int<F> column = min_int(normal_level == 0 ? whole : shift_right<1>(whole), Int<F>(normal_x.width - 1));
    return {gather(normal_x.row(row), column), gather(normal_y.row(row), column), gather(normal_z.row(row), column)};
  }
};

/// Bricks around the camera by one number: kWindow a side, from `kWindow / 2` before the camera's on.
struct BrickWindow {
  static constexpr int kBits = 10, kWindow = 1 << kBits;
  VoxelPosition first;  ///< counted in bricks

  PL_HD VoxelPosition position(std::int32_t key) const {
    constexpr int kMask = kWindow - 1;
    return {first.x + (key & kMask), first.y + (key >> kBits & kMask), first.z + (key >> (2 * kBits))};
  }
};

/// The bricks that readings touch: for every `step`-th pixel either way those along its ray, as far before and behind
/// the reading as the surface may lie. Bricks that no number names are left out: they are 512 bricks away.
struct TouchedBricks {
  static constexpr int kSamples = 9;  ///< along a ray

  PlaneView<const std::int32_t> readings;  ///< of `WeighReadings`
  Pinhole camera;
  RigidTransform window_from_camera;  ///< metres, from the window's first corner on
  float metres_per_reading, voxel_size, brick_size;
  FusionNoise noise;
  int step;            ///< pixels
  std::int32_t* keys;  ///< kSamples for each pixel, those of a row sample by sample, `stride` apart; −1: none
  int stride;

  PL_HD int columns() const { return (readings.width + step - 1) / step; }
  PL_HD int rows() const { return (readings.height + step - 1) / step; }
  PL_HD std::int32_t* row_of(int y, int sample) const {
    return keys + (static_cast<std::ptrdiff_t>(y) * kSamples + sample) * stride;
  }

  template <class F>
  PL_HD void operator()(int x, int y) const {
    const F u = (Lane<F>::index() + static_cast<float>(x)) * static_cast<float>(step);
    const auto inside = u < F(static_cast<float>(readings.width));
    const Int<F> word = gather_int(readings.row(y * step), to_int(select(inside, u, F(0.0f))));
    const SurfaceReading<F> reading = SurfaceReading<F>::unpack(word, metres_per_reading);
    const auto met = inside && reading.slope > F(0.0f);
    const float spacing = 0.7f * brick_size;
    const F across = max(F(kReachVoxels * voxel_size), noise.sigma<F>(reading.depth) * kReachSigmas);
    const F reach = min(across / max(reading.slope, F(kMinSlope)), F(spacing * (kSamples / 2)));
    const F v(static_cast<float>(y * step));
    for (int k = 0; k < kSamples; ++k) {
      const F wanted(spacing * static_cast<float>(k - kSamples / 2));
      const auto needed = met && abs(wanted) < reach + spacing;
      Int<F> key(-1);
      if (any(needed)) key = key_at<F>(u, v, reading.depth + max(min(wanted, reach), F(0.0f) - reach), needed);
      store_int(row_of(y, k) + x, key);
    }
  }

 private:
  // Less than distances are measured: voxels farther off have no part in where the surface is.
  static constexpr float kReachSigmas = 1.0f, kReachVoxels = 2.5f, kMinSlope = 0.5f;

  template <class F>
  PL_HD Int<F> key_at(const F& u, const F& v, const F& z, const Mask<F>& needed) const {
    constexpr float kEnd = static_cast<float>(BrickWindow::kWindow);
    const Vec3<F> p = window_from_camera.apply(camera.back_project(u, v, z)) * (1.0f / brick_size);
    const F zero(0.0f), end(kEnd);
    const auto valid = needed && p.x >= zero && p.y >= zero && p.z >= zero && p.x < end && p.y < end && p.z < end;
    const Int<F> bx = to_int(select(valid, p.x, zero)), by = to_int(select(valid, p.y, zero)),
                 bz = to_int(select(valid, p.z, zero));
    return select_int(valid, bx | shift_left<BrickWindow::kBits>(by) | shift_left<2 * BrickWindow::kBits>(bz),
                      Int<F>(-1));
  }
};

/// Marks the bricks that the frame may say something about; lanes run over all bricks of the map.
struct MarkFineBricks {
  SparseBricks volume;
  BrickSight sight;
  RigidTransform camera_from_window;
  VoxelPosition window;  ///< brick that the window begins with
  std::int32_t* marked;  ///< 1 or 0 a brick

  template <class F>
  PL_HD void operator()(int x) const {
    const auto centre = [&](const std::int32_t* position, int first) {
      return (to_float(load_int<F>(position + x) - Int<F>(first)) + 0.5f) * volume.brick_size();
    };
    const Vec3<F> p = {centre(volume.x, window.x), centre(volume.y, window.y), centre(volume.z, window.z)};
    Mask<F> near_surface;
    const auto seen = sight.sees<F>(camera_from_window.apply(p), inside_row<F>(x, volume.bricks), &near_surface);
    store_int(marked + x, to_int(select(seen, F(1.0f), F(0.0f))));
  }
};

/// Fuses a frame into a brick, voxel by voxel. The distance to a reading is taken across the surface, so that views of
/// one surface at different angles agree.
struct FuseFineBrick {
  SparseBricks volume;
  PlaneView<const std::int32_t> readings;  ///< of `WeighReadings`
  PlaneView<const std::int32_t> color;     ///< 0x00BBGGRR per pixel, null without
  Pinhole camera;
  RigidTransform camera_from_window;
  VoxelPosition window;  ///< brick that the window begins with
  float metres_per_reading;
  FusionNoise noise;
  std::int32_t frame;  ///< counted up

  /// A brick's first word, and in the camera's frame its first voxel and the steps to the next.
  struct Brick {
    std::ptrdiff_t first_word;
    Vec3<float> corner, along_x, along_y, along_z;
  };
  PL_HD Brick at(int brick) const {
    const float size = volume.voxel_size;
    const auto centre = [&](std::int32_t own, int first) {
      return (static_cast<float>(kBrickSide * (own - first)) + 0.5f) * size;
    };
    return {SparseBricks::first_word(brick),
            camera_from_window.apply(Vec3<float>{centre(volume.x[brick], window.x), centre(volume.y[brick], window.y),
                                                 centre(volume.z[brick], window.z)}),
            camera_from_window.rotate(Vec3<float>{size, 0.0f, 0.0f}),
            camera_from_window.rotate(Vec3<float>{0.0f, size, 0.0f}),
            camera_from_window.rotate(Vec3<float>{0.0f, 0.0f, size})};
  }

  /// `offset` is the first lane's voxel within the brick, a multiple of the lane's width.
  template <class F>
  PL_HD Mask<F> is_near_surface(const Brick& brick, int offset) const {
    return measure<F>(brick, offset).met;
  }

  /// Returns the lanes whose voxel lies behind a surface.
  template <class F>
  PL_HD Mask<F> update(const Brick& brick, int offset) const {
    const Measured<F> m = measure<F>(brick, offset);
    const F zero(0.0f), one(1.0f);
    if (!any(m.met || m.through)) return zero > one;
    const std::ptrdiff_t at = brick.first_word + offset;
    const Int<F> word = load_int<F>(volume.evidence + at);
    Evidence<F> e = Evidence<F>::unpack(word);
    e.through = e.through + select(m.through, one, zero);
    auto behind = zero > one;
    if (any(m.met)) {
      behind = update_distance<F>(volume.distances + at, m, &e);
      if (volume.has_color() && !color.is_null()) {
        const auto near = m.met && abs(m.distance) <= m.reach * kColorReach;
        if (any(near)) update_color<F>(volume.colors + at, m, near, offset);
      }
    }
    store_int(volume.evidence + at, select_int(m.met || m.through, e.pack(), word));
    return behind;
  }

 private:
  static constexpr float kMinSlope = 0.15f;   ///< of what only tells that space is free
  static constexpr float kBehind = 0.1f;      ///< weight as far behind the surface as distances are measured
  static constexpr float kNoisy = 2.0f;       ///< standard deviations behind the surface that weigh as much as before
  static constexpr float kColorReach = 0.3f;  ///< of `reach`
  static constexpr float kColorWeight = 24.0f, kColorDepth = 0.7f, kMaxColorWeight = 160.0f;

  template <class F>
  struct Measured {
    F distance, reach, sigma, depth, slope;
    Int<F> pixel;
    Mask<F> met, through;
  };

  template <class F>
  PL_HD Measured<F> measure(const Brick& brick, int offset) const {
    const VoxelPosition p = position_in_brick(offset);
    const Vec3<float> first = brick.corner + brick.along_x * static_cast<float>(p.x) +
                              brick.along_y * static_cast<float>(p.y) + brick.along_z * static_cast<float>(p.z);
    const SeenVoxels<F> voxels(first, camera_from_window.rotate(voxel_lanes<F>() * volume.voxel_size), camera,
                               readings.stride);
    const SurfaceReading<F> reading =
        SurfaceReading<F>::unpack(gather_int(readings.data, voxels.pixel), metres_per_reading);
    const auto valid = voxels.seen && reading.depth > F(0.0f);
    Measured<F> m;
    m.sigma = noise.sigma<F>(reading.depth);
    m.reach = noise.reach<F>(m.sigma);
    m.distance = (reading.depth - voxels.z) * max(reading.slope, F(kMinSlope));
    m.met = valid && reading.slope > F(0.0f) && abs(m.distance) <= m.reach;
    m.through = valid && m.distance > m.reach;
    m.depth = reading.depth;
    m.slope = reading.slope;
    m.pixel = voxels.pixel;
    return m;
  }

  /// The weighted mean, with 1/σ² · cos of the incidence; less behind the surface, where another side may be seen from
  /// elsewhere, but not within the noise: that would draw the surface back. Returns the lanes behind a surface.
  template <class F>
  PL_HD Mask<F> update_distance(float* address, const Measured<F>& m, Evidence<F>* e) const {
    const F zero(0.0f), one(1.0f), old = load<F>(address);
    const F relative = F(noise.best_sigma) / m.sigma;
    const F behind = min(max((m.reach + m.distance) / (m.reach - m.sigma * kNoisy), F(kBehind)), one);
    const F weight = select(m.met, relative * relative * min(m.slope, one) * behind, zero);
    const F sum = e->weight + weight;
    const F distance = select(m.met, old + (m.distance - old) * (weight / max(sum, F(1e-20f))), old);
    store(address, distance);
    e->weight = sum;
    e->hits = e->hits + select(m.met, one, zero);
    return distance < zero;
  }

  /// A weighted mean that prefers near views at right angles. Bytes would not move any more once they weigh much, so
  /// the fraction is rounded up or down by chance: the same for every run, another for each voxel and frame.
  template <class F>
  PL_HD void update_color(std::int32_t* address, const Measured<F>& m, const Mask<F>& near, int offset) const {
    const Int<F> word = load_int<F>(address), seen = gather_int(color.data, m.pixel), byte(0xFF);
    const F nearness = min(F(kColorDepth) / max(m.depth, F(kColorDepth)), F(1.0f));
    const F slope = min(m.slope, F(1.0f));
    const F own = max(floor(slope * slope * nearness * nearness * kColorWeight), F(1.0f));
    const F weight = to_float(shift_right<24>(word) & byte);
    const F share = own / (weight + own);
    const F chance = dither<F>(offset);
    const auto channel = [&](const Int<F>& old, const Int<F>& now) {
      return to_int(floor(madd(share, to_float(now) - to_float(old), to_float(old)) + chance));
    };
    const Int<F> red = channel(word & byte, seen & byte);
    const Int<F> green = channel(shift_right<8>(word) & byte, shift_right<8>(seen) & byte);
    const Int<F> blue = channel(shift_right<16>(word) & byte, shift_right<16>(seen) & byte);
    const Int<F> fused = red | shift_left<8>(green) | shift_left<16>(blue) |
                         shift_left<24>(to_int(min(weight + own, F(kMaxColorWeight))));
    store_int(address, select_int(near, fused, word));
  }

  /// 0 … 1, exclusive.
  template <class F>
  PL_HD F dither(int offset) const {
    const Int<F> voxel = Lane<F>::int_index() + Int<F>(offset);
    const Int<F> mixed = (voxel * Int<F>(619) + Int<F>((frame * 337) & 0xFFFF)) & Int<F>(1023);
    return (to_float(mixed) + 0.5f) * (1.0f / 1024.0f);
  }
};

}  // namespace plumbline::kernels
