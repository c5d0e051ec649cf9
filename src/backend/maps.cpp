#include "backend/maps.h"

namespace plumbline {

DepthLevel::DepthLevel(const Pinhole& level_camera, const Backend& backend) : camera(level_camera) {
  const auto plane = [&] { return Plane<float>(camera.width, camera.height, backend); };
  depth = plane();
  normal_x = plane();
  normal_y = plane();
  normal_z = plane();
  inverse_depth = plane();
  pair_distances = plane();
}

DepthPyramid make_pyramid(const Pinhole& camera, int levels, const Backend& backend, int finest_level) {
  DepthPyramid pyramid;
  pyramid.reserve(static_cast<std::size_t>(levels));
  for (int i = 0; i < levels; ++i) pyramid.emplace_back(camera.level(finest_level + i), backend);
  return pyramid;
}

void estimate_plane_normals(const Backend& backend, DepthLevel& level, int radius, float depth_gate) {
  const PlaneView<const float> depth = read_only(level.depth);
  backend.run(kernels::InverseDepth{depth, level.inverse_depth.view()});
  backend.run(
      kernels::PlaneNormals{depth, read_only(level.inverse_depth), level.normals(), level.camera, radius, depth_gate});
}

kernels::IcpInput icp_input(const DepthLevel& live, const DepthLevel& model) {
  kernels::IcpInput in{};
  in.live_depth = read_only(live.depth);
  in.live_normal_x = read_only(live.normal_x);
  in.live_normal_y = read_only(live.normal_y);
  in.live_normal_z = read_only(live.normal_z);
  in.model_depth = read_only(model.depth);
  in.model_normal_x = read_only(model.normal_x);
  in.model_normal_y = read_only(model.normal_y);
  in.model_normal_z = read_only(model.normal_z);
  in.live_camera = live.camera;
  in.model_camera = model.camera;
  return in;
}

}  // namespace plumbline
