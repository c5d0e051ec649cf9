// Replica as NICE-SLAM renders it: results/depth000000.png and results/frame000000.jpg, traj.txt with a 4×4
// world_from_camera a line, and cam_params.json one folder up.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// One pose a line, of frames 0, 1, … at 30 a second.
Trajectory read_traj(const std::string& path) {
  const TextFile file(path);
  Trajectory trajectory;
  for (const TextLine& line : file.lines()) {
    const auto fields = split_fields(line.text);
    Eigen::Matrix4d m;
    if (fields.size() != 16) {
      if (is_half_written(line, fields.size() < 16)) continue;
      file.fail(line, fmt::format("has {} numbers where a pose has 16", fields.size()), "write a 4x4 matrix a line");
    }
    for (int i = 0; i < 16; ++i) m(i / 4, i % 4) = parse_double(fields[static_cast<std::size_t>(i)]).value_or(NAN);
    const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
    if (!m.allFinite() || (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > kUnitTolerance ||
        r.determinant() < 0)
      file.fail(line, "the matrix is no rigid motion", "write world_from_camera, metres");
    trajectory.push_back(
        {time_at_30_hz(static_cast<long long>(trajectory.size())), SE3(r, m.topRightCorner<3, 1>()).normalized()});
  }
  return trajectory;
}

std::string color_of(const fs::path& results, const std::string& number) {
  for (const char* extension : {".jpg", ".png"})
    if (is_file(results / ("frame" + number + extension))) return (results / ("frame" + number + extension)).string();
  return {};
}

}  // namespace

bool list_replica(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder, results = folder / "results";
  if (!is_folder(results) || !is_file(folder / "traj.txt")) return false;
  for (const fs::directory_entry& entry : entries_of(results)) {
    const std::string stem = entry.path().stem().string();
    if (!stem.starts_with("depth") || entry.path().extension() != ".png") continue;
    const auto number = parse_unsigned(std::string_view(stem).substr(5));
    if (!number || *number > 1'000'000'000) continue;
    list->entries.push_back({time_at_30_hz(*number), entry.path().string(),
                             options.color ? color_of(results, stem.substr(5)) : std::string()});
  }
  if (list->entries.empty()) return false;
  std::sort(list->entries.begin(), list->entries.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  list->format = "Replica";
  list->depth_scale = 6553.5;
  list->depth_scale_source = "the format's own (Replica, NICE-SLAM), a guess without cam_params.json";
  list->depth_scale_is_guess = true;
  take_recorded_camera(options, list);
  list->groundtruth = (folder / "traj.txt").string();
  list->read_truth = [path = list->groundtruth](std::vector<std::string>*) { return read_traj(path); };
  return true;
}

}  // namespace plumbline
