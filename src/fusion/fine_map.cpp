#include "fusion/fine_map.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "map/mesh_of_bricks.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

using kernels::BrickWindow;
using kernels::VoxelPosition;

// Distances are measured as far from a reading: thin enough for a table's leaf, thick enough for the noise.
constexpr double kTruncation = 0.02;     // metres
constexpr double kTruncationVoxels = 4;  // at least
constexpr float kMinCosine = 0.15f;      // of the incidence of readings that meet a surface
constexpr double kBestDepth = 0.5;       // metres: a reading there weighs 1
// Readings that may see through a voxel for each that met it, and the step from voxel to voxel, in voxels.
constexpr float kMaxThrough = 1, kMaxStep = 3;
// Voxels in the noise of a reading that may still meet a surface: beyond, a wall would be a cloud of fine bricks.
constexpr double kMaxSigma = 6;
// Images smaller than this are not halved for their normals.
constexpr int kLargeImage = 400;

constexpr kernels::NoiseModel kNoise = {0.0012f, 0.0019f, 0.4f};

kernels::FusionNoise noise_of(double voxel_size) {
  kernels::FusionNoise noise;
  noise.model = kNoise;
  noise.truncation = static_cast<float>(std::max(kTruncation, kTruncationVoxels * voxel_size));
  noise.best_sigma = static_cast<float>(reading_sigma(kBestDepth));
  noise.max_sigma = static_cast<float>(FineMap::max_sigma(voxel_size));
  return noise;
}

int normal_level(const Pinhole& camera) { return camera.width >= kLargeImage ? 1 : 0; }

const FineFusionStages* stages_of(const Backend& backend) {
  if (const FineFusionStages* stages = backend.fine_fusion()) return stages;
  throw Error("this backend has no final fusion", backend.name(), "Take the backend cpu for it.");
}

PreprocessParameters unfiltered(PreprocessParameters parameters) {
  parameters.bilateral = false;
  return parameters;
}

/// The camera's brick is in the middle; false beyond the bricks that can be counted.
bool window_around(const Eigen::Vector3d& position, double brick_size, BrickWindow* window) {
  constexpr double kFarthest = 1 << 26;  // bricks; voxels are counted in 32 bits
  const Eigen::Vector3d brick = (position / brick_size).array().floor();
  if (!(brick.cwiseAbs().maxCoeff() < kFarthest)) return false;
  const auto first = [&](int axis) { return static_cast<std::int32_t>(brick[axis]) - BrickWindow::kWindow / 2; };
  window->first = {first(0), first(1), first(2)};
  return true;
}

/// world_from_window, exact in single precision near the camera wherever in the world that is.
SE3 corner_of(const BrickWindow& window, double brick_size) {
  return {Eigen::Matrix3d::Identity(), brick_size * Eigen::Vector3d(window.first.x, window.first.y, window.first.z)};
}

/// Pixels between rays of which two meet each brick some metres away.
int ray_step(const Pinhole& camera, double brick_size) {
  constexpr double kFar = 4;  // metres
  return std::clamp(static_cast<int>(0.5 * brick_size * double{camera.fx} / kFar), 1, 4);
}

}  // namespace

double reading_sigma(double depth) {
  const double d = depth - double{kNoise.nearest};
  return double{kNoise.base} + double{kNoise.slope} * d * d;
}

double FineMap::max_sigma(double voxel_size) { return kMaxSigma * voxel_size; }

std::size_t FineMap::bytes_per_brick(bool color) {
  constexpr std::size_t kEdges = sizeof(kernels::EdgeRecord), kTable = 4 * sizeof(std::int32_t), kPerBrick = 64;
  // A brick's mesh is on average some 64 vertices and 128 triangles, twice while it is downloaded.
  constexpr std::size_t kMesh = 2 * (64 * 27 + 128 * 12);
  const std::size_t voxel = sizeof(float) + sizeof(std::int32_t) + (color ? sizeof(std::int32_t) : 0) + kEdges;
  return kernels::kBrickVoxels * voxel + kTable + kPerBrick + kMesh;
}

