#include "map/brick_mirror.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "kernels/brick_map.h"
#include "kernels/marching_cubes.h"
#include "kernels/voxel.h"
#include "map/mesh_of_bricks.h"
#include "plumbline/se3.h"

namespace plumbline {

namespace {

constexpr int kBlockBricks = 4;                ///< a side
constexpr int kAroundSide = kBlockBricks + 2;  ///< with the bricks around: cells reach above, gradients below
constexpr float kMinWeight = 2;

std::int32_t block_of(std::int32_t brick) { return brick >> 2; }

}  // namespace

/// A block and the bricks around it as the passes of marching cubes take a map. Bricks are numbered within the block's
/// surroundings, positions are counted in voxels from its lowest one.
class MirroredBlock {
 public:
  MirroredBlock(const BrickMirror& mirror, const MapBlock& block)
      : voxel_size(static_cast<float>(mirror.voxel_size_)),
        first_{block.x * kBlockBricks, block.y * kBlockBricks, block.z * kBlockBricks},
        has_color_(mirror.has_color_) {
    for (int i = 0; i < kCount; ++i) {
      const kernels::VoxelPosition at = local(i);
      const auto brick = mirror.bricks_.find({first_.x + at.x, first_.y + at.y, first_.z + at.z});
      bricks_[static_cast<std::size_t>(i)] = brick == mirror.bricks_.end() ? nullptr : &brick->second;
    }
  }

  static constexpr int kCount = kAroundSide * kAroundSide * kAroundSide;
  float voxel_size;

  bool has_color() const { return has_color_; }
  bool has(int brick) const { return bricks_[static_cast<std::size_t>(brick)] != nullptr; }
  /// Of a brick by its number, counted in bricks from the block's lowest one: −1 to kBlockBricks.
  static kernels::VoxelPosition local(int brick) {
    return {brick % kAroundSide - 1, brick / kAroundSide % kAroundSide - 1, brick / kAroundSide / kAroundSide - 1};
  }
  kernels::VoxelPosition origin_of(int brick) const {
    const kernels::VoxelPosition at = local(brick);
    return {kernels::kBrickSide * at.x, kernels::kBrickSide * at.y, kernels::kBrickSide * at.z};
  }
  kernels::VoxelAddress find(const kernels::VoxelPosition& p) const {
    const kernels::VoxelPosition b = kernels::brick_of(p);
    const auto outside = [](int x) { return x < -1 || x > kBlockBricks; };
    if (outside(b.x) || outside(b.y) || outside(b.z)) return {-1, 0};
    const int brick = ((b.z + 1) * kAroundSide + b.y + 1) * kAroundSide + b.x + 1;
    return {has(brick) ? brick : -1, kernels::offset_in_brick(p)};
  }
  std::int32_t voxel(const kernels::VoxelAddress& at) const { return brick(at).voxels[index(at)]; }
  std::int32_t color(const kernels::VoxelAddress& at) const { return brick(at).colors[index(at)]; }
  /// Of the block's lowest voxel in the map, metres.
  Eigen::Vector3d corner() const {
    return kernels::kBrickSide * voxel_size * Eigen::Vector3d(first_.x, first_.y, first_.z);
  }

 private:
  const BrickMirror::Brick& brick(const kernels::VoxelAddress& at) const {
    return *bricks_[static_cast<std::size_t>(at.brick)];
  }
  static std::size_t index(const kernels::VoxelAddress& at) { return static_cast<std::size_t>(at.offset); }

  kernels::VoxelPosition first_;  ///< counted in bricks
  bool has_color_;
  std::array<const BrickMirror::Brick*, kCount> bricks_{};
};

namespace kernels {

template <>
class MeshVoxels<MirroredBlock> {
 public:
  MeshVoxels(const MirroredBlock& block, int brick, float min_weight)
      : block_(block), origin_(block.origin_of(brick)), min_weight_(min_weight) {}

  const VoxelPosition& origin() const { return origin_; }
  static bool has_surface() { return true; }
  VoxelAddress find(const VoxelPosition& p) const {
    return block_.find({origin_.x + p.x, origin_.y + p.y, origin_.z + p.z});
  }
  bool read(const VoxelPosition& p, float* distance) const {
    const VoxelAddress at = find(p);
    if (at.brick < 0) return false;
    const Voxel<float> voxel = unpack<float>(block_.voxel(at));
    *distance = voxel.distance;
    return voxel.weight >= min_weight_;
  }
  static bool is_surface(float /*here*/, float /*there*/) { return true; }
  bool gradient(const VoxelPosition& p, int axis, float along, Vec3<float>* g) const {
    Vec3<float> low, high;
    if (!central(p, &low) || !central(MeshCells<MirroredBlock>::one_along(p, axis), &high)) return false;
    *g = low * (1 - along) + high * along;
    return true;
  }

 private:
  /// By central differences, unscaled.
  bool central(const VoxelPosition& p, Vec3<float>* g) const {
    float before[3], after[3];
    for (int axis = 0; axis < 3; ++axis) {
      const VoxelPosition low{p.x - (axis == 0), p.y - (axis == 1), p.z - (axis == 2)};
      if (!read(low, &before[axis]) || !read(MeshCells<MirroredBlock>::one_along(p, axis), &after[axis])) return false;
    }
    *g = {after[0] - before[0], after[1] - before[1], after[2] - before[2]};
    return true;
  }

