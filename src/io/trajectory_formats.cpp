#include "io/trajectory_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "io/columns.h"
#include "io/pose_matrix.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "io/trajectory.h"
#include "plumbline/error.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTrajectoryFormatsAdvice =
    "write each pose as: t tx ty tz qx qy qz qw (seconds, metres, unit quaternion)";
constexpr int kDecimalsOfNanoseconds = 9;

/// Where in a line a stamped pose stands.
struct PoseColumns {
  std::size_t fields = 0, stamp = 0;
  std::array<std::size_t, 3> position{};
  std::array<std::size_t, 4> quaternion{};  ///< x y z w
  double metres = 1;                        ///< of the position's unit
  int decimals = 0;                         ///< digits by which the stamps' point must move left for seconds
};

/// 'x', 'y' or 'z' if the name is that of a position's component, else 0.
char position_component(std::string_view name) {
  if (name.empty() || name.back() < 'x' || name.back() > 'z' || quaternion_component(name) != 0) return 0;
  std::string stem;
  for (const char c : name.substr(0, name.size() - 1))
    if (c != '_' && c != '.' && c != '/' && c != ' ') stem += c;
  for (const std::string_view known : {"", "t", "p", "pos", "prsr", "trans", "pwb", "pgt"})
    if (stem == known) return name.back();
  return stem.ends_with("position") || stem.ends_with("translation") ? name.back() : '\0';
}

/// Decimals of a stamp's unit; negative: it is not told.
int decimals_of(const ColumnName& column) {
  constexpr std::array<std::pair<std::string_view, int>, 3> kUnits = {{{"ns", 9}, {"us", 6}, {"ms", 3}}};
  for (const auto& [unit, decimals] : kUnits)
    if (column.unit == unit || column.name.ends_with(fmt::format("_{}", unit))) return decimals;
  return column.unit == "s" || column.unit == "sec" ? 0 : -1;
}

std::optional<PoseColumns> columns_by_name(const std::vector<ColumnName>& names, std::string_view first_stamp) {
  PoseColumns columns;
  columns.fields = names.size();
  int found = 0;
  for (std::size_t i = names.size(); i-- > 0;) {  // of doubled names the first counts
    if (const char c = quaternion_component(names[i].name); c != 0) {
      columns.quaternion[c == 'w' ? 3 : static_cast<std::size_t>(c - 'x')] = i;
      found |= 1 << (c - 'w');
    } else if (const char p = position_component(names[i].name); p != 0) {
      columns.position[static_cast<std::size_t>(p - 'x')] = i;
      found |= 16 << (p - 'x');
      columns.metres = names[i].unit == "mm" ? 1e-3 : names[i].unit == "cm" ? 1e-2 : 1;
    } else if (names[i].name.find("time") != std::string::npos || names[i].name.find("stamp") != std::string::npos) {
      columns.stamp = i;
    }
  }
  if (found != 0x7f) return std::nullopt;
  columns.decimals = decimals_of(names[columns.stamp]);
  if (columns.decimals < 0) columns.decimals = decimals_by_size(first_stamp);
  return columns;
}

/// Without a heading: stamps of nanoseconds, EuRoC's order after commas, a number behind the pose. Empty for TUM's own.
std::optional<PoseColumns> columns_by_form(const TextLine& line, std::vector<std::string>* notes) {
  const auto fields = split_fields(line.text, true);
  const bool numbers =
      std::all_of(fields.begin(), fields.end(), [](std::string_view field) { return parse_double(field); });
  if (!numbers || fields.size() < 8) return std::nullopt;
  PoseColumns columns{fields.size(), 0, {1, 2, 3}, {4, 5, 6, 7}, 1, decimals_by_size(fields[0])};
  const bool commas = line.text.find(',') != std::string_view::npos;
  if (columns.decimals == kDecimalsOfNanoseconds && commas) {
    columns.quaternion = {5, 6, 7, 4};
    add_note(notes, "no heading, nanoseconds and commas: taken for EuRoC's form, with the quaternion's w first");
    return columns;
  }
  const bool with_id = fields.size() == 9 && parse_unsigned(fields[8]);
  if (with_id) add_note(notes, "the ninth number of each line is taken for an id");
  if (columns.decimals > 0)
    add_note(notes, fmt::format("the stamps are taken for {}, by their size", unit_of_decimals(columns.decimals)));
  if ((fields.size() == 8 && columns.decimals > 0) || with_id) return columns;
  return std::nullopt;
}

bool is_tum(const PoseColumns& c) {
  return c.fields == 8 && c.stamp == 0 && c.position == std::array<std::size_t, 3>{1, 2, 3} &&
         c.quaternion == std::array<std::size_t, 4>{4, 5, 6, 7} && c.decimals == 0 && c.metres == 1;
}

