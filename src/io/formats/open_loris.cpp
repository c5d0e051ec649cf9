// OpenLORIS-Scene (Shi et al. 2020): lists of stamped files (aligned_depth.txt, depth.txt, color.txt), depth of a
// RealSense D435i in millimetres, sensors.yaml with every camera's intrinsics, and the gyroscope and accelerometer in
// files apart.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/imu/joined_sensors.h"
#include "io/pose_matrix.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "io/trajectory.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOpenLorisAdvice =
    "unpack the data set again, or give the intrinsics with --intrinsics fx,fy,cx,cy";

/// The numbers of a sensor in sensors.yaml by their names, "intrinsics" being a list.
using Section = std::map<std::string, std::vector<double>>;

bool is_sensor(std::string_view key) {
  return key.starts_with("d400") || key.starts_with("t265") || key.starts_with("odom") || key.starts_with("base") ||
         key.starts_with("laser") || key.starts_with("lidar");
}

/// `key: value` lines of OpenCV's YAML, with lists in brackets that may run over several lines.
std::map<std::string, Section> read_sensors(const TextFile& file) {
  std::map<std::string, Section> sensors;
  std::string sensor, key;
  for (const TextLine& line : file.lines()) {
    std::string text(trim(line.text.substr(0, line.text.find('#'))));
    if (const std::size_t colon = text.find(':'); colon != std::string::npos) {
      const std::string name(trim(std::string_view(text).substr(0, colon)));
      text.erase(0, colon + 1);
      if (is_sensor(name) && trim(text).empty()) sensor = name;
      if (name != "data" && name != "rows" && name != "cols" && name != "dt") key = name;
      if (name == "rows" || name == "cols" || name == "dt") continue;
    }
    for (char& c : text)
      if (c == '[' || c == ']') c = ' ';
    for (const std::string_view field : split_fields(text, true))
      if (const auto value = parse_double(field); value && std::isfinite(*value))
        sensors[sensor][key].push_back(*value);
  }
  return sensors;
}

/// fx, cx, fy, cy as the file's comment says, or fx, fy, cx, cy: told apart by fx and fy being equal or nearly so.
/// Pixels; 0: not told.
int side(const Section& section, const char* key) {
  const bool known = section.contains(key) && section.at(key).size() == 1 && section.at(key)[0] <= 16384;
  return known ? static_cast<int>(section.at(key)[0]) : 0;
}

CameraChoice camera_of(const std::map<std::string, Section>& sensors, std::string_view stream,
                       const std::string& path) {
  for (const auto& [name, section] : sensors) {
    if (!name.starts_with(stream) || !section.contains("intrinsics")) continue;
    const std::vector<double>& v = section.at("intrinsics");
    if (v.size() != 4) continue;
    const auto f = [&](std::size_t i) { return static_cast<float>(v[i]); };
    const bool crossed = std::abs(v[1] / v[0] - 1) > 0.1;
    return {{f(0), f(crossed ? 2 : 1), f(crossed ? 1 : 2), f(3), side(section, "width"), side(section, "height")},
            {},
            fmt::format("sensors.yaml ({})", name),
            false};
  }
  throw Error(fmt::format("has no intrinsics of {}", stream), path, kOpenLorisAdvice);
}

/// Lines "seconds x y z".
std::vector<ImuSample> read_triples(const fs::path& path, Eigen::Vector3d ImuSample::*member,
                                    std::vector<std::string>* notes) {
  std::vector<ImuSample> samples;
  if (!is_file(path)) return samples;
  const TextFile file(path.string());
  for (const TextLine& line : file.lines()) {
    const auto fields = split_fields(line.text, true);
    if (fields.size() != 4) {
      if (!is_half_written(line, fields.size() < 4)) file.fail(line, "has other than 4 numbers", kOpenLorisAdvice);
      note_half_written(notes, line);
      continue;
    }
    ImuSample sample;
    sample.time = stamp_of(file, line, fields[0], kOpenLorisAdvice);
    for (std::size_t i = 0; i < 3; ++i)
      (sample.*member)[static_cast<int>(i)] = parse_double(fields[i + 1]).value_or(std::nan(""));
    if ((sample.*member).allFinite()) samples.push_back(sample);
  }
  sort_and_thin(&samples, "samples", notes);
  return samples;
}

ImuRecording read_imu_files(const fs::path& folder, std::vector<std::string>* notes) {
  const auto rates = read_triples(folder / "d400_gyroscope.txt", &ImuSample::angular_rate, notes);
  const auto forces = read_triples(folder / "d400_accelerometer.txt", &ImuSample::specific_force, notes);
  ImuRecording recording;
  recording.has_gyroscope = !rates.empty();
  recording.has_accelerometer = !forces.empty();
  recording.samples = rates.empty() ? forces : forces.empty() ? rates : join_sensors(rates, forces);
  if (!rates.empty() && !forces.empty()) add_note(notes, "d400_gyroscope.txt and d400_accelerometer.txt were joined");
  return recording;
}

struct FrameLink {
  std::string parent, child;
  SE3 parent_from_child;
};