  const MirroredBlock& block_;
  VoxelPosition origin_;
  float min_weight_;
};

}  // namespace kernels

namespace {

/// The bricks to mesh: the block's own first, then those that only bring the vertices on its upper faces.
struct BlockBricks {
  std::vector<std::int32_t> list, position = std::vector<std::int32_t>(MirroredBlock::kCount, -1);
  int own = 0;

  explicit BlockBricks(const MirroredBlock& block) {
    for (const bool upper : {false, true}) {
      for (int i = 0; i < MirroredBlock::kCount; ++i)
        if (block.has(i) && is_above(i) == upper && !is_below(i)) add(i);
      if (!upper) own = static_cast<int>(list.size());
    }
  }

 private:
  void add(int brick) {
    position[static_cast<std::size_t>(brick)] = static_cast<std::int32_t>(list.size());
    list.push_back(brick);
  }
  static bool is_above(int brick) {
    const kernels::VoxelPosition at = MirroredBlock::local(brick);
    return std::max({at.x, at.y, at.z}) == kBlockBricks;
  }
  static bool is_below(int brick) {
    const kernels::VoxelPosition at = MirroredBlock::local(brick);
    return std::min({at.x, at.y, at.z}) < 0;
  }
};

/// Exclusive prefix sum; returns the total.
std::int32_t scan(std::vector<std::int32_t>* counts) {
  std::int32_t sum = 0;
  for (std::int32_t& count : *counts) {
    const std::int32_t here = count;
    count = sum;
    sum += here;
  }
  return sum;
}

/// In the block's own frame.
Mesh mesh_of(const MirroredBlock& block) {
  const BlockBricks bricks(block);
  const std::size_t count = bricks.list.size();
  std::vector<kernels::EdgeRecord> edges(count * kernels::kBrickVoxels);
  std::vector<std::int32_t> vertices(count), triangles(count);
  const kernels::MeshBricksOf<MirroredBlock> in{
      block,           bricks.list.data(), bricks.position.data(),     edges.data(),
      vertices.data(), triangles.data(),   kernels::kCellTable.data(), kMinWeight};
  for (int i = 0; i < static_cast<int>(count); ++i) kernels::CountBrickOf<MirroredBlock>{in}(i);
  const auto vertex_total = static_cast<std::size_t>(scan(&vertices));
  const auto all_triangles = static_cast<std::size_t>(scan(&triangles));
  const std::size_t own_triangles =
      static_cast<std::size_t>(bricks.own) < count ? static_cast<std::size_t>(triangles[bricks.own]) : all_triangles;

  Mesh mesh;
  if (own_triangles == 0) return mesh;
  mesh.positions.resize(vertex_total);
  mesh.normals.resize(vertex_total);
  mesh.colors.resize(block.has_color() ? vertex_total : 0);
  mesh.triangles.resize(all_triangles);
  const kernels::WriteBrickOf<MirroredBlock> write{in, &mesh.positions[0].x, &mesh.normals[0].x,
                                                   block.has_color() ? &mesh.colors[0].r : nullptr,
                                                   &mesh.triangles[0].a};
  for (int i = 0; i < static_cast<int>(count); ++i) write(i);
  mesh.triangles.resize(own_triangles);
  drop_unused_vertices(&mesh);
  return mesh;
}

/// Of the voxel that a point of the block lies in; counted in frames.
double weight_at(const MirroredBlock& block, const Mesh::Float3& p) {
  const auto voxel = [&](float x) { return static_cast<int>(std::floor(x / block.voxel_size)); };
  const kernels::VoxelAddress at = block.find({voxel(p.x), voxel(p.y), voxel(p.z)});
  return at.brick < 0 ? 0 : static_cast<double>(kernels::unpack<float>(block.voxel(at)).weight);
}

}  // namespace

std::vector<MapBlock> BrickMirror::update(const MapUpdate& update) {
  voxel_size_ = update.voxel_size;
  world_from_map_ = update.world_from_map;
  has_color_ = !update.colors.empty();
  std::set<MapBlock> reached;
  for (std::size_t i = 0; i < update.bricks.size(); ++i) {
    const kernels::VoxelPosition at = kernels::brick_of({update.bricks[i].x, update.bricks[i].y, update.bricks[i].z});
    const Position position{at.x, at.y, at.z};
    if (is_full() && !bricks_.contains(position)) continue;
    Brick& brick = bricks_[position];
    const auto first = static_cast<std::ptrdiff_t>(i * Map::kBrickVoxels);
    std::copy_n(update.voxels.begin() + first, Map::kBrickVoxels, brick.voxels.begin());
    if (has_color_) std::copy_n(update.colors.begin() + first, Map::kBrickVoxels, brick.colors.begin());
    for (int k = 0; k < 8; ++k)  // cells of the bricks below reach into this one
      reached.insert({block_of(at.x - (k & 1)), block_of(at.y - (k >> 1 & 1)), block_of(at.z - (k >> 2))});
  }
  return {reached.begin(), reached.end()};
}

BlockSurface BrickMirror::surface(const MapBlock& block) const {
  const MirroredBlock around(*this, block);
  BlockSurface surface{mesh_of(around), {}};
  for (const Mesh::Float3& p : surface.mesh.positions) surface.weights.push_back(weight_at(around, p));
  transform_mesh(world_from_map_ * SE3(Eigen::Matrix3d::Identity(), around.corner()), &surface.mesh);
  return surface;
}

}  // namespace plumbline
