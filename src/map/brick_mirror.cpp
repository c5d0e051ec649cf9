#include "map/brick_mirror.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "backend/backend.h"
#include "kernels/brick_map.h"
#include "kernels/voxel.h"
#include "map/host_bricks.h"
#include "map/mesh_of_bricks.h"

namespace plumbline {

namespace {

constexpr int kBlockBricks = 4;                ///< a side
constexpr int kAroundSide = kBlockBricks + 2;  ///< with the bricks around: cells reach above, gradients below
constexpr int kAround = kAroundSide * kAroundSide * kAroundSide;
constexpr int kMinWeight = 2;
constexpr double kFullDistance = 1;   ///< metres: what is seen from nearer counts no more
constexpr double kUnknownView = 0.5;  ///< of a surface whose views nobody noted

std::int32_t block_of(std::int32_t brick) { return brick >> 2; }

/// Position of a brick by its number in a block's surroundings, counted in bricks from the block's lowest one.
kernels::VoxelPosition local(int number) {
  return {number % kAroundSide - 1, number / kAroundSide % kAroundSide - 1, number / kAroundSide / kAroundSide - 1};
}
int number_of(const kernels::VoxelPosition& local) {
  return ((local.z + 1) * kAroundSide + local.y + 1) * kAroundSide + local.x + 1;
}

enum class Part { own, above, beside };
Part part_of(const kernels::VoxelPosition& local) {
  if (std::min({local.x, local.y, local.z}) < 0) return Part::beside;
  return std::max({local.x, local.y, local.z}) == kBlockBricks ? Part::above : Part::own;
}

bool sees(const Pinhole& k, const Eigen::Vector3d& p) {
  if (p.z() <= 0) return false;
  const double u = p.x() / p.z() * static_cast<double>(k.fx) + static_cast<double>(k.cx);
  const double v = p.y() / p.z() * static_cast<double>(k.fy) + static_cast<double>(k.cy);
  return u >= 0 && v >= 0 && u < k.width && v < k.height;
}

}  // namespace

/// The bricks of a block and those around it.
class BrickMirror::Surroundings {
 public:
  Surroundings(const BrickMirror& mirror, const MapBlock& block)
      : first_{block.x * kBlockBricks, block.y * kBlockBricks, block.z * kBlockBricks} {
    for (int i = 0; i < kAround; ++i) {
      const kernels::VoxelPosition at = local(i);
      const auto brick = mirror.bricks_.find(key_of({first_.x + at.x, first_.y + at.y, first_.z + at.z}));
      bricks_[static_cast<std::size_t>(i)] = brick == mirror.bricks_.end() ? nullptr : &brick->second;
    }
  }
  const Brick* brick(int number) const { return bricks_[static_cast<std::size_t>(number)]; }
  /// The brick that a voxel of the block or next to it lies in, or null.
  const Brick* brick_at(const kernels::VoxelPosition& voxel) const {
    const kernels::VoxelPosition at = kernels::brick_of(voxel);
    const auto outside = [](int x) { return x < -1 || x > kBlockBricks; };
    return outside(at.x) || outside(at.y) || outside(at.z) ? nullptr : brick(number_of(at));
  }
  const kernels::VoxelPosition& first() const { return first_; }
  /// Whether a cell of a brick, which reaches into those above, can hold a surface.
  bool can_have_surface(int number) const {
    bool has_before = false, has_behind = false;
    for (int k = 0; k < 8; ++k) {
      kernels::VoxelPosition at = local(number);
      at = {at.x + (k & 1), at.y + (k >> 1 & 1), at.z + (k >> 2)};
      const Brick* above = std::max({at.x, at.y, at.z}) > kBlockBricks ? nullptr : brick(number_of(at));
      if (above == nullptr) continue;
      has_before = has_before || above->has_before;
      has_behind = has_behind || above->has_behind;
    }
    return has_before && has_behind;
  }

