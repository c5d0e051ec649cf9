// Apps for phones that keep a JSON file for each frame, with its intrinsics, ARKit's pose and the time. 3D Scanner
// App's export "All Data": depth_00000.png in millimetres, conf_00000.png, frame_00000.jpg, frame_00000.json. Polycam's
// raw data: depth/, confidence/, images/ and cameras/ in the folder keyframes, the frames' stamps as names.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/formats/arkit.h"
#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/images/image_file.h"
#include "io/pose_matrix.h"
#include "io/recorded_camera.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kScannerAppAdvice = "export the scan again as 'All Data'";

struct AppFrame {
  SequenceEntry entry;
  Pinhole camera;  ///< of its colour image, whose size the file does not tell
  std::optional<SE3> world_from_camera;
};

AppFrame parse_frame(const json& root, const std::string& path) {
  AppFrame frame;
  frame.camera = read_json_camera(path).choice.camera;
  const double time = root.at("time").get<double>();
  if (!(std::abs(time) < 4e9)) throw Error("has an impossible time", path, kScannerAppAdvice);
  frame.entry.time = from_seconds(time);
  if (!root.contains("cameraPoseARFrame")) return frame;
  std::vector<double> numbers;
  for (const json& value : root.at("cameraPoseARFrame")) numbers.push_back(value.get<double>());
  if (const auto pose = pose_of_matrix(numbers, path)) frame.world_from_camera = camera_forward(*pose);
  return frame;
}

/// Polycam's: t_00 to t_23 are the pose's upper three rows, the timestamp counts microseconds.
AppFrame parse_polycam_frame(const json& root, const std::string& path) {
  AppFrame frame;
  frame.camera = read_json_camera(path).choice.camera;
  const double time = root.at("timestamp").get<double>();
  if (!(std::abs(time) < 4e15)) throw Error("has an impossible time", path, kScannerAppAdvice);
  frame.entry.time = time > 1e11 ? 1000 * std::llround(time) : from_seconds(time);
  std::vector<double> numbers;
  for (const char row : {'0', '1', '2'})
    for (const char column : {'0', '1', '2', '3'})
      if (const std::string name = fmt::format("t_{}{}", row, column); root.contains(name))
        numbers.push_back(root.at(name).get<double>());
  if (numbers.size() != 12) return frame;
  if (const auto pose = pose_of_matrix(numbers, path)) frame.world_from_camera = camera_forward(*pose);
  return frame;
}

AppFrame read_frame(const std::string& path, AppFrame (*parse)(const json& root, const std::string& path)) {
  try {
    return parse(json::parse(read_file(path)), path);
  } catch (const json::exception& error) {
    throw Error(fmt::format("is no frame of the app ({})", error.what()), path, kScannerAppAdvice);
  }
}

std::string existing(const fs::path& path) { return is_file(path) ? path.string() : std::string(); }

/// By time, one a stamp.
std::vector<AppFrame> in_order(std::vector<AppFrame> frames) {
  const auto by_time = [](const AppFrame& a, const AppFrame& b) { return a.entry.time < b.entry.time; };
  std::sort(frames.begin(), frames.end(), by_time);
  const auto same = [](const AppFrame& a, const AppFrame& b) { return a.entry.time == b.entry.time; };
  frames.erase(std::unique(frames.begin(), frames.end(), same), frames.end());
  return frames;
}

/// Frames with a depth image and the JSON file of their time and camera. Depth images without that file are counted.
std::vector<AppFrame> frames_of(const SequenceOptions& options, const fs::path& folder, int* without) {
  std::vector<AppFrame> frames;
  for (const fs::directory_entry& entry : entries_of(folder)) {
    const std::string name = entry.path().filename().string(), stem = entry.path().stem().string();
    if (!name.starts_with("depth_") || entry.path().extension() != ".png") continue;
    const std::string number = stem.substr(6), file = existing(folder / ("frame_" + number + ".json"));
    if (file.empty()) {
      ++*without;
      continue;
    }
    frames.push_back(read_frame(file, parse_frame));
    frames.back().entry.depth = entry.path().string();
    frames.back().entry.confidence = existing(folder / ("conf_" + number + ".png"));
    if (options.color) frames.back().entry.color = existing(folder / ("frame_" + number + ".jpg"));
  }
  return in_order(std::move(frames));
}

