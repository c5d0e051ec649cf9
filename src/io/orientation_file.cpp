#include "plumbline/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "io/atomic_file.h"
#include "io/columns.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

constexpr const char* kOrientationFileAdvice =
    "write each orientation as: t qx qy qz qw (seconds, unit quaternion), or give a file in TUM's or EuRoC's format";

constexpr std::string_view kTiltOnly = "tilt only";

/// Where in a line the quaternion stands.
struct Columns {
  std::array<std::size_t, 4> quaternion{};  ///< in the order of the file
  QuaternionOrder order = QuaternionOrder::xyzw;
};

/// Where in a line three angles stand.
struct EulerColumns {
  std::size_t heading = 0, roll = 0, pitch = 0;
  bool clockwise = false;  ///< a heading from north to the east, as the BNO055's; else a yaw against the clock
  double radians = 1;      ///< of the angles' unit
};

struct OrientationLayout {
  std::size_t fields = 0;
  bool nanoseconds = false;
  Columns columns;
  std::optional<EulerColumns> euler = {};  ///< instead of `columns`
  double counts = 1;                       ///< of a quaternion of unit length
};

std::optional<Columns> columns_by_name(const std::vector<ColumnName>& names) {
  Columns columns;
  std::string components;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const char component = quaternion_component(names[i].name);
    if (component == 0) continue;
    if (components.size() < 4) columns.quaternion[components.size()] = i;
    components += component;
  }
  if (components != "xyzw" && components != "wxyz") return std::nullopt;
  if (components == "wxyz") columns.order = QuaternionOrder::wxyz;
  return columns;
}

std::optional<Columns> columns_by_number(std::size_t fields, bool nanoseconds) {
  const QuaternionOrder order = nanoseconds ? QuaternionOrder::wxyz : QuaternionOrder::xyzw;
  if (fields == 5) return Columns{{1, 2, 3, 4}, order};
  if (fields == 8 || (nanoseconds && fields > 8)) return Columns{{4, 5, 6, 7}, order};
  return std::nullopt;
}

/// Radians of one unit of the angles: by the unit's name, else by the largest. The BNO055's registers count sixteenths
/// of a degree.
double unit_of_angles(const std::string& unit, const EulerColumns& euler, const std::vector<TextLine>& rows) {
  constexpr double kFullTurn = 6.3, kTwoTurns = 720, kCounts = 16;
  if (!unit.empty()) return unit.starts_with("deg") || unit == "°" ? kRadiansPerDegree : 1;
  double largest = 0;
  for (const TextLine& row : rows) {
    const auto fields = table_fields(row.text);
    for (const std::size_t i : {euler.heading, euler.roll, euler.pitch})
      if (i < fields.size()) largest = std::max(largest, std::abs(parse_double(fields[i]).value_or(0)));
  }
  return largest > kTwoTurns ? kRadiansPerDegree / kCounts : largest > kFullTurn ? kRadiansPerDegree : 1;
}

/// Columns named heading or yaw, roll and pitch, in degrees where the unit or the readings say so.
std::optional<EulerColumns> euler_by_name(const std::vector<ColumnName>& names, const std::vector<TextLine>& rows) {
  EulerColumns euler;
  int found = 0;
  std::string unit;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i].name;
    const auto is = [&](std::string_view word) { return name.find(word) != std::string::npos; };
    if (is("heading") || name == "euler_h")
      euler.heading = i, euler.clockwise = true, found |= 1;
    else if (is("yaw"))
      euler.heading = i, found |= 1;
    else if (is("roll") || name == "euler_r")
      euler.roll = i, found |= 2;
    else if (is("pitch") || name == "euler_p")
      euler.pitch = i, found |= 4;
    else
      continue;
    unit = names[i].unit;
  }
  if (found != 7) return std::nullopt;
  euler.radians = unit_of_angles(unit, euler, rows);
  return euler;
}