double number_at(const TextFile& file, const TextLine& line, std::string_view field) {
  const auto value = parse_double(field);
  if (!value || !std::isfinite(*value))
    file.fail(line, fmt::format("'{}' is not a finite number", field), kTrajectoryFormatsAdvice);
  return *value;
}

StampedPose pose_at(const TextFile& file, const TextLine& line, const std::vector<std::string_view>& fields,
                    const PoseColumns& columns) {
  if (fields.size() != columns.fields)
    file.fail(line, fmt::format("has {} fields where the lines before have {}", fields.size(), columns.fields),
              kTrajectoryFormatsAdvice);
  Eigen::Vector3d t;
  Eigen::Vector4d q;
  for (int i = 0; i < 3; ++i) t[i] = number_at(file, line, fields[columns.position[static_cast<std::size_t>(i)]]);
  for (int i = 0; i < 4; ++i) q[i] = number_at(file, line, fields[columns.quaternion[static_cast<std::size_t>(i)]]);
  if (std::abs(q.norm() - 1) > kUnitTolerance)
    file.fail(line, fmt::format("the quaternion's length is {:.4g} and not 1", q.norm()), kTrajectoryFormatsAdvice);
  return {stamp_of(file, line, fields[columns.stamp], kTrajectoryFormatsAdvice, columns.decimals),
          SE3(Eigen::Quaterniond(q), columns.metres * t)};
}

Trajectory read_rows(const TextFile& file, const Table& table, const PoseColumns& columns,
                     std::vector<std::string>* notes) {
  Trajectory trajectory;
  trajectory.reserve(table.rows.size());
  for (const TextLine& line : table.rows) {
    const auto fields = table_fields(line.text);
    try {
      trajectory.push_back(pose_at(file, line, fields, columns));
    } catch (const Error&) {
      if (!is_half_written(line, fields.size() < columns.fields)) throw;
      note_half_written(notes, line);
    }
  }
  return trajectory;
}

/// All numbers of some lines. Throws Error for other text.
std::vector<double> numbers_of(const TextFile& file, const TextLine* begin, const TextLine* end) {
  std::vector<double> numbers;
  for (const TextLine* line = begin; line != end; ++line)
    for (const std::string_view field : split_fields(line->text, true)) {
      const auto value = parse_double(field);
      if (!value) file.fail(*line, fmt::format("'{}' is not a number", field), kTrajectoryFormatsAdvice);
      numbers.push_back(*value);
    }
  return numbers;
}

/// Counts poses that are not finite, which programs write for frames that they lost.
class MatrixPoses {
 public:
  MatrixPoses(const std::string& path, std::vector<std::string>* notes) : path_(path), notes_(notes) {}

  void add(Nanoseconds time, const std::vector<double>& numbers) {
    if (const auto pose = pose_of_matrix(numbers, path_))
      trajectory_.push_back({time, *pose});
    else
      ++not_finite_;
  }
  Trajectory take() {
    if (not_finite_ > 0) add_note(notes_, fmt::format("{} poses that are not finite were left out", not_finite_));
    if (trajectory_.empty()) throw Error("has no poses", path_, kTrajectoryFormatsAdvice);
    sort_and_thin(&trajectory_, "poses", notes_);
    return std::move(trajectory_);
  }

 private:
  const std::string& path_;
  std::vector<std::string>* notes_;
  Trajectory trajectory_;
  int not_finite_ = 0;
};

