// Record3D's export "EXR + RGB" (also as PNG or TIFF sequence): depth/0.exr in metres, rgb/0.jpg, and metadata.json
// with the intrinsics of the colour images (K, in columns), the frames' rate or stamps, and ARKit's poses.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "io/formats/arkit.h"
#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/recorded_camera.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kRecord3dAdvice = "export the recording again as 'EXR + RGB'";
constexpr double kMaxTime = 4e9;  // s

struct Metadata {
  std::string path;
  Pinhole color;
  double rate = 30;
  bool rate_is_guess = true;
  std::vector<double> stamps;  ///< s
  std::vector<SE3> poses;      ///< world_from_camera

  Nanoseconds time(std::size_t frame) const {
    return from_seconds(frame < stamps.size() ? stamps[frame] : static_cast<double>(frame) / rate);
  }
};

/// qx qy qz qw tx ty tz.
SE3 pose_of(const json& values, const std::string& path) {
  std::array<double, 7> v{};
  if (!values.is_array() || values.size() != v.size())
    throw Error("has a pose of other than 7 numbers", path, kRecord3dAdvice);
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = values.at(i).get<double>();
  const Eigen::Quaterniond q(v[3], v[0], v[1], v[2]);
  const Eigen::Vector3d t(v[4], v[5], v[6]);
  if (!t.allFinite() || !(std::abs(q.norm() - 1) <= kUnitTolerance))
    throw Error("holds no pose", path, kRecord3dAdvice);
  return camera_forward(SE3(q, t));
}

Metadata parse_metadata(const json& root, const std::string& path) {
  Metadata data;
  data.path = path;
  data.color = read_json_camera(path).choice.camera;
  if (root.contains("fps") && root.at("fps").is_number()) {
    data.rate = root.at("fps").get<double>();
    if (!(data.rate > 0.01 && data.rate < 1e4)) throw Error("has an impossible rate of frames", path, kRecord3dAdvice);
    data.rate_is_guess = false;
  }
  if (root.contains("frameTimestamps"))
    for (const json& stamp : root.at("frameTimestamps")) {
      data.stamps.push_back(stamp.get<double>());
      if (!(std::abs(data.stamps.back()) < kMaxTime)) throw Error("has an impossible stamp", path, kRecord3dAdvice);
    }
  if (root.contains("poses"))
    for (const json& pose : root.at("poses")) data.poses.push_back(pose_of(pose, path));
  return data;
}

Metadata read_metadata(const std::string& path) {
  try {
    return parse_metadata(json::parse(read_file(path)), path);
  } catch (const json::exception& error) {
    throw Error(fmt::format("is no metadata of Record3D ({})", error.what()), path, kRecord3dAdvice);
  }
}

/// The folder that holds depth/: that of metadata.json, or EXR_RGBD in it.
fs::path frames_folder(const fs::path& folder) {
  for (const fs::path& place : {folder, folder / "EXR_RGBD"})
    if (is_folder(place / "depth") && is_folder(place / "rgb")) return place;
  return {};
}

std::string metadata_file(const fs::path& folder, const fs::path& frames) {
  for (const fs::path& place : {folder, frames, folder.parent_path()})
    for (const char* name : {"metadata.json", "metadata"})
      if (is_file(place / name)) return (place / name).string();
  return {};
}

std::string numbered(const fs::path& folder, const std::string& stem, std::initializer_list<const char*> extensions) {
  for (const char* extension : extensions)
    if (is_file(folder / (stem + extension))) return (folder / (stem + extension)).string();
  return {};
}

void list_frames(const SequenceOptions& options, const fs::path& frames, const Metadata& data, SequenceList* list,
                 std::map<std::size_t, Nanoseconds>* times) {
  for (const fs::directory_entry& entry : entries_of(frames / "depth")) {
    const std::string stem = entry.path().stem().string(), extension = lower(entry.path().extension().string());
    const auto number = parse_unsigned(stem);
    if (!number || *number > 1'000'000'000 || (extension != ".exr" && extension != ".png" && extension != ".tiff"))
      continue;
    const Nanoseconds time = data.time(static_cast<std::size_t>(*number));
    list->entries.push_back({time, entry.path().string(),
                             options.color ? numbered(frames / "rgb", stem, {".jpg", ".jpeg", ".png"}) : std::string(),
                             numbered(frames / "confidence", stem, {".png"})});
    times->emplace(static_cast<std::size_t>(*number), time);
  }
  std::sort(list->entries.begin(), list->entries.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  const auto same = [](const auto& a, const auto& b) { return a.time == b.time; };
  if (std::adjacent_find(list->entries.begin(), list->entries.end(), same) != list->entries.end())
    throw Error("gives two depth images one stamp", data.path, kRecord3dAdvice);
}

void describe(const Metadata& data, SequenceList* list) {
  list->format = "Record3D";
  list->camera =
      CameraChoice{data.color,
                   {},
                   fmt::format("metadata.json, of the {}x{} colour images", data.color.width, data.color.height),
                   false};
  list->color_camera = data.color;
  list->depth_scale = 1000;
  list->depth_scale_source = "the format's own (Record3D)";
  if (data.stamps.empty())
    list->notes.push_back(
        fmt::format("frame k is taken to be at k/{:g} s{}", data.rate,
                    data.rate_is_guess ? ", a guess: metadata.json tells no rate" : ", by metadata.json"));
}

}  // namespace

bool list_record3d(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder, frames = frames_folder(folder);
  const std::string file = frames.empty() ? "" : metadata_file(folder, frames);
  if (file.empty()) return false;
  const Metadata data = read_metadata(file);
  std::map<std::size_t, Nanoseconds> times;
  list_frames(options, frames, data, list, &times);
  if (list->entries.empty())
    throw Error("holds no depth images named 0.exr, 1.exr, …", (frames / "depth").string(), kRecord3dAdvice);
  describe(data, list);
  if (data.poses.empty()) return true;
  Trajectory poses;
  for (const auto& [number, time] : times)
    if (number < data.poses.size()) poses.push_back({time, data.poses[number]});
  list->groundtruth = file;
  list->read_truth = [poses](std::vector<std::string>*) { return poses; };
  return true;
}

}  // namespace plumbline
