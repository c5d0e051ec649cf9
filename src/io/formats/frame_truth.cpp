// True poses that recordings keep by the frames' numbers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "io/formats/frame_files.h"
#include "io/pose_matrix.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "io/trajectory.h"
#include "io/trajectory_formats.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// Poses of frames without stamps, at the stamps that their images have.
Trajectory at_frames(const Trajectory& numbered, const std::map<long long, Nanoseconds>& time_of,
                     std::vector<std::string>* notes) {
  Trajectory poses;
  for (const StampedPose& pose : numbered) {
    const auto number = static_cast<long long>(std::llround(30 * to_seconds(pose.time)));  // see time_at_30_hz()
    const auto found = time_of.find(number);
    if (found != time_of.end()) poses.push_back({found->second, pose.world_from_camera});
  }
  if (poses.size() < numbered.size())
    add_note(notes,
             fmt::format("{} of {} poses belong to no depth image", numbered.size() - poses.size(), numbered.size()));
  sort_and_thin(&poses, "poses", notes);
  return poses;
}

/// The first number in a file's name.
std::optional<long long> number_in_name(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  const std::size_t begin = name.find_first_of("0123456789");
  if (begin == std::string::npos) return std::nullopt;
  return parse_unsigned(std::string_view(name).substr(begin, name.find_first_not_of("0123456789", begin) - begin));
}

/// SUN3D's extrinsics/STAMP.txt, of which the newest counts: three lines of four numbers a frame.
Trajectory read_sun3d(const std::string& path, std::vector<std::string>* notes) {
  const TextFile file(path);
  std::vector<double> numbers;
  Trajectory poses;
  for (const TextLine& line : file.lines()) {
    for (const std::string_view field : split_fields(line.text))
      numbers.push_back(parse_double(field).value_or(std::nan("")));
    if (numbers.size() < 12) continue;
    if (const auto pose = pose_of_matrix(numbers, path))
      poses.push_back({time_at_30_hz(static_cast<long long>(poses.size())), *pose});
    numbers.clear();
  }
  if (!numbers.empty()) add_note(notes, "the last pose is half-written and was left out");
  return poses;
}

/// Three whole numbers, then a matrix's first line: no log of a program.
bool is_pose_log(const std::string& path) {
  const TextFile file(path);
  if (file.lines().size() < 5) return false;
  const auto numbers = [&](std::size_t line, std::size_t count) {
    const auto fields = split_fields(file.lines()[line].text, true);
    return fields.size() == count &&
           std::all_of(fields.begin(), fields.end(), [](std::string_view field) { return parse_double(field); });
  };
  return numbers(0, 3) && numbers(1, 4);
}

std::string newest_file(const fs::path& folder, std::string_view extension) {
  std::string newest;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (entry.path().extension() == extension) newest = std::max(newest, entry.path().string());
  return newest;
}

}  // namespace

void take_truth(SequenceList* list) {
  list->groundtruth = find_groundtruth(list->folder);
  if (!list->groundtruth.empty()) return;
  const fs::path folder = list->folder;
  std::map<long long, Nanoseconds> by_place, by_number;
  for (std::size_t i = 0; i < list->entries.size(); ++i) {
    by_place.emplace(static_cast<long long>(i), list->entries[i].time);
    if (const auto number = number_in_name(list->entries[i].depth)) by_number.emplace(*number, list->entries[i].time);
  }
  const std::string log = newest_file(folder, ".log");
  if (is_folder(folder / "pose")) {
    list->groundtruth = (folder / "pose").string();
    list->read_truth = [path = list->groundtruth, by_number](std::vector<std::string>* notes) {
      return at_frames(read_pose_folder(path, nullptr), by_number, notes);
    };
  } else if (const std::string sun3d = newest_file(folder / "extrinsics", ".txt"); !sun3d.empty()) {
    list->groundtruth = sun3d;
    list->read_truth = [sun3d, by_place](std::vector<std::string>* notes) {
      return at_frames(read_sun3d(sun3d, notes), by_place, notes);
    };
  } else if (!log.empty() && is_pose_log(log)) {
    list->groundtruth = log;
    list->read_truth = [log, by_place](std::vector<std::string>* notes) {
      return at_frames(read_trajectory(log), by_place, notes);
    };
  }
}

}  // namespace plumbline