std::string_view bare_name(std::string_view text) {
  text = trim(text);
  const bool is_quoted = text.size() > 1 && (text.front() == '"' || text.front() == '\'');
  return is_quoted ? text.substr(1, text.size() - 2) : text;
}

/// trans_matrix.yaml: parent_frame, child_frame, and a 4×4 matrix that takes points of the child to the parent.
std::vector<FrameLink> read_links(const std::string& path) {
  const TextFile file(path);
  std::vector<FrameLink> links;
  std::string parent, child;
  std::vector<double> numbers;
  for (const TextLine& line : file.lines()) {
    std::string_view text = line.text;
    const std::size_t colon = text.find(':');
    const std::string key(colon == std::string_view::npos ? "" : trim(text.substr(0, colon)));
    if (key.ends_with("parent_frame")) parent = bare_name(text.substr(colon + 1));
    if (key.ends_with("child_frame")) child = bare_name(text.substr(colon + 1));
    if (!key.empty() && key != "data") continue;
    if (key == "data") numbers.clear();
    std::string bare(key.empty() ? text : text.substr(colon + 1));
    for (char& c : bare)
      if (c == '[' || c == ']') c = ' ';
    for (const std::string_view field : split_fields(bare, true))
      if (const auto value = parse_double(field)) numbers.push_back(*value);
    if (numbers.size() != 16) continue;
    if (const auto motion = pose_of_matrix(numbers, path)) links.push_back({parent, child, *motion});
    numbers.clear();
  }
  return links;
}

/// base_from_camera, over at most the links that there are.
std::optional<SE3> base_from(const std::vector<FrameLink>& links, std::string_view camera) {
  std::map<std::string, SE3> reached = {{"base_link", SE3()}};
  for (std::size_t pass = 0; pass <= links.size(); ++pass) {
    for (const auto& [frame, base_from_frame] : reached)
      if (frame.starts_with(camera)) return base_from_frame;
    for (const FrameLink& link : links) {
      if (reached.contains(link.parent)) reached.emplace(link.child, reached[link.parent] * link.parent_from_child);
      if (reached.contains(link.child))
        reached.emplace(link.parent, reached[link.child] * link.parent_from_child.inverse());
    }
  }
  return std::nullopt;
}

/// The true poses are those of the robot's base; trans_matrix.yaml brings them to the camera.
void take_base_poses(std::string_view camera, SequenceList* list) {
  if (list->groundtruth.empty()) return;
  const fs::path file = fs::path(list->folder) / "trans_matrix.yaml";
  std::optional<SE3> base_from_camera;
  try {
    if (is_file(file)) base_from_camera = base_from(read_links(file.string()), camera);
  } catch (const Error&) {  // damaged, which is no reason not to reconstruct: told below
  }
  if (!base_from_camera) {
    list->notes.push_back(fmt::format("the true poses may be those of the robot's base: {}",
                                      is_file(file) ? "trans_matrix.yaml does not lead from base_link to the camera"
                                                    : "there is no trans_matrix.yaml that leads to the camera"));
    return;
  }
  list->notes.emplace_back("the true poses, those of the robot's base, are brought to the camera by trans_matrix.yaml");
  list->read_truth = [path = list->groundtruth, motion = *base_from_camera](std::vector<std::string>* notes) {
    Trajectory poses = read_trajectory(path, notes);
    for (StampedPose& pose : poses) pose.world_from_camera = pose.world_from_camera * motion;
    return poses;
  };
}

}  // namespace

bool list_open_loris(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  const std::string sensors = (folder / "sensors.yaml").string();
  const bool aligned = is_file(folder / "aligned_depth.txt");
  if (!is_file(sensors) || (!aligned && !is_file(folder / "depth.txt"))) return false;
  const std::string name = aligned ? "aligned_depth.txt" : "depth.txt";
  std::vector<StampedFile> depth = read_list(name, list), color;
  keep_depth((folder / name).string(), &depth, list);
  const bool wants_color = options.color && is_file(folder / "color.txt");
  if (wants_color && aligned) {
    color = read_list("color.txt", list);
    keep_color(&color, &list->notes);
  }
  list->entries = join(depth, color, max_difference(options), &list->notes);
  if (wants_color && !aligned)
    list->notes.emplace_back("colour is not used, because depth is not aligned to it (aligned_depth.txt is missing)");
  list->format = "OpenLORIS-Scene";
  list->camera = camera_of(read_sensors(TextFile(sensors)), aligned ? "d400_color" : "d400_depth", sensors);
  list->depth_scale = 1000;
  list->depth_scale_source = "the data set's own (OpenLORIS-Scene, millimetres)";
  list->groundtruth = find_groundtruth(folder);
  take_base_poses(aligned ? "d400_color" : "d400_depth", list);
  list->read_imu = [folder](std::vector<std::string>* notes) { return read_imu_files(folder, notes); };
  // The axes of a RealSense's inertial sensor are those of its depth camera.
  list->body_from_camera = Eigen::Matrix3d::Identity();
  return true;
}

}  // namespace plumbline