double FineMap::expected_bricks(double area, double voxel_size) {
  constexpr double kSlant = 1.5;  // a slanted surface meets more bricks than one along the axes
  const double side = kernels::kBrickSide * voxel_size;
  return kSlant * area / (side * side) * (1 + 2 * double{noise_of(voxel_size).truncation} / side);
}

FineMap::FineMap(const Pinhole& camera, const FineMapOptions& options, const Backend& backend)
    : backend_(&backend),
      stages_(stages_of(backend)),
      camera_(camera),
      normal_level_(normal_level(camera)),
      live_(camera, unfiltered(options.preprocess), normal_level_ + 1, backend, options.color, normal_level_),
      ranges_(camera, backend),
      noise_(noise_of(options.voxel_size)),
      max_bricks_(std::max<std::size_t>(options.max_bricks, 1)),
      readings_(camera.width, camera.height, backend) {
  view_.voxel_size = static_cast<float>(options.voxel_size);
  view_.max_through = kMaxThrough;
  view_.max_step = kMaxStep * view_.voxel_size;
  make_room(max_bricks_, options.color);
}

/// Pages of memory that no brick uses are never touched and cost nothing.
void FineMap::make_room(std::size_t max_bricks, bool color) {
  const std::size_t voxels = max_bricks * kernels::kBrickVoxels,
                    padded = max_bricks + kMaxLaneWidth;  // room for lanes beyond the final brick
  const auto words = [&](std::size_t count) { return DeviceArray<std::int32_t>(*backend_, count); };
  distances_ = DeviceArray<float>(*backend_, voxels);
  evidence_ = words(voxels);
  if (color) colors_ = words(voxels);
  for (DeviceArray<std::int32_t>* array : {&states_, &x_, &y_, &z_, &marked_, &list_}) *array = words(padded);
  const std::size_t entries = std::bit_ceil(2 * max_bricks);
  const HostMemory host;
  for (DeviceArray<std::int32_t>* array : {&host_x_, &host_y_, &host_z_}) *array = {host, padded};
  host_table_ = {host, entries};
  index_.x = host_x_.data();
  index_.y = host_y_.data();
  index_.z = host_z_.data();
  index_.table = host_table_.data();
  index_.table_mask = static_cast<std::uint32_t>(entries - 1);
  view_.distances = distances_.data();
  view_.evidence = evidence_.data();
  view_.colors = colors_.data();
  view_.states = states_.data();
  view_.x = x_.data();
  view_.y = y_.data();
  view_.z = z_.data();
}

FineMap::Fused FineMap::fuse(const Frame& frame, const SE3& world_from_camera) {
  live_.prepare(frame);
  View view{};
  if (!live_.has_depth() || !window_around(world_from_camera.translation(), double{view_.brick_size()}, &view.window))
    return Fused::nothing;
  view.window_from_camera = corner_of(view.window, double{view_.brick_size()}).inverse() * world_from_camera;
  view.metres_per_reading = static_cast<float>(1 / frame.depth_scale);
  weigh_readings();
  if (!make_touched_bricks(view)) return Fused::no_room;
  update(view);
  ++frames_;
  return Fused::yes;
}

void FineMap::weigh_readings() {
  const DepthLevel& level = live_.pyramid()[static_cast<std::size_t>(normal_level_)];
  stages_->run(kernels::WeighReadings{read_only(live_.readings()), read_only(live_.raw_depth()),
                                      read_only(level.normal_x), read_only(level.normal_y), read_only(level.normal_z),
                                      readings_.view(), camera_, noise_, normal_level_, kMinCosine});
}

