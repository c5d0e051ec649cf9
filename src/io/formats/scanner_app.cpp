// 3D Scanner App's export "All Data": depth_00000.png in millimetres, conf_00000.png, and for each frame a
// frame_00000.json with the intrinsics of its frame_00000.jpg, ARKit's pose and the time.
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

AppFrame read_frame(const std::string& path) {
  try {
    return parse_frame(json::parse(read_file(path)), path);
  } catch (const json::exception& error) {
    throw Error(fmt::format("is no frame of the 3D Scanner App ({})", error.what()), path, kScannerAppAdvice);
  }
}

std::string existing(const fs::path& path) { return is_file(path) ? path.string() : std::string(); }

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
    frames.push_back(read_frame(file));
    frames.back().entry.depth = entry.path().string();
    frames.back().entry.confidence = existing(folder / ("conf_" + number + ".png"));
    if (options.color) frames.back().entry.color = existing(folder / ("frame_" + number + ".jpg"));
  }
  const auto by_time = [](const AppFrame& a, const AppFrame& b) { return a.entry.time < b.entry.time; };
  std::sort(frames.begin(), frames.end(), by_time);
  const auto same = [](const AppFrame& a, const AppFrame& b) { return a.entry.time == b.entry.time; };
  frames.erase(std::unique(frames.begin(), frames.end(), same), frames.end());
  return frames;
}

/// The intrinsics change with the focus: those in the middle serve for all.
Pinhole middle_camera(std::vector<AppFrame> frames, std::vector<std::string>* notes) {
  std::sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return a.camera.fx < b.camera.fx; });
  const Pinhole& camera = frames[frames.size() / 2].camera;
  const double spread = static_cast<double>((frames.back().camera.fx - frames.front().camera.fx) / camera.fx);
  if (spread > 1e-4)
    notes->push_back(
        fmt::format("the frames' intrinsics differ by {:.2f} %, with the focus; those in the middle "
                    "serve for all",
                    100 * spread));
  return camera;
}

/// The size of the colour images that the intrinsics belong to: by one of them, else by the principal point, near the
/// centre.
void set_size(const std::string& color, Pinhole* camera) {
  if (!color.empty()) try {
      const ImageHeader header = read_image_header(color);
      camera->width = header.width;
      camera->height = header.height;
      return;
    } catch (const Error&) {  // its frame will tell
    }
  for (const auto& [width, height] : {std::pair(1920, 1440), {1440, 1920}, {1280, 960}, {1024, 768}, {640, 480}})
    if (std::abs(2 * camera->cx / static_cast<float>(width) - 1) < 0.08f &&
        std::abs(2 * camera->cy / static_cast<float>(height) - 1) < 0.08f) {
      camera->width = width;
      camera->height = height;
      return;
    }
}

void describe(const std::vector<AppFrame>& frames, SequenceList* list) {
  Pinhole camera = middle_camera(frames, &list->notes);
  const auto with_color =
      std::find_if(frames.begin(), frames.end(), [](const AppFrame& f) { return !f.entry.color.empty(); });
  set_size(with_color == frames.end() ? "" : with_color->entry.color, &camera);
  list->format = "3D Scanner App";
  list->camera =
      CameraChoice{camera, {}, fmt::format("frame_*.json, of {}x{} images", camera.width, camera.height), false};
  list->color_camera = camera;
  list->depth_scale = 1000;
  list->depth_scale_source = "the format's own (3D Scanner App, millimetres)";
}

}  // namespace

bool list_scanner_app(const SequenceOptions& options, SequenceList* list) {
  int without = 0;
  const std::vector<AppFrame> frames = frames_of(options, list->folder, &without);
  if (frames.empty()) return false;
  Trajectory poses;
  for (const AppFrame& frame : frames) {
    list->entries.push_back(frame.entry);
    if (frame.world_from_camera) poses.push_back({frame.entry.time, *frame.world_from_camera});
  }
  describe(frames, list);
  if (without > 0)
    list->notes.push_back(fmt::format("{} depth images have no frame_*.json and were left out", without));
  if (poses.empty()) return true;
  list->groundtruth = list->folder;
  list->read_truth = [poses](std::vector<std::string>*) { return poses; };
  return true;
}

}  // namespace plumbline
