#include "io/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>

#include "core/huge_pages.h"
#include "io/atomic_file.h"
#include "io/pose_matrix.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "io/trajectory_formats.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

constexpr std::size_t kTumFields = 8;
constexpr const char* kTumAdvice = "write each pose as: t tx ty tz qx qy qz qw (seconds, metres, unit quaternion)";

StampedPose parse_pose(const TextFile& file, const TextLine& line, const std::vector<std::string_view>& fields) {
  if (fields.size() != kTumFields)
    file.fail(line, fmt::format("has {} fields where a pose has 8", fields.size()), kTumAdvice);
  const Nanoseconds time = stamp_of(file, line, fields[0], kTumAdvice);
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = parse_double(fields[i + 1]);
    if (!value || !std::isfinite(*value))
      file.fail(line, fmt::format("'{}' is not a finite number", fields[i + 1]),
                value ? "leave out the poses that are not known" : kTumAdvice);
    v[i] = *value;
  }
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (std::abs(rotation.norm() - 1) > kUnitTolerance)
    file.fail(line, fmt::format("the quaternion's length is {:.4g} and not 1", rotation.norm()), kTumAdvice);
  return {time, SE3(rotation, Eigen::Vector3d(v[0], v[1], v[2]))};
}

/// The names of the columns, which some programs write without a '#'.
bool is_heading(const std::vector<std::string_view>& fields) {
  return std::none_of(fields.begin(), fields.end(), [](std::string_view field) { return parse_double(field); });
}

constexpr const char* kPoseMatrixAdvice = "write world_from_camera as a 4x4 matrix, its last row 0 0 0 1";

/// Row-major 4×4 from a pose file; empty if it is not finite.
std::optional<SE3> read_pose_matrix(const std::string& path) {
  const TextFile file(path);
  std::vector<double> numbers;
  for (const TextLine& line : file.lines()) {
    for (const std::string_view field : split_fields(line.text, true)) {
      const auto value = parse_double(field);
      if (!value) file.fail(line, fmt::format("'{}' is not a number", field), kPoseMatrixAdvice);
      numbers.push_back(*value);
    }
  }
  if (numbers.size() != 16)
    throw Error(fmt::format("has {} numbers where a pose has 16", numbers.size()), path, kPoseMatrixAdvice);
  return pose_of_matrix(numbers, path);
}

}  // namespace

std::optional<SE3> pose_of_matrix(const std::vector<double>& numbers, const std::string& path) {
  if (numbers.size() != 12 && numbers.size() != 16)
    throw Error(fmt::format("has {} numbers where a pose has 16", numbers.size()), path, kPoseMatrixAdvice);
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < numbers.size(); ++i) m(static_cast<int>(i / 4), static_cast<int>(i % 4)) = numbers[i];
  if (!m.allFinite()) return std::nullopt;
  const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
  const bool rigid = (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kUnitTolerance &&
                     r.determinant() > 0 && (m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-6;
  if (!rigid) throw Error("the matrix is no rigid motion", path, kPoseMatrixAdvice);
  return SE3(r, m.topRightCorner<3, 1>()).normalized();
}

Trajectory read_tum_trajectory(const std::string& path, std::vector<std::string>* notes) {
  const TextFile file(path);
  Trajectory trajectory;
  reserve_large(&trajectory, file.lines().size());
  std::vector<std::string_view> fields;
  for (const TextLine& line : file.lines()) {
    split_fields(line.text, true, &fields);
    if (&line == &file.lines().front() && is_heading(fields)) continue;
    try {
      trajectory.push_back(parse_pose(file, line, fields));
    } catch (const Error&) {
      if (!is_half_written(line, fields.size() < kTumFields)) throw;
      note_half_written(notes, line);
    }
  }
  if (trajectory.empty()) throw Error("has no poses", path, kTumAdvice);
  sort_and_thin(&trajectory, "poses", notes);
  return trajectory;
}

void write_tum_trajectory(const std::string& path, const Trajectory& trajectory) {
  const bool microseconds =
      std::all_of(trajectory.begin(), trajectory.end(), [](const StampedPose& pose) { return pose.time % 1000 == 0; });
  AtomicFile file(path);
  file.write("# timestamp tx ty tz qx qy qz qw\n");
  for (const StampedPose& pose : trajectory) {
    const std::string stamp = format_seconds(pose.time, microseconds ? 6 : 9);
    if (!pose.world_from_camera.is_finite())
      throw Error("the pose at " + stamp + " s is not finite and cannot be written", path, "leave that pose out");
    const Eigen::Vector3d& t = pose.world_from_camera.translation();
    const Eigen::Quaterniond q = pose.world_from_camera.quaternion();
    file.write(fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", stamp, t.x(), t.y(), t.z(), q.x(),
                           q.y(), q.z(), q.w()));
  }
  file.commit();
}

std::vector<NumberedFile> seven_scenes_files(const std::string& folder, const std::string& suffix) {
  constexpr std::string_view kPrefix = "frame-";
  std::vector<NumberedFile> files;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.size() <= kPrefix.size() + suffix.size() || !name.starts_with(kPrefix) || !name.ends_with(suffix))
      continue;
    const auto number =
        parse_unsigned(std::string_view(name).substr(kPrefix.size(), name.size() - kPrefix.size() - suffix.size()));
    // Numbers beyond this cannot be times.
    if (number && *number < 1'000'000'000) files.push_back({*number, it->path().string()});
  }
  if (error) throw Error("the folder cannot be listed: " + error.message(), folder, "check the path");
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.number != b.number ? a.number < b.number : a.path < b.path; });
  return files;
}

Trajectory read_seven_scenes_poses(const std::string& folder, std::vector<std::string>* notes) {
  Trajectory trajectory;
  int not_finite = 0;
  for (const NumberedFile& file : seven_scenes_files(folder, ".pose.txt")) {
    if (const auto pose = read_pose_matrix(file.path)) {
      trajectory.push_back({time_at_30_hz(file.number), *pose});
    } else {
      ++not_finite;
    }
  }
  if (not_finite > 0) add_note(notes, fmt::format("{} poses that are not finite were left out", not_finite));
  if (trajectory.empty())
    throw Error("has no poses named frame-000000.pose.txt", folder, "give the folder with the frames");
  sort_and_thin(&trajectory, "poses", notes);
  return trajectory;
}

Trajectory read_trajectory(const std::string& path, std::vector<std::string>* notes) {
  if (std::error_code error; std::filesystem::is_directory(path, error)) return read_pose_folder(path, notes);
  if (auto other = read_other_trajectory(TextFile(path), notes)) return std::move(*other);
  return read_tum_trajectory(path, notes);
}

}  // namespace plumbline
