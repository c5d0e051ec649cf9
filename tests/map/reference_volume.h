// Fusion by brute force: every voxel of every brick, in double, straight from the definition in docs/method.md §1. The
// kernels must give the same without touching most of the volume.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "kernels/brick_map.h"
#include "kernels/voxel.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/scenes.h"

namespace plumbline::test {

/// Signed distance (truncation units) and weight of one voxel, from a volume in host memory.
inline kernels::Voxel<float> voxel_at(const kernels::BrickMap& view, int x, int y, int z) {
  return kernels::unpack<float>(view.voxel(view.find({x, y, z})));
}

/// Fills a volume in host memory with a signed distance (metres) as a function of the position in the volume's frame:
/// every voxel seen `weight` times, every brick occupied.
template <class Distance>
void write_distance(const kernels::BrickMap& view, const Distance& distance, int weight = 1) {
  const int n = view.resolution();
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const Eigen::Vector3d p = Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5) * double{view.voxel_size};
        const double value = std::clamp(distance(p) / double{view.truncation}, -1.0, 1.0);
        const kernels::VoxelAddress at = view.find({x, y, z});
        view.voxel(at) = kernels::pack<float>({static_cast<float>(value), static_cast<float>(weight)});
        view.state(at.brick) = kernels::kBrickSolid;
      }
    }
  }
}

/// Bricks that have held a surface.
inline int occupied_bricks(const kernels::BrickMap& view) {
  return static_cast<int>(
      std::count_if(view.states(), view.states() + view.slots(), [](int state) { return state != 0; }));
}

class ReferenceVolume {
 public:
  struct Comparison {
    int compared = 0;  ///< voxels
    int seen = 0;      ///< of them with a weight
    int wrong = 0;
    int left_out = 0;  ///< voxels that single precision may rightly see otherwise
  };

  ReferenceVolume(int bricks, double side, double truncation, int max_weight)
      : bricks_(bricks),
        voxel_(side / (bricks * kernels::kBrickSide)),
        truncation_(truncation),
        max_weight_(max_weight),
        brick_(static_cast<std::size_t>(bricks) * bricks * bricks) {}

  void integrate(const Image<float>& depth, const Pinhole& camera, const SE3& camera_from_volume) {
    for (std::size_t b = 0; b < brick_.size(); ++b) integrate_brick(b, depth, camera, camera_from_volume);
  }

  Comparison compare(const kernels::BrickMap& view) const {
    Comparison result;
    for (std::size_t b = 0; b < brick_.size(); ++b) {
      for (int offset = 0; offset < kernels::kBrickVoxels; ++offset) compare_voxel(view, b, offset, &result);
    }
    return result;
  }

  int occupied() const {
    return static_cast<int>(std::count_if(brick_.begin(), brick_.end(), [](const Brick& b) { return b.occupied; }));
  }

 private:
  struct Voxel {
    double distance = 0;
    int weight = 0;
    bool unsure = false;  ///< it lies where rounding decides which pixel it projects to
  };
  struct Brick {
    bool occupied = false;
    bool unsure = false;  ///< rounding decides whether it ever became occupied
    std::array<Voxel, kernels::kBrickVoxels> voxels;
  };
  /// What a voxel meets in one frame.
  struct Sight {
    bool visible = false, unsure = false, maybe_near = false;
    double distance = 0;
    bool surely_near = false;
  };

  std::array<int, 3> position(std::size_t brick, int offset) const {
    const int b = static_cast<int>(brick);
    return {b % bricks_ * 8 + (offset & 7), b / bricks_ % bricks_ * 8 + (offset >> 3 & 7),
            b / bricks_ / bricks_ * 8 + (offset >> 6)};
  }