/// z, then y, then x, each about the turned axis. The BNO055's roll turns about y and its pitch about x.
Eigen::Quaterniond quaternion_of(const EulerColumns& euler, double heading, double roll, double pitch) {
  const double about_z = (euler.clockwise ? -heading : heading) * euler.radians;
  const double about_y = (euler.clockwise ? roll : pitch) * euler.radians;
  const double about_x = (euler.clockwise ? pitch : roll) * euler.radians;
  return Eigen::AngleAxisd(about_z, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX());
}

void note_euler(const EulerColumns& euler, std::vector<std::string>* notes) {
  add_note(notes, fmt::format("angles in {}: {}, in that order, a guess",
                              euler.radians == 1                   ? "radians"
                              : euler.radians == kRadiansPerDegree ? "degrees"
                                                                   : "sixteenths of a degree, the BNO055's raw counts",
                              euler.clockwise
                                  ? "heading clockwise about z, roll about y, pitch about x, as the BNO055 gives them"
                                  : "yaw about z, pitch about y, roll about x"));
}

bool is_nanoseconds(std::string_view stamp) {
  constexpr std::size_t kDigits = 11;  // whole seconds of 317 years
  return stamp.size() >= kDigits && parse_unsigned(stamp).has_value();
}

/// 2^14 for the BNO055's raw quaternions, else 1, by the first line.
double counts_of(const std::vector<TextLine>& rows, const Columns& columns) {
  constexpr double kCounts = 16384;
  const auto fields = split_fields(rows.front().text, true);
  double sum = 0;
  for (const std::size_t column : columns.quaternion) {
    const double value = column < fields.size() ? parse_double(fields[column]).value_or(0) : 0;
    sum += value * value;
  }
  return std::abs(std::sqrt(sum) / kCounts - 1) < kUnitTolerance ? kCounts : 1;
}

OrientationLayout find_layout(const TextFile& file, const Table& table) {
  const std::vector<TextLine>& lines = table.rows;
  OrientationLayout layout;
  layout.fields = split_fields(lines.front().text, true).size();
  layout.nanoseconds =
      table.head.find("[ns]") != std::string_view::npos ||
      std::any_of(lines.begin(), lines.end(), [](const TextLine& line) { return is_nanoseconds(first_field(line)); });
  const std::vector<ColumnName> names = column_names(table.head);
  std::optional<Columns> columns;
  if (names.size() == layout.fields) columns = columns_by_name(names);
  if (!columns && names.size() == layout.fields) layout.euler = euler_by_name(names, lines);
  if (layout.euler) return layout;
  if (!columns && table.has_heading)
    throw Error(fmt::format("has no orientation among the columns {}", list(names)), file.path(),
                kOrientationFileAdvice);
  if (!columns) columns = columns_by_number(layout.fields, layout.nanoseconds);
  if (!columns)
    file.fail(lines.front(), fmt::format("has {} fields, where an orientation has 5 or 8", layout.fields),
              kOrientationFileAdvice);
  layout.columns = *columns;
  layout.counts = counts_of(lines, layout.columns);
  return layout;
}

Nanoseconds parse_stamp(const TextFile& file, const TextLine& line, std::string_view text, bool nanoseconds) {
  if (!nanoseconds) return stamp_of(file, line, text, kOrientationFileAdvice);
  const auto time = parse_unsigned(text);
  if (!time) file.fail(line, fmt::format("'{}' is not a time in whole nanoseconds", text), kOrientationFileAdvice);
  return *time;
}

/// A line as it stands there; the numbers need not be those of a rotation.
std::pair<Nanoseconds, Eigen::Vector4d> parse_line(const TextFile& file, const TextLine& line,
                                                   const std::vector<std::string_view>& fields,
                                                   const OrientationLayout& layout) {
  if (fields.size() != layout.fields)
    file.fail(line, fmt::format("has {} fields where the lines before have {}", fields.size(), layout.fields),
              kOrientationFileAdvice);
  if (layout.euler) {
    std::array<double, 3> angles{};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string_view field = fields[i == 0   ? layout.euler->heading
                                            : i == 1 ? layout.euler->roll
                                                     : layout.euler->pitch];
      const auto value = parse_double(field);
      if (!value || !std::isfinite(*value))
        file.fail(line, fmt::format("'{}' is not a finite number", field), kOrientationFileAdvice);
      angles[i] = *value;
    }
    return {parse_stamp(file, line, fields.front(), layout.nanoseconds),
            quaternion_of(*layout.euler, angles[0], angles[1], angles[2]).coeffs()};
  }
  Eigen::Vector4d numbers;
  for (int i = 0; i < 4; ++i) {
    const std::string_view field = fields[layout.columns.quaternion[static_cast<std::size_t>(i)]];
    const auto value = parse_double(field);
    if (!value) file.fail(line, fmt::format("'{}' is not a number", field), kOrientationFileAdvice);
    numbers[i] = *value / layout.counts;
  }
  return {parse_stamp(file, line, fields.front(), layout.nanoseconds), numbers};
}