/// Redwood's and Open3D's .log: three whole numbers (the first is the frame's), then the matrix's four lines.
std::optional<Trajectory> read_log(const TextFile& file, std::vector<std::string>* notes) {
  const std::vector<TextLine>& lines = file.lines();
  constexpr std::size_t kLines = 5;
  if (lines.size() < kLines) return std::nullopt;
  const auto head = split_fields(lines[0].text, true);
  if (head.size() != 3 || !parse_double(head[0]) || split_fields(lines[1].text, true).size() != 4) return std::nullopt;
  MatrixPoses poses(file.path(), notes);
  for (std::size_t i = 0; i + kLines <= lines.size(); i += kLines) {
    const auto frame = parse_unsigned(split_fields(lines[i].text, true)[0]);
    if (!frame || *frame > 1'000'000'000)
      file.fail(lines[i], "does not begin with the number of a frame", kTrajectoryFormatsAdvice);
    poses.add(time_at_30_hz(*frame), numbers_of(file, &lines[i + 1], &lines[i] + kLines));
  }
  if (lines.size() % kLines != 0) add_note(notes, "the last pose is half-written and was left out");
  add_note(notes, "a .log without stamps: frame k is at k/30 s");
  return poses.take();
}

/// The stamps of KITTI's times.txt beside the poses, or in the folder above, one a line.
std::vector<Nanoseconds> times_beside(const std::string& path, std::size_t count) {
  const fs::path folder = fs::path(path).parent_path();
  for (const fs::path& candidate : {folder / "times.txt", folder / (fs::path(path).stem().string() + "_times.txt")}) {
    std::error_code error;
    if (!fs::is_regular_file(candidate, error)) continue;
    const TextFile file(candidate.string());
    if (file.lines().size() < count) continue;
    std::vector<Nanoseconds> times;
    for (const TextLine& line : file.lines())
      times.push_back(stamp_of(file, line, first_field(line), kTrajectoryFormatsAdvice));
    return times;
  }
  return {};
}

/// A matrix a line: 12 numbers as in KITTI, or 16 as in Replica's traj.txt.
std::optional<Trajectory> read_matrix_lines(const TextFile& file, std::vector<std::string>* notes) {
  const std::vector<TextLine>& lines = file.lines();
  if (lines.empty()) return std::nullopt;
  const std::size_t fields = split_fields(lines.front().text, true).size();
  if (fields != 12 && fields != 16) return std::nullopt;
  if (!parse_double(first_field(lines.front()))) return std::nullopt;
  const std::vector<Nanoseconds> times =
      fields == 12 ? times_beside(file.path(), lines.size()) : std::vector<Nanoseconds>{};
  constexpr Nanoseconds kKittiInterval = kNanosecondsPerSecond / 10;
  MatrixPoses poses(file.path(), notes);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<double> numbers = numbers_of(file, &lines[i], &lines[i] + 1);
    if (numbers.size() != fields) {
      if (!is_half_written(lines[i], numbers.size() < fields))
        file.fail(lines[i], fmt::format("has {} fields where the lines before have {}", numbers.size(), fields),
                  kTrajectoryFormatsAdvice);
      note_half_written(notes, lines[i]);
      continue;
    }
    const auto k = static_cast<long long>(i);
    poses.add(!times.empty() ? times[i] : fields == 12 ? k * kKittiInterval : time_at_30_hz(k), numbers);
  }
  add_note(notes, !times.empty() ? "the stamps are those of times.txt"
                                 : fmt::format("matrices without stamps: pose k is at k/{} s", fields == 12 ? 10 : 30));
  return poses.take();
}

/// Files named by a number alone, in the folder or its subfolder "pose".
std::vector<NumberedFile> numbered_files(const fs::path& folder) {
  std::vector<NumberedFile> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != ".txt") continue;
    const std::string stem = it->path().stem().string();
    const auto number = parse_unsigned(stem);
    if (number && *number < 1'000'000'000) files.push_back({*number, it->path().string()});
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  return files;
}

}  // namespace

std::optional<Trajectory> read_other_trajectory(const TextFile& file, std::vector<std::string>* notes) {
  const Table table = read_table(file);
  if (table.rows.empty()) return std::nullopt;
  const std::vector<ColumnName> names = column_names(table.head);
  std::optional<PoseColumns> columns;
  if (names.size() == table_fields(table.rows.front().text).size())
    columns = columns_by_name(names, first_field(table.rows.front()));
  if (columns && is_tum(*columns)) return std::nullopt;
  if (!columns)
    if (auto log = read_log(file, notes)) return log;
  if (!columns)
    if (auto matrices = read_matrix_lines(file, notes)) return matrices;
  if (!columns) columns = columns_by_form(table.rows.front(), notes);
  if (!columns) return std::nullopt;
  Trajectory trajectory = read_rows(file, table, *columns, notes);
  if (trajectory.empty()) throw Error("has no poses", file.path(), kTrajectoryFormatsAdvice);
  sort_and_thin(&trajectory, "poses", notes);
  return trajectory;
}

Trajectory read_pose_folder(const std::string& folder, std::vector<std::string>* notes) {
  if (!seven_scenes_files(folder, ".pose.txt").empty()) return read_seven_scenes_poses(folder, notes);
  std::error_code error;
  const fs::path inside = fs::path(folder) / "pose";
  const std::vector<NumberedFile> files = numbered_files(fs::is_directory(inside, error) ? inside : fs::path(folder));
  if (files.empty()) {
    const fs::path replica = fs::path(folder) / "traj.txt";
    if (fs::is_regular_file(replica, error)) return read_trajectory(replica.string(), notes);
    throw Error("has no poses named frame-000000.pose.txt, pose/0.txt or traj.txt", folder,
                "give a file of poses, or the folder with them");
  }
  MatrixPoses poses(folder, notes);
  for (const NumberedFile& numbered : files) {
    const TextFile file(numbered.path);
    const TextLine* lines = file.lines().data();
    poses.add(time_at_30_hz(numbered.number), numbers_of(file, lines, lines + file.lines().size()));
  }
  add_note(notes, "a folder of poses without stamps: frame k is at k/30 s");
  return poses.take();
}

}  // namespace plumbline