  Sight look(const std::array<int, 3>& at, const Image<float>& depth, const Pinhole& camera,
             const SE3& camera_from_volume) const {
    Sight sight;
    const Eigen::Vector3d p = camera_from_volume * (Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5) * voxel_);
    if (p.z() <= 1e-3 - 1e-6) return sight;
    sight.unsure = p.z() < 1e-3 + 1e-6;
    const double u = p.x() / p.z() * double{camera.fx} + double{camera.cx} + 0.5;
    const double v = p.y() / p.z() * double{camera.fy} + double{camera.cy} + 0.5;
    // Single precision may round to the neighbouring pixel this close to the border of two.
    const double slack = 2e-4 + 1e-6 * double{camera.fx} / p.z();
    bool first = true;
    double reading = 0;
    for (int k = 0; k < 4; ++k) {
      const double uu = std::floor(u + (k % 2 == 0 ? -slack : slack)), vv = std::floor(v + (k < 2 ? -slack : slack));
      const bool in_view = uu >= 0 && vv >= 0 && uu < depth.width && vv < depth.height;
      const double z = in_view ? double{depth.at(static_cast<int>(uu), static_cast<int>(vv))} : 0;
      sight.maybe_near |= z > 0 && std::abs(z - p.z()) < truncation_ + kDistanceSlack;
      sight.unsure |= !first && z != reading;
      reading = z;
      first = false;
    }
    sight.visible = reading > 0;
    sight.distance = reading - p.z();
    sight.unsure |= sight.visible && std::abs(sight.distance + truncation_) < kDistanceSlack;
    sight.surely_near = sight.visible && !sight.unsure && std::abs(sight.distance) < truncation_ - kDistanceSlack;
    return sight;
  }

  void integrate_brick(std::size_t index, const Image<float>& depth, const Pinhole& camera,
                       const SE3& camera_from_volume) {
    Brick& brick = brick_[index];
    std::array<Sight, kernels::kBrickVoxels> sights;
    bool surely = false, maybe = false;
    for (int offset = 0; offset < kernels::kBrickVoxels; ++offset) {
      Sight& sight = sights[static_cast<std::size_t>(offset)];
      sight = look(position(index, offset), depth, camera, camera_from_volume);
      surely |= sight.surely_near;
      maybe |= sight.maybe_near;
    }
    if (!brick.occupied && !surely) {
      brick.unsure |= maybe;
      return;
    }
    brick.occupied = true;
    for (std::size_t i = 0; i < sights.size(); ++i) update(sights[i], &brick.voxels[i]);
  }

  void update(const Sight& sight, Voxel* voxel) const {
    voxel->unsure |= sight.unsure;
    if (!sight.visible || sight.distance < -truncation_) return;
    const double measured = std::min(sight.distance / truncation_, 1.0);
    voxel->distance = (voxel->distance * voxel->weight + measured) / (voxel->weight + 1);
    voxel->weight = std::min(voxel->weight + 1, max_weight_);
  }

  void compare_voxel(const kernels::BrickMap& view, std::size_t index, int offset, Comparison* result) const {
    const Brick& brick = brick_[index];
    const Voxel& expected = brick.voxels[static_cast<std::size_t>(offset)];
    const auto [x, y, z] = position(index, offset);
    const bool occupied = view.state(view.find({x, y, z}).brick) != 0;
    if (brick.unsure || expected.unsure) {
      ++result->left_out;
      return;
    }
    ++result->compared;
    result->seen += expected.weight > 0;
    const kernels::Voxel<float> actual = voxel_at(view, x, y, z);
    const bool same = actual.weight == static_cast<float>(expected.weight) &&
                      std::abs(double{actual.distance} - expected.distance) < kValueTolerance;
    result->wrong += !same || occupied != brick.occupied;
  }

  static constexpr double kDistanceSlack = 2e-6;   // metres
  static constexpr double kValueTolerance = 1e-4;  // truncation units: a few roundings to 1/32767

  int bricks_;
  double voxel_, truncation_;
  int max_weight_;
  std::vector<Brick> brick_;
};

}  // namespace plumbline::test