 private:
  kernels::VoxelPosition first_;  ///< counted in bricks
  std::array<const Brick*, kAround> bricks_{};
};

BrickMirror::BrickMirror(std::size_t max_bricks) : max_bricks_(max_bricks), host_(make_backend("cpu", 1)) {}

double BrickMirror::block_size() const { return kernels::first_voxel_of({kBlockBricks, 0, 0}).x * voxel_size_; }

/// A brick's lowest corner, map's frame, metres.
Eigen::Vector3d BrickMirror::corner_of(const kernels::VoxelPosition& brick) const {
  const kernels::VoxelPosition voxel = kernels::first_voxel_of(brick);
  return voxel_size_ * Eigen::Vector3d(voxel.x, voxel.y, voxel.z);
}

std::vector<ReachedBlock> BrickMirror::update(const MapUpdate& update, const MapViews& views) {
  voxel_size_ = update.voxel_size;
  truncation_ = update.truncation;
  world_from_map_ = update.world_from_map;
  has_color_ = !update.colors.empty();
  std::map<MapBlock, bool> reached;
  for (std::size_t i = 0; i < update.bricks.size(); ++i) {
    const kernels::VoxelPosition at = kernels::brick_of({update.bricks[i].x, update.bricks[i].y, update.bricks[i].z});
    const bool is_new = !bricks_.contains(key_of(at));
    if (is_new && is_full()) continue;
    Brick& brick = bricks_[key_of(at)];
    const auto first = static_cast<std::ptrdiff_t>(i * Map::kBrickVoxels);
    std::copy_n(update.voxels.begin() + first, Map::kBrickVoxels, brick.words.voxels.begin());
    if (has_color_) std::copy_n(update.colors.begin() + first, Map::kBrickVoxels, brick.words.colors.begin());
    const double weight_before = brick.weight;
    brick.sum_up();
    note_views(at, views, weight_before, &brick);
    for (int k = 0; k < 8; ++k)  // cells of the bricks below reach into this one
      reached[{block_of(at.x - (k & 1)), block_of(at.y - (k >> 1 & 1)), block_of(at.z - (k >> 2))}] |= is_new;
  }
  std::vector<ReachedBlock> blocks;
  for (const auto& [block, is_new] : reached) blocks.push_back({block, is_new});
  return blocks;
}

void BrickMirror::Brick::sum_up() {
  weight = 0;
  has_before = has_behind = false;
  for (const std::int32_t word : words.voxels) {
    const kernels::Voxel<float> voxel = kernels::unpack<float>(word);
    weight += static_cast<double>(voxel.weight);
    const bool is_behind = voxel.distance < 0;
    has_behind = has_behind || is_behind;
    has_before = has_before || (!is_behind && voxel.weight > 0);
  }
}

/// The weight that the brick has gained, by where it was seen from.
void BrickMirror::note_views(const kernels::VoxelPosition& at, const MapViews& views, double weight_before,
                             Brick* brick) const {
  const double gained = brick->weight - weight_before;
  if (gained <= 0) return;  // it counts as seen as often as it can be, or the camera sees what stood behind it
  const Eigen::Vector3d middle = 0.5 * (corner_of(at) + corner_of({at.x + 1, at.y + 1, at.z + 1}));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const SE3& world_from_camera : views.world_from_camera) {
    const SE3 camera_from_map = world_from_camera.inverse() * world_from_map_;
    const Eigen::Vector3d p = camera_from_map * middle;
    if (!sees(views.camera, p)) continue;
    const double near = std::min(1.0, kFullDistance * kFullDistance / p.squaredNorm());
    sum -= near * (camera_from_map.rotation().transpose() * p.normalized());
    ++count;
  }
  if (count == 0) return;
  brick->weight_in_view += gained;
  const Eigen::Vector3f mean = (sum / count).cast<float>();
  const auto share = static_cast<float>(gained / brick->weight_in_view);
  brick->to_cameras = brick->to_cameras * (1 - share) + Vec3<float>{mean.x(), mean.y(), mean.z()} * share;
}

double BrickMirror::seen_at(const Surroundings& around, const Mesh::Float3& position,
                            const Mesh::Float3& normal) const {
  const auto voxel = [&](float x) { return static_cast<int>(std::floor(static_cast<double>(x) / voxel_size_)); };
  const kernels::VoxelPosition at{voxel(position.x), voxel(position.y), voxel(position.z)};
  const Brick* brick = around.brick_at(at);
  if (brick == nullptr) return 0;
  const auto offset = static_cast<std::size_t>(kernels::offset_in_brick(at));
  const auto weight = static_cast<double>(kernels::unpack<float>(brick->words.voxels[offset]).weight);
  if (brick->weight_in_view == 0) return kUnknownView * weight;
  return weight * std::max(0.0, static_cast<double>(dot(brick->to_cameras, {normal.x, normal.y, normal.z})));
}

BlockSurface BrickMirror::surface(const MapBlock& block) const {
  const Surroundings around(*this, block);
  HostBricks bricks(voxel_size_, has_color_);
  int counts[3] = {};  // of each part
  for (const Part part : {Part::own, Part::above, Part::beside}) {
    for (int i = 0; i < kAround; ++i) {
      if (around.brick(i) == nullptr) continue;
      if ((around.can_have_surface(i) ? part_of(local(i)) : Part::beside) != part) continue;
      bricks.add(local(i), around.brick(i)->words, truncation_, kMinWeight);
      ++counts[static_cast<int>(part)];
    }
  }
  BlockSurface surface{bricks.extract_mesh(*host_, counts[0], counts[0] + counts[1]), {}};
  const Mesh& mesh = surface.mesh;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    surface.seen.push_back(seen_at(around, mesh.positions[i], mesh.normals[i]));
  transform_mesh(world_from_map_ * SE3(Eigen::Matrix3d::Identity(), corner_of(around.first())), &surface.mesh);
  return surface;
}

}  // namespace plumbline
