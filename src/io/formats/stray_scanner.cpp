// StrayScanner (an app for phones with LiDAR): depth/000000.png in millimetres, confidence/, odometry.csv with ARKit's
// poses and the frames' stamps, imu.csv, and camera_matrix.csv, which is that of the video.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "io/columns.h"
#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/recorded_camera.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOdometryAdvice = "export the recording again: timestamp, frame, x, y, z, qx, qy, qz, qw";

struct Odometry {
  std::map<long long, Nanoseconds> time_of_frame;
  Trajectory poses;
};

/// ARKit's poses: world_from_camera with the camera's x right, y down, z forward, as the app writes them.
Odometry read_odometry(const std::string& path, std::vector<std::string>* notes) {
  const TextFile file(path);
  const Table table = read_table(file);
  Odometry odometry;
  for (const TextLine& line : table.rows) {
    const auto fields = table_fields(line.text);
    if (fields.size() < 9 && is_half_written(line, true)) {
      note_half_written(notes, line);
      continue;
    }
    const auto frame = fields.size() < 9 ? std::nullopt : parse_unsigned(fields[1]);
    if (!frame) file.fail(line, "is no line of a StrayScanner odometry.csv", kOdometryAdvice);
    const Nanoseconds time = stamp_of(file, line, fields[0], kOdometryAdvice);
    odometry.time_of_frame.emplace(*frame, time);
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = parse_double(fields[i + 2]).value_or(NAN);
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!std::isfinite(v[0] + v[1] + v[2]) || !(std::abs(q.norm() - 1) <= kUnitTolerance))
      file.fail(line, "holds no pose", kOdometryAdvice);
    odometry.poses.push_back({time, SE3(q, Eigen::Vector3d(v[0], v[1], v[2]))});
  }
  sort_and_thin(&odometry.poses, "poses", notes);
  return odometry;
}

/// The matrix belongs to the video, whose size follows from the principal point: near its centre.
Pinhole video_camera(const std::string& path) {
  const Pinhole camera = read_matrix_file(path);
  if (const auto sized = sized_by_centre(camera)) return *sized;
  throw Error(fmt::format("the principal point ({}, {}) is that of no video size that is known", camera.cx, camera.cy),
              path, "give the intrinsics of the depth images with --intrinsics");
}

std::string image_beside(const fs::path& folder, const std::string& stem) {
  for (const char* extension : {".png", ".jpg", ".jpeg"})
    if (is_file(folder / (stem + extension))) return (folder / (stem + extension)).string();
  return {};
}

void list_frames(const SequenceOptions& options, const Odometry& odometry, SequenceList* list) {
  const fs::path folder = list->folder;
  int without_time = 0;
  // ffmpeg counts from 1, if not told otherwise; the app's depth images from 0.
  const bool from_one = options.color && !image_beside(folder / "rgb", "000001").empty() &&
                        image_beside(folder / "rgb", "000000").empty() &&
                        !image_beside(folder / "depth", "000000").empty();
  for (const fs::directory_entry& entry : entries_of(folder / "depth")) {
    const std::string stem = entry.path().stem().string();
    const std::string extension = lower(entry.path().extension().string());
    const auto number = parse_unsigned(stem);
    if (!number || (extension != ".png" && extension != ".npy")) continue;
    const auto time = odometry.time_of_frame.find(*number);
    if (!odometry.time_of_frame.empty() && time == odometry.time_of_frame.end()) {
      ++without_time;
      continue;
    }
    list->entries.push_back(
        {odometry.time_of_frame.empty() ? time_at_30_hz(*number) : time->second, entry.path().string(),
         options.color ? image_beside(folder / "rgb", from_one ? fmt::format("{:06}", *number + 1) : stem)
                       : std::string(),
         image_beside(folder / "confidence", stem)});
  }
  std::sort(list->entries.begin(), list->entries.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  if (from_one)
    list->notes.emplace_back("colour images are numbered from 1 and depth from 0: they are paired in order, a guess");
  if (without_time > 0)
    list->notes.push_back(fmt::format("{} depth images have no line in odometry.csv and were left out", without_time));
}

void describe(const SequenceOptions& options, const Pinhole& video, SequenceList* list) {
  list->format = "StrayScanner";
  list->camera =
      CameraChoice{video, {}, fmt::format("camera_matrix.csv, of the {}x{} video", video.width, video.height), false};
  list->color_camera = video;
  list->depth_scale = 1000;
  list->depth_scale_source = "the format's own (StrayScanner, millimetres)";
  // Camera axes (x, y, z) are (−y, −x, −z) of the phone's.
  list->body_from_camera = (Eigen::Matrix3d() << 0, -1, 0, -1, 0, 0, 0, 0, -1).finished();
  if (options.color && is_file(fs::path(list->folder) / "rgb.mp4") && list->entries.front().color.empty())
    list->notes.emplace_back(
        "colour is not used, because it is a video (rgb.mp4): unpack it with `mkdir rgb; ffmpeg "
        "-i rgb.mp4 -start_number 0 rgb/%06d.jpg`");
}

}  // namespace

bool list_stray_scanner(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  if (!is_file(folder / "camera_matrix.csv") || !is_folder(folder / "depth")) return false;
  const std::string odometry_file = (folder / "odometry.csv").string();
  Odometry odometry;
  if (is_file(odometry_file)) odometry = read_odometry(odometry_file, &list->notes);
  list_frames(options, odometry, list);
  if (list->entries.empty())
    throw Error("holds no depth images with a line in odometry.csv", (folder / "depth").string(),
                "copy the whole recording from the phone");
  describe(options, video_camera((folder / "camera_matrix.csv").string()), list);
  if (odometry.poses.empty()) {
    list->notes.emplace_back("without odometry.csv, the images are taken to be 1/30 s apart, a guess");
    return true;
  }
  list->groundtruth = odometry_file;
  list->read_truth = [odometry_file](std::vector<std::string>* notes) {
    return read_odometry(odometry_file, notes).poses;
  };
  return true;
}

}  // namespace plumbline