/// Polycam's, by the camera files.
std::vector<AppFrame> polycam_frames(const SequenceOptions& options, const fs::path& folder) {
  std::vector<AppFrame> frames;
  for (const fs::directory_entry& entry : entries_of(folder / "cameras")) {
    const std::string stem = entry.path().stem().string(), depth = existing(folder / "depth" / (stem + ".png"));
    if (entry.path().extension() != ".json" || depth.empty()) continue;
    frames.push_back(read_frame(entry.path().string(), parse_polycam_frame));
    frames.back().entry.depth = depth;
    frames.back().entry.confidence = existing(folder / "confidence" / (stem + ".png"));
    if (options.color) frames.back().entry.color = existing(folder / "images" / (stem + ".jpg"));
  }
  return in_order(std::move(frames));
}

/// The intrinsics change with the focus: all images are brought to those in the middle.
Pinhole middle_camera(std::vector<AppFrame> frames) {
  std::sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.camera.fx < b.camera.fx; });
  return frames[frames.size() / 2].camera;
}

/// Each frame's own intrinsics, where they differ.
void keep_cameras(const std::vector<AppFrame>& frames, const Pinhole& middle, SequenceList* list) {
  double spread = 0;
  for (const AppFrame& frame : frames)
    spread = std::max(spread, std::abs(static_cast<double>(frame.camera.fx / middle.fx) - 1));
  if (spread < 1e-4) return;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    list->entries[i].camera = frames[i].camera;
    list->entries[i].camera->width = middle.width;
    list->entries[i].camera->height = middle.height;
  }
  list->notes.push_back(
      fmt::format("the frames' intrinsics differ by up to {:.2f} % from those in the middle, with the "
                  "focus; each image is brought to these",
                  100 * spread));
}

/// The size of the colour images that the intrinsics belong to: by one of them, else by the principal point, near the
/// centre.
void set_size(const std::string& color, Pinhole* camera) {
  if (camera->width > 0) return;
  if (!color.empty()) try {
      const ImageHeader header = read_image_header(color);
      camera->width = header.width;
      camera->height = header.height;
      return;
    } catch (const Error&) {  // its frame will tell
    }
  if (const auto sized = sized_by_centre(*camera)) *camera = *sized;
}

void describe(const std::string& app, const std::string& files, const std::vector<AppFrame>& frames,
              SequenceList* list) {
  Pinhole camera = middle_camera(frames);
  const auto with_color =
      std::find_if(frames.begin(), frames.end(), [](const AppFrame& f) { return !f.entry.color.empty(); });
  set_size(with_color == frames.end() ? "" : with_color->entry.color, &camera);
  list->format = app;
  list->camera =
      CameraChoice{camera, {}, fmt::format("{}, of {}x{} images", files, camera.width, camera.height), false};
  list->color_camera = camera;
  keep_cameras(frames, camera, list);
  list->depth_scale = 1000;
  list->depth_scale_source = fmt::format("the format's own ({}, millimetres)", app);
}

void take_frames(const std::string& app, const std::string& files, const std::vector<AppFrame>& frames,
                 SequenceList* list) {
  Trajectory poses;
  for (const AppFrame& frame : frames) {
    list->entries.push_back(frame.entry);
    if (frame.world_from_camera) poses.push_back({frame.entry.time, *frame.world_from_camera});
  }
  describe(app, files, frames, list);
  if (poses.empty()) return;
  list->groundtruth = list->folder;
  list->read_truth = [poses](std::vector<std::string>*) { return poses; };
}

}  // namespace

bool list_scanner_app(const SequenceOptions& options, SequenceList* list) {
  int without = 0;
  const std::vector<AppFrame> frames = frames_of(options, list->folder, &without);
  if (frames.empty()) return false;
  take_frames("3D Scanner App", "frame_*.json", frames, list);
  if (without > 0)
    list->notes.push_back(fmt::format("{} depth images have no frame_*.json and were left out", without));
  return true;
}

bool list_polycam(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder, inside = is_folder(folder / "keyframes") ? folder / "keyframes" : folder;
  if (!is_folder(inside / "cameras") || !is_folder(inside / "depth")) return false;
  const std::vector<AppFrame> frames = polycam_frames(options, inside);
  if (frames.empty()) return false;
  list->folder = inside.string();
  take_frames("Polycam", "cameras/*.json", frames, list);
  return true;
}

}  // namespace plumbline