bool is_unit(const Eigen::Vector4d& quaternion) { return std::abs(quaternion.norm() - 1) <= kUnitTolerance; }

/// Counts what was left out, to be told once.
struct NotUnit {
  int count = 0, first_line = 0;

  void add(const TextLine& line) {
    if (count++ == 0) first_line = line.number;
  }
  void tell(const std::string& path, std::size_t good, std::vector<std::string>* notes) const {
    if (count == 0) return;
    const std::string what = fmt::format("{} of {} orientations are no unit quaternions (the first in line {})", count,
                                         good + static_cast<std::size_t>(count), first_line);
    if (static_cast<std::size_t>(count) > good) throw Error(what, path, kOrientationFileAdvice);
    add_note(notes, what + " and were left out");
  }
};

}  // namespace

std::vector<OrientationSample> read_orientations(const std::string& path, const OrientationConvention& declared,
                                                 std::vector<std::string>* notes, OrientationConvention* used) {
  const TextFile file(path);
  const Table table = read_table(file);
  const std::vector<TextLine>& lines = table.rows;
  if (lines.empty()) throw Error("has no orientations", path, kOrientationFileAdvice);

  const OrientationLayout layout = find_layout(file, table);
  if (layout.euler) note_euler(*layout.euler, notes);
  if (layout.counts != 1) add_note(notes, "the quaternions are raw counts of 1/16384, as the BNO055's are");
  OrientationConvention convention = declared;
  convention.quaternion = layout.euler ? QuaternionOrder::xyzw : declared.quaternion.value_or(layout.columns.order);
  convention.has_heading = declared.has_heading && table.head.find(kTiltOnly) == std::string_view::npos;
  if (used != nullptr) *used = convention;

  std::vector<OrientationSample> samples;
  samples.reserve(lines.size());
  NotUnit not_unit;
  for (const TextLine& line : lines) {
    const std::vector<std::string_view> fields = split_fields(line.text, true);
    const bool half_written = is_half_written(line, fields.size() < layout.fields);
    try {
      const auto [time, numbers] = parse_line(file, line, fields, layout);
      if (is_unit(numbers)) {
        samples.push_back({time, decode_orientation(numbers, convention)});
      } else if (half_written) {
        note_half_written(notes, line);
      } else {
        not_unit.add(line);
      }
    } catch (const Error&) {
      if (!half_written) throw;
      note_half_written(notes, line);
    }
  }
  not_unit.tell(path, samples.size(), notes);
  if (samples.empty()) throw Error("has no orientations", path, kOrientationFileAdvice);
  sort_and_thin(&samples, "orientations", notes);
  return samples;
}

void write_orientations(const std::string& path, const std::vector<OrientationSample>& samples, bool has_heading) {
  std::string text = "# earth_from_body, earth axes east north up\n# timestamp qx qy qz qw";
  if (!has_heading) text += fmt::format(" ({}: the heading means nothing)", kTiltOnly);
  text += '\n';
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  for (const OrientationSample& s : samples) {
    Eigen::Quaterniond q(s.earth_from_body);
    if (q.dot(before) < 0) q.coeffs() = -q.coeffs();  // the signs of one rotation's two quaternions follow one another
    before = q;
    text += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f}\n", format_seconds(s.time, 9), q.x(), q.y(), q.z(), q.w());
  }
  write_file(path, text);
}

}  // namespace plumbline
