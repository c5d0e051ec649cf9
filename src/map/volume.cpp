#include "map/volume.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"

namespace plumbline {
namespace {

// A mesh's model pyramid keeps 2×2 blocks whose depths differ by less than this: wider, and they span an edge.
constexpr float kModelDecimationRange = 0.09f;

/// The middle 96 % of the values on each axis: a few stray readings do not decide.
std::pair<double, double> robust_range(std::vector<double>& values) {
  const std::size_t cut = values.size() / 50;
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(cut);
  const auto high = values.end() - 1 - static_cast<std::ptrdiff_t>(cut);
  std::nth_element(values.begin(), low, values.end());
  const double lowest = *low;
  std::nth_element(values.begin(), high, values.end());
  return {lowest, *high};
}

VolumePlacementResult fit_volume(const VolumeParameters& parameters, const Pinhole& camera,
                                 const SE3& world_from_camera, const Image<float>& depth) {
  constexpr int kStep = 4;
  constexpr double kMargin = 1.25;
  std::array<std::vector<double>, 3> values;
  for (int v = 0; v < depth.height; v += kStep) {
    for (int u = 0; u < depth.width; u += kStep) {
      if (!(depth.at(u, v) > 0)) continue;
      const Vec3<float> p = camera.back_project(static_cast<float>(u), static_cast<float>(v), depth.at(u, v));
      values[0].push_back(p.x);
      values[1].push_back(p.y);
      values[2].push_back(p.z);
    }
  }
  if (values[0].size() < 100)
    throw Error("the first frame has too few readings to fit the volume to", "volume.placement",
                "give the volume with --set volume.placement=front --set volume.side=METRES");
  Eigen::Vector3d centre;
  double extent = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = robust_range(values[static_cast<std::size_t>(axis)]);
    centre[axis] = 0.5 * (low + high);
    extent = std::max(extent, high - low);
  }
  const double side = std::min(parameters.side, kMargin * extent + 2 * parameters.truncation);
  const SE3 camera_from_volume(Eigen::Matrix3d::Identity(), centre - Eigen::Vector3d::Constant(0.5 * side));
  return {world_from_camera * camera_from_volume, side};
}

}  // namespace

VolumePlacementResult place_volume(const VolumeParameters& parameters, const Pinhole& camera,
                                   const SE3& world_from_camera, const Image<float>& depth) {
  if (parameters.placement == VolumePlacement::fit) return fit_volume(parameters, camera, world_from_camera, depth);
  const double side = parameters.side;
  if (parameters.placement == VolumePlacement::given) {
    const std::vector<double>& p = parameters.pose;  // seven values: core/config.cpp checks
    return {SE3(Eigen::Quaterniond(p.at(6), p.at(3), p.at(4), p.at(5)), {p.at(0), p.at(1), p.at(2)}), side};
  }
  const SE3 camera_from_volume(Eigen::Matrix3d::Identity(), {-0.5 * side, -0.5 * side, parameters.offset * side});
  return {world_from_camera * camera_from_volume, side};
}

Volume::Volume(const VolumeParameters& parameters, const Pinhole& camera, const Backend& backend, bool with_color)
    : backend_(&backend), parameters_(parameters), ranges_(camera, backend), packed_(with_color) {
  view_ = kernels::BrickMap(parameters.resolution);
  view_.truncation = static_cast<float>(parameters.truncation);
  const std::size_t voxels = view_.voxel_words();
  const auto states = static_cast<std::size_t>(view_.state_words());
  voxels_ = DeviceArray<std::int32_t>(backend, voxels);
  if (with_color) colors_ = DeviceArray<std::int32_t>(backend, voxels);
  states_ = DeviceArray<std::int32_t>(backend, states);
  marked_ = DeviceArray<std::int32_t>(backend, states);
  list_ = DeviceArray<std::int32_t>(backend, static_cast<std::size_t>(view_.slots()));
  listed_ = DeviceArray<std::int32_t>(backend, 1);
  view_.keep_in(voxels_.data(), colors_.data(), states_.data());
  place({SE3(), parameters.side});
}

