#include "graph/views.h"

#include <utility>

#include "place/keyframes.h"
#include "plumbline/prefetch.h"
#include "tracking/live_frame.h"
#include "tracking/registration.h"

namespace plumbline {
namespace {

/// Of every frame of the path.
struct Travel {
  std::vector<double> travelled;
  std::vector<int> piece;
};

Travel travel_along(const std::vector<PathFrame>& path) {
  Travel travel;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double step = i == 0 ? 0 : pose_distance(path[i - 1].world_from_camera, path[i].world_from_camera);
    travel.travelled.push_back(i == 0 ? 0 : travel.travelled.back() + step);
    travel.piece.push_back(i == 0 ? 0 : travel.piece.back() + (path[i].is_cut ? 1 : 0));
  }
  return travel;
}

FernCode encode(const Ferns& ferns, const Backend& backend, const DepthLevel& level) {
  return ferns.encode(make_thumbnail(
      download(backend, level.depth),
      {download(backend, level.normal_x), download(backend, level.normal_y), download(backend, level.normal_z)}));
}

}  // namespace

std::vector<std::size_t> spaced_frames(const std::vector<PathFrame>& path, double step) {
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool is_end = i == 0 || i + 1 == path.size() || path[i].is_cut || path[i + 1].is_cut;
    if (is_end || pose_distance(path[chosen.back()].world_from_camera, path[i].world_from_camera) >= step)
      chosen.push_back(i);
  }
  return chosen;
}

std::vector<PathView> read_views(const Sequence& recording, const std::vector<PathFrame>& path,
                                 const std::vector<std::size_t>& chosen, const Parameters& parameters,
                                 const Backend& backend, const std::function<bool()>& stopping) {
  const Travel travel = travel_along(path);
  LiveFrame live(recording.info().camera, parameters.preprocess, pyramid_levels(parameters.tracking), backend, false,
                 parameters.tracking.finest_level);
  const DepthLevel& finest = live.pyramid()[static_cast<std::size_t>(parameters.tracking.finest_level)];
  const Ferns ferns;
  std::vector<int> indices;
  for (const std::size_t i : chosen) indices.push_back(path[i].index);
  ReadableFrames reader(recording, indices);
  std::vector<PathView> views;
  auto next = chosen.begin();
  while (const std::optional<Frame> frame = reader.next()) {
    if (stopping && stopping()) return {};
    while (path[*next].index != frame->index) ++next;
    live.prepare(*frame);
    if (!live.has_depth()) continue;
    const PathFrame& from = path[*next];
    views.push_back({*next, from.world_from_camera, travel.travelled[*next], travel.piece[*next], from.up,
                     encode(ferns, backend, live.pyramid().back()), download(backend, finest.depth)});
  }
  return views;
}

}  // namespace plumbline