bool FineMap::make_touched_bricks(const View& view) {
  kernels::TouchedBricks touched{read_only(readings_),
                                 camera_,
                                 to_kernel(view.window_from_camera),
                                 view.metres_per_reading,
                                 view_.voxel_size,
                                 view_.brick_size(),
                                 noise_,
                                 ray_step(camera_, double{view_.brick_size()}),
                                 nullptr,
                                 0};
  touched.stride = padded_to_lanes(touched.columns());
  const auto keys = static_cast<std::size_t>(touched.rows() * touched.stride * kernels::TouchedBricks::kSamples);
  if (keys_.size() < keys) keys_ = DeviceArray<std::int32_t>(*backend_, keys);
  touched.keys = keys_.data();
  stages_->run(touched);
  const std::int32_t first_new = index_.bricks;
  const bool has_room = make_bricks(touched, view.window);
  send_new_bricks(first_new);
  return has_room;
}

void FineMap::send_new_bricks(std::int32_t first) {
  const std::size_t bytes = sizeof(std::int32_t) * static_cast<std::size_t>(index_.bricks - first);
  backend_->upload(view_.x + first, index_.x + first, bytes);
  backend_->upload(view_.y + first, index_.y + first, bytes);
  backend_->upload(view_.z + first, index_.z + first, bytes);
  view_.bricks = index_.bricks;
}

/// In the order of the keys, which no number of threads changes.
bool FineMap::make_bricks(const kernels::TouchedBricks& touched, const BrickWindow& window) {
  const std::vector<std::int32_t> all_keys = keys_.download(*backend_);
  std::array<std::int32_t, 4096> recent;  // most keys come again soon
  recent.fill(-1);
  for (int row = 0; row < touched.rows() * kernels::TouchedBricks::kSamples; ++row) {
    const std::int32_t* keys = all_keys.data() + static_cast<std::ptrdiff_t>(row) * touched.stride;
    std::int32_t previous = -1;
    for (int i = 0; i < touched.columns(); ++i) {
      const std::int32_t key = keys[i];
      if (key == previous || key < 0) continue;
      previous = key;
      std::int32_t& same = recent[static_cast<std::uint32_t>(key) * 0x9E3779B1U >> 20];
      if (same == key) continue;
      same = key;
      if (!make_brick(window.position(key))) return false;
    }
  }
  return true;
}

void FineMap::update(const View& view) {
  ranges_.measure(live_.raw_depth());
  const RigidTransform camera_from_window = to_kernel(view.window_from_camera.inverse());
  const kernels::BrickSight sight{ranges_.view(), camera_, kernels::kBrickRadius * view_.brick_size(),
                                  noise_.truncation};
  stages_->run(kernels::MarkFineBricks{view_, sight, camera_from_window, view.window.first, marked_.data()});
  const int marked = backend_->compact(marked_.data(), view_.bricks, list_.data());
  const PlaneView<const std::int32_t> colors =
      live_.color() != nullptr ? read_only(*live_.color()) : PlaneView<const std::int32_t>{};
  stages_->update(kernels::FuseFineBrick{view_, read_only(readings_), colors, camera_, camera_from_window,
                                         view.window.first, view.metres_per_reading, noise_, frames_},
                  list_.data(), marked);
}

bool FineMap::make_brick(const VoxelPosition& position) {
  if (index_.find_brick(position) >= 0) return true;
  if (static_cast<std::size_t>(index_.bricks) == max_bricks_) return false;
  index_.make_brick(position);
  return true;
}

Mesh FineMap::extract_mesh(int min_readings) const {
  const DeviceArray<std::int32_t> list(*backend_, bricks() + kMaxLaneWidth);
  const int entries = backend_->compact(view_.states, view_.bricks, list.data());
  const std::vector<std::int32_t> listed = list.download(*backend_, static_cast<std::size_t>(entries));
  const DeviceArray<std::int32_t> position(*backend_, entry_of_each(listed, bricks())),
      table(*backend_, host_table_.size());
  backend_->upload(table.data(), index_.table, sizeof(std::int32_t) * host_table_.size());
  kernels::SparseBricks map = view_;
  map.table = table.data();
  map.table_mask = index_.table_mask;
  const int readings = std::clamp(min_readings, 1, std::max(frames_, 1));
  return mesh_of_bricks(*backend_, *stages_, map, {list.data(), position.data(), entries}, readings);
}

}  // namespace plumbline