void Volume::place(const VolumePlacementResult& placement) {
  world_from_volume_ = world_from_window_ = placement.world_from_volume;
  view_.move({-first_brick_.x, -first_brick_.y, -first_brick_.z});
  first_brick_ = {0, 0, 0};
  packed_ = PackedBricks(view_.has_color());
  borrowed_.clear();
  travelled_ = 0;
  is_visiting_ = false;
  view_.voxel_size = static_cast<float>(placement.side / view_.resolution());
  if (frames_ > 0) {  // fresh memory is zero and must not be touched: untouched pages cost nothing
    voxels_.clear(*backend_);
    colors_.clear(*backend_);
    states_.clear(*backend_);
  }
  frames_ = 0;
  listed_.clear(*backend_);
}

int Volume::bricks_updated() const { return listed_.download(*backend_).front(); }

void Volume::integrate(const Plane<float>& depth, const Plane<std::int32_t>* color, const Pinhole& camera,
                       const SE3& world_from_camera) {
  const RigidTransform camera_from_volume = to_kernel(world_from_camera.inverse() * world_from_window_);
  ranges_.measure(depth);
  backend_->run(kernels::MarkBricks{view_, ranges_.view(), camera, camera_from_volume, marked_.data()});
  const PlaneView<const std::int32_t> colors = color != nullptr ? read_only(*color) : PlaneView<const std::int32_t>{};
  const kernels::Integrate kernel{view_,  read_only(depth),   colors,
                                  camera, camera_from_volume, static_cast<float>(parameters_.max_weight)};
  backend_->integrate_marked(kernel, marked_.data(), view_.slots(), list_.data(), listed_.data());
  ++frames_;
}

/// Where the rays of each tile can meet a surface at all.
kernels::RaySpanView Volume::span_rays(const SE3& world_from_camera, const Pinhole& camera, float min_distance) const {
  const auto tiles_along = [](int pixels) { return (pixels + kernels::kRayTile - 1) / kernels::kRayTile; };
  kernels::RaySpanView spans;
  spans.columns = tiles_along(camera.width);
  spans.rows = tiles_along(camera.height);
  spans.stride = padded_to_lanes(spans.columns + 1);  // a lane may begin in the last tile and end beyond it
  const std::size_t tiles = static_cast<std::size_t>(spans.stride) * static_cast<std::size_t>(spans.rows);
  if (spans_.size() < 2 * tiles) spans_ = DeviceArray<float>(*backend_, 2 * tiles);
  spans.nearest = spans_.data();
  spans.farthest = spans.nearest + tiles;
  backend_->run(kernels::RaySpans{view_, spans, camera, to_kernel(world_from_camera.inverse() * world_from_window_),
                                  min_distance});
  return spans;
}

void Volume::predict(const SE3& world_from_camera, const RaycastRange& range, DepthPyramid* model) const {
  DepthLevel& finest = model->front();
  const auto min_distance = static_cast<float>(range.min_distance);
  backend_->run(kernels::Raycast{view_, finest.depth.view(), finest.normals(), finest.camera,
                                 to_kernel(world_from_window_.inverse() * world_from_camera), min_distance,
                                 static_cast<float>(range.max_distance),
                                 span_rays(world_from_camera, finest.camera, min_distance)});
  for (std::size_t i = 1; i < model->size(); ++i) {
    const DepthLevel& fine = (*model)[i - 1];
    DepthLevel& coarse = (*model)[i];
    backend_->run(kernels::DecimateModel{read_only(fine.depth), read_only(fine.normal_x), read_only(fine.normal_y),
                                         read_only(fine.normal_z), coarse.depth.view(), coarse.normals(),
                                         kModelDecimationRange});
  }
}

}  // namespace plumbline
