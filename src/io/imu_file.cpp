#include "io/imu_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>

#include "io/atomic_file.h"
#include "io/camera.h"
#include "io/columns.h"
#include "io/imu/alternating_rows.h"
#include "io/imu/imu_columns.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

constexpr const char* kImuFileAdvice =
    "write each sample as: timestamp,gyro_x,gyro_y,gyro_z,accelerometer_x,accelerometer_y,accelerometer_z (seconds, "
    "rad/s, m/s^2; other units in square brackets after the name)";

/// Where in a line the readings stand, and by what to multiply them for rad/s, m/s² and µT.
struct ImuColumns {
  std::size_t fields = 0, stamp = 0;
  std::string stamp_unit;  ///< empty: to be found out
  int stamp_decimals = 0;  ///< digits by which the stamps' point must move left for seconds
  struct Triple {
    std::array<std::size_t, 3> column{};
    double factor = 1;
  };
  std::array<std::optional<Triple>, kSensors> sensors;
  std::array<bool, kSensors> unit_known{};  ///< the heading tells it
  bool named = false;                       ///< the sensors are told by the heading
  bool stray_scanner = false;               ///< its heading: the accelerometer has the sign of the acceleration
  std::optional<std::size_t> reference;     ///< a quaternion w x y z of an optical system, and whether it counts
};

struct Unit {
  std::string_view name;
  double factor;
};
constexpr double kGravity = 9.80665;
constexpr std::array kUnits = {
    std::array<Unit, 8>{Unit{"rad/s", 1},
                        {"rads-1", 1},
                        {"rads", 1},
                        {"deg/s", kRadiansPerDegree},
                        {"degs-1", kRadiansPerDegree},
                        {"°/s", kRadiansPerDegree},
                        {"dps", kRadiansPerDegree},
                        {"degs", kRadiansPerDegree}},
    std::array<Unit, 8>{Unit{"m/s2", 1},
                        {"ms-2", 1},
                        {"m/s²", 1},
                        {"mps2", 1},
                        {"ms2", 1},
                        {"g", kGravity},
                        {"mg", kGravity * 1e-3},
                        {"g0", kGravity}},
    std::array<Unit, 8>{
        Unit{"ut", 1}, {"µt", 1}, {"mt", 1e3}, {"t", 1e6}, {"g", 100}, {"gauss", 100}, {"nt", 1e-3}, {"μt", 1}}};
constexpr std::array<std::string_view, kSensors> kSensorNames = {"gyroscope", "accelerometer", "magnetometer"};

double unit_factor(ImuSensor sensor, std::string unit, const TextFile& file) {
  std::erase_if(unit, [](char c) { return c == ' ' || c == '^' || c == '*'; });
  if (unit.empty()) return 1;
  for (const Unit& known : kUnits[sensor])
    if (unit == known.name) return known.factor;
  throw Error(fmt::format("the unit [{}] of the {} is not known", unit, kSensorNames[sensor]), file.path(),
              "give rad/s or deg/s, m/s^2 or g, uT or G");
}

/// "time_ms" and "timestamp_ns" tell the unit of the stamps.
std::string stamp_unit(const ColumnName& column) {
  if (!column.unit.empty()) return column.unit;
  for (const std::string_view unit : {"ms", "us", "ns", "sec"})
    if (column.name.ends_with(unit) && column.name.size() > unit.size() &&
        column.name[column.name.size() - unit.size() - 1] == '_')
      return std::string(unit);
  return "";
}

/// Fills in what the names tell. Whether any name was one of a sensor.
bool columns_by_name(std::vector<ColumnName> names, const TextFile& file, ImuColumns* layout) {
  std::transform(names.begin(), names.end(), names.begin(), with_unit_apart);
  std::array<std::array<int, 3>, kSensors> at;
  for (auto& axes : at) axes.fill(-1);
  bool any = false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].name.ends_with("header.stamp")) layout->stamp = i;
    const auto component = component_of(names[i].name);
    if (!component) continue;
    any = true;
    int& index = at[component->first][static_cast<std::size_t>(component->second)];
    if (index < 0) index = static_cast<int>(i);
  }
  for (const ImuSensor sensor : {kGyroscope, kAccelerometer, kMagnetometer}) {
    const auto& axes = at[sensor];
    if (std::count(axes.begin(), axes.end(), -1) > 0) continue;
    ImuColumns::Triple triple;
    for (std::size_t i = 0; i < 3; ++i) triple.column[i] = static_cast<std::size_t>(axes[i]);
    triple.factor = unit_factor(sensor, names[triple.column[0]].unit, file);
    layout->unit_known[sensor] = !names[triple.column[0]].unit.empty();
    if (sensor == kGyroscope) layout->stray_scanner = names[triple.column[0]].name.starts_with("alpha");
    layout->sensors[sensor] = triple;
  }
  layout->stamp_unit = stamp_unit(names[layout->stamp]);
  layout->named = any;
  return any;
}

ImuColumns::Triple three_from(std::size_t first) { return {{first, first + 1, first + 2}, 1}; }

/// False if no known form has so many fields.
bool columns_by_number(ImuColumns* layout) {
  auto& sensors = layout->sensors;
  if (layout->fields == 4) {
    sensors[kAccelerometer] = three_from(1);
    return true;
  }
  if (layout->fields != 7 && layout->fields != 10 && layout->fields != 15) return false;
  sensors[kGyroscope] = three_from(1);
  sensors[kAccelerometer] = three_from(4);
  if (layout->fields > 7) sensors[kMagnetometer] = three_from(7);
  return true;
}

/// Digits by which the point of a stamp must move for seconds, by the unit's name.
int stamp_decimals(const std::string& unit, const TextFile& file) {
  for (const auto& [name, decimals] : {std::pair("s", 0), {"sec", 0}, {"ms", 3}, {"us", 6}, {"µs", 6}, {"ns", 9}})
    if (unit == name) return decimals;
  throw Error(fmt::format("the unit [{}] of the stamps is not known", unit), file.path(), "give s, ms, us or ns");
}

/// The same by the interval between the stamps, given that a sensor has 10 to 10000 readings a second: in each unit
/// the intervals then lie in decades of their own.
int guess_stamp_decimals(const std::vector<TextLine>& rows, std::size_t column) {
  std::vector<double> intervals;
  std::optional<double> before;
  for (const TextLine& row : rows) {
    const auto fields = table_fields(row.text);
    const auto stamp = column < fields.size() ? parse_double(fields[column]) : std::nullopt;
    if (stamp && before && *stamp > *before) intervals.push_back(*stamp - *before);
    before = stamp;
  }
  if (intervals.empty()) return parse_double(first_field(rows.front())).value_or(0) > 1e15 ? 9 : 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  constexpr double kMaxInterval = 0.1;  // s
  for (const int decimals : {0, 3, 6})
    if (*middle <= kMaxInterval * std::pow(10, decimals)) return decimals;
  return 9;
}

bool is_broad(const Table& table, const ImuColumns& layout) {
  return table.head.starts_with("BROAD") && layout.fields == 15;
}

/// What the readings of three columns look like, in the file's own unit.
struct Look {
  double median = 0, high = 0, spread = 0;  ///< of the norms: median, 95th percentile, mean deviation from the median
  bool around(double value) const { return median > 0.75 * value && median < 1.25 * value && spread < 0.3 * median; }
  /// As nothing that feels gravity does.
  bool is_moving() const { return spread > 0.3 * median && high > 0; }
  /// Gravity in a unit that is in use: m/s², g, mg, or counts of a 16-bit chip.
  double gravity_unit() const {
    for (const double per_g : {kGravity, 1.0, 1000.0, 16384.0, 8192.0, 4096.0, 2048.0})
      if (around(per_g)) return per_g;
    return 0;
  }
};

Look look_of(std::vector<double> norms) {
  Look look;
  if (norms.empty()) return look;
  std::sort(norms.begin(), norms.end());
  look.median = norms[norms.size() / 2];
  look.high = norms[norms.size() * 95 / 100];
  for (const double norm : norms) look.spread += std::abs(norm - look.median) / static_cast<double>(norms.size());
  return look;
}

Look look_at(const std::vector<TextLine>& rows, const ImuColumns::Triple& triple) {
  constexpr std::size_t kRows = 5000;
  std::vector<double> norms;
  const std::size_t step = rows.size() / kRows + 1;
  for (std::size_t i = 0; i < rows.size(); i += step) {
    const auto fields = table_fields(rows[i].text);
    double sum = 0;
    for (const std::size_t column : triple.column) {
      const auto value = column < fields.size() ? parse_double(fields[column]) : std::nullopt;
      sum += value ? *value * *value : std::nan("");
    }
    if (std::isfinite(sum)) norms.push_back(std::sqrt(sum));
  }
  return look_of(std::move(norms));
}

/// Three columns without a name: an accelerometer's, or a gyroscope's where they cannot be gravity.
void choose_sensor(const std::vector<TextLine>& rows, ImuColumns* layout, std::vector<std::string>* notes) {
  const Look look = look_at(rows, *layout->sensors[kAccelerometer]);
  const double median = look.median;
  const bool gravity = look.gravity_unit() > 0 || (median >= 0.5 * kGravity && median <= 1.5 * kGravity);
  if (gravity || !look.is_moving()) return;
  std::swap(layout->sensors[kGyroscope], layout->sensors[kAccelerometer]);
  add_note(notes,
           fmt::format("three columns without names, which read {:.3g} in the median and vary too much for gravity: "
                       "taken for a gyroscope, a guess",
                       median));
}

ImuColumns find_layout(const TextFile& file, const Table& table, std::vector<std::string>* notes) {
  ImuColumns layout;
  layout.fields = table_fields(table.rows.front().text).size();
  const std::vector<ColumnName> names = named_by_file(column_names(table.head), file.path());
  const bool broad = is_broad(table, layout);
  if (broad) layout.reference = 10;
  const bool named = !broad && names.size() == layout.fields && columns_by_name(names, file, &layout);
  if (named && !layout.sensors[kAccelerometer] && !layout.sensors[kGyroscope])
    throw Error(fmt::format("has neither a gyroscope nor an accelerometer among the columns {}", list(names)),
                file.path(), kImuFileAdvice);
  if (!named && (!columns_by_number(&layout) || (layout.fields == 15 && !broad)))
    file.fail(
        table.rows.front(),
        fmt::format("has {} fields, where a sample has 4, 7 or 10 (stamp, gyroscope, accelerometer, magnetometer)",
                    layout.fields),
        kImuFileAdvice);
  if (!named && layout.fields == 4) choose_sensor(table.rows, &layout, notes);
  if (!named && table.has_heading)
    add_note(notes, fmt::format("the columns ({}) were taken for a stamp{}{}", list(names),
                                layout.sensors[kGyroscope] ? ", the gyroscope" : "",
                                layout.sensors[kAccelerometer] ? ", the accelerometer" : ""));
  layout.stamp_decimals = layout.stamp_unit.empty() ? guess_stamp_decimals(table.rows, layout.stamp)
                                                    : stamp_decimals(layout.stamp_unit, file);
  return layout;
}

/// The text of a number with its point moved to the left.
std::string point_moved(std::string_view number, int decimals) {
  const bool negative = number.starts_with('-');
  if (negative) number.remove_prefix(1);
  const std::size_t point = std::min(number.find('.'), number.size());
  std::string digits(number.substr(0, point));
  const auto wanted = static_cast<std::size_t>(decimals);
  if (digits.size() < wanted) digits.insert(0, wanted - digits.size(), '0');
  digits.insert(digits.size() - wanted, 1, '.');
  if (point < number.size()) digits += number.substr(point + 1);
  return (negative ? "-" : "") + digits;
}

Nanoseconds parse_stamp(const TextFile& file, const TextLine& line, std::string_view text, int decimals) {
  if (decimals == 0) return stamp_of(file, line, text, kImuFileAdvice);
  std::optional<Nanoseconds> time;
  if (text.find_first_not_of("-0123456789.") == std::string_view::npos && !text.empty()) {
    time = parse_seconds(point_moved(text, decimals));
  } else if (const auto value = parse_double(text); value && std::abs(*value * std::pow(10, -decimals)) < 9e9) {
    time = from_seconds(*value * std::pow(10, -decimals));
  }
  if (!time) file.fail(line, fmt::format("'{}' is not a time", text), kImuFileAdvice);
  return *time;
}

Eigen::Vector3d parse_triple(const TextFile& file, const TextLine& line, const std::vector<std::string_view>& fields,
                             const ImuColumns::Triple& triple, bool may_be_empty) {
  Eigen::Vector3d v;
  for (int i = 0; i < 3; ++i) {
    const std::string_view field = fields[triple.column[static_cast<std::size_t>(i)]];
    const auto value = may_be_empty && field.empty() ? std::nan("") : parse_double(field);
    if (!value) file.fail(line, fmt::format("'{}' is not a number", field), kImuFileAdvice);
    v[i] = *value * triple.factor;
  }
  return v;
}

ImuSample parse_sample(const TextFile& file, const TextLine& line, const std::vector<std::string_view>& fields,
                       const ImuColumns& layout) {
  if (fields.size() != layout.fields)
    file.fail(line, fmt::format("has {} fields where the lines before have {}", fields.size(), layout.fields),
              kImuFileAdvice);
  ImuSample sample;
  sample.time = parse_stamp(file, line, fields[layout.stamp], layout.stamp_decimals);
  const auto& sensors = layout.sensors;
  if (sensors[kGyroscope]) sample.angular_rate = parse_triple(file, line, fields, *sensors[kGyroscope], false);
  if (sensors[kAccelerometer])
    sample.specific_force = parse_triple(file, line, fields, *sensors[kAccelerometer], false);
  if (sensors[kMagnetometer]) {
    const Eigen::Vector3d field = parse_triple(file, line, fields, *sensors[kMagnetometer], true);
    if (field.allFinite()) sample.magnetic_field = field;
  }
  return sample;
}

/// The optical orientation of a line, where it is to be evaluated and the markers were seen.
std::optional<OrientationSample> parse_reference(const TextFile& file, const TextLine& line,
                                                 const std::vector<std::string_view>& fields, const ImuColumns& layout,
                                                 Nanoseconds time) {
  if (!layout.reference) return std::nullopt;
  std::array<double, 5> numbers{};  // w x y z, movement
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::string_view field = fields[*layout.reference + i];
    const auto value = parse_double(field);
    if (!value) file.fail(line, fmt::format("'{}' is not a number", field), kImuFileAdvice);
    numbers[i] = *value;
  }
  const Eigen::Vector4d quaternion(numbers[0], numbers[1], numbers[2], numbers[3]);
  if (numbers[4] == 0 || !(std::abs(quaternion.norm() - 1) <= kUnitTolerance)) return std::nullopt;
  return OrientationSample{time, decode_orientation(quaternion, {QuaternionOrder::wxyz})};
}

/// Which three columns are which sensor, where the readings contradict that.
void check_order(const std::vector<TextLine>& rows, ImuColumns* layout, std::vector<std::string>* notes) {
  auto& [gyroscope, accelerometer, magnetometer] = layout->sensors;
  if (!gyroscope || !accelerometer) return;
  const Look rate = look_at(rows, *gyroscope), force = look_at(rows, *accelerometer);
  const bool gravity_in_rate = rate.around(kGravity) || (!layout->named && rate.around(1));
  if (!gravity_in_rate || force.gravity_unit() > 0) return;
  std::swap(gyroscope->column, accelerometer->column);
  if (!layout->named) layout->unit_known = {};
  add_note(notes, fmt::format("{} read {:.3g} in the median, which is gravity: they were taken for the accelerometer, "
                              "and the other three for the gyroscope",
                              layout->named ? "the columns named gyroscope" : "the first three columns", rate.median));
}

void find_force_unit(const TextFile& file, const std::vector<TextLine>& rows, ImuColumns* layout,
                     std::vector<std::string>* notes) {
  ImuColumns::Triple& triple = *layout->sensors[kAccelerometer];
  const Look look = look_at(rows, triple);
  const double per_g = layout->unit_known[kAccelerometer] ? 0 : look.gravity_unit();
  if (layout->stray_scanner) {
    triple.factor = -(look.median < 3 ? kGravity : 1);
    return add_note(notes,
                    fmt::format("StrayScanner's heading: a_x in {} with the sign of the acceleration, alpha_x the "
                                "turn rate in rad/s",
                                look.median < 3 ? "g" : "m/s^2"));
  }
  if (per_g > 0 && per_g != kGravity) {
    triple.factor = kGravity / per_g;
    return add_note(
        notes, fmt::format("the accelerometer reads {:.3g} in the median and names no unit: taken for {}", look.median,
                           per_g == 1      ? "g"
                           : per_g == 1000 ? "mg"
                                           : fmt::format("counts of {:g} a g", per_g)));
  }
  const double median = triple.factor * look.median;
  if (median >= 0.5 * kGravity && median <= 1.5 * kGravity) return;
  if (!layout->named && layout->fields == 4)
    throw Error(
        fmt::format("the three columns read {:.3g} in the median, which is no accelerometer's gravity (9.8 m/s^2 "
                    "or 1 g)",
                    look.median),
        file.path(), kImuFileAdvice);
  add_note(notes, fmt::format("the accelerometer reads {:.3g} m/s^2 in the median, where gravity alone is 9.8: gravity "
                              "seems to be taken out, or the unit is another",
                              median));
}

/// By how much the gyroscope's readings must be scaled so that they turn gravity's direction as the accelerometer sees
/// it turn: over spans of a third of a second, Δf = −s·∫ω × f. Empty where the readings do not tell.
std::optional<double> rate_scale(const std::vector<ImuSample>& samples) {
  constexpr double kSpan = 0.35, kMinCorrelation = 0.7, kMinTurn = 0.05;
  double pp = 0, pd = 0, dd = 0;
  std::size_t begin = 0;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < samples.size(); ++i) {
    turn += samples[i].angular_rate * to_seconds(samples[i].time - samples[i - 1].time);
    if (to_seconds(samples[i].time - samples[begin].time) < kSpan) continue;
    const Eigen::Vector3d before = samples[begin].specific_force.normalized(),
                          after = samples[i].specific_force.normalized();
    const Eigen::Vector3d predicted = -turn.cross(0.5 * (before + after)), seen = after - before;
    if (predicted.allFinite() && seen.allFinite() && seen.norm() < 0.7) {
      pp += predicted.squaredNorm();
      pd += predicted.dot(seen);
      dd += seen.squaredNorm();
    }
    begin = i;
    turn.setZero();
  }
  if (dd < kMinTurn || pp <= 0 || std::abs(pd) < kMinCorrelation * std::sqrt(pp * dd)) return std::nullopt;
  return pd / pp;
}

double fastest_rate(const std::vector<ImuSample>& samples) {
  double fastest = 0;
  for (const ImuSample& sample : samples) fastest = std::max(fastest, sample.angular_rate.cwiseAbs().maxCoeff());
  return fastest;
}

/// A unit of turn rates that is in use, by what one rad/s reads in it.
struct RateUnit {
  double per_radian;
  const char* words;
};
constexpr std::array kRateUnits = {
    RateUnit{1, ""},
    RateUnit{1 / kRadiansPerDegree, "deg/s"},
    RateUnit{16.0 / kRadiansPerDegree, "counts of 16 a deg/s, as of a chip of ±2000 deg/s"},
    RateUnit{32.8 / kRadiansPerDegree, "counts of 32.8 a deg/s, as of a chip of ±1000 deg/s"},
    RateUnit{65.5 / kRadiansPerDegree, "counts of 65.5 a deg/s, as of a chip of ±500 deg/s"},
    RateUnit{131 / kRadiansPerDegree, "counts of 131 a deg/s, as of a chip of ±250 deg/s"}};

/// The unit in which the rates turn gravity as it turns; null if in none.
const RateUnit* unit_by_scale(double scale) {
  for (const RateUnit& unit : kRateUnits) {
    const double ratio = scale * unit.per_radian, wide = unit.per_radian < 100 ? 3 : 1.4;  // counts differ by two
    if (ratio > 1 / wide && ratio < wide) return &unit;
  }
  return nullptr;
}

/// Of readings without a unit: gravity's direction decides where it turns enough, else whether a hand could turn so
/// fast.
void find_rate_unit(std::optional<double> scale, std::vector<ImuSample>* samples, std::vector<std::string>* notes) {
  constexpr double kFast = 10;      // rad/s: 570°/s
  constexpr double kCounts = 3000;  // of any unit, above what a chip can measure
  const double fastest = fastest_rate(*samples);
  const RateUnit* unit = scale ? unit_by_scale(*scale) : nullptr;
  if (unit != nullptr && unit->per_radian != 1) {
    add_note(notes, fmt::format("the gyroscope names no unit; gravity's direction turns as in {}, which was taken",
                                unit->words));
  } else if (unit == nullptr && fastest > kCounts) {
    return add_note(notes,
                    fmt::format("the gyroscope reads up to {:.3g} and names no unit: neither rad/s nor deg/s can "
                                "be; rad/s was taken",
                                fastest));
  } else if (!scale && fastest >= kFast) {
    unit = &kRateUnits[1];
    add_note(notes, fmt::format("the gyroscope reads up to {:.3g} and names no unit: taken for deg/s", fastest));
  } else {
    return;
  }
  for (ImuSample& sample : *samples) sample.angular_rate /= unit->per_radian;
}

/// Readings against each other: what the numbers alone could not tell.
void check_rates(const ImuColumns& layout, std::vector<ImuSample>* samples, std::vector<std::string>* notes) {
  if (!layout.sensors[kGyroscope]) return;
  const auto scale = rate_scale(*samples);
  const bool is_known = layout.unit_known[kGyroscope] || layout.stray_scanner || layout.reference;
  if (!is_known) find_rate_unit(scale, samples, notes);
  const auto found = is_known ? scale : rate_scale(*samples);
  if (!found) return;
  if (*found < 0) {
    add_note(notes,
             "gyroscope and accelerometer contradict each other: gravity's direction turns the other way; the signs "
             "or axes of one of them are wrong");
  } else if (*found < 0.3 || *found > 3) {
    add_note(notes,
             fmt::format("gyroscope and accelerometer contradict each other: gravity's direction turns {:.2g} times "
                         "as fast as the gyroscope says; check its unit",
                         *found));
  }
}

bool names_columns_of(ImuSensor sensor, const std::vector<ColumnName>& names) {
  return std::count_if(names.begin(), names.end(), [&](const ColumnName& column) {
           const auto component = component_of(with_unit_apart(column).name);
           return component && component->first == sensor;
         }) >= 3;
}

}  // namespace

ImuRecording read_imu(const std::string& path, std::vector<std::string>* notes) {
  const TextFile file(path);
  const JoinedRows joined(read_table(file));
  const Table& table = joined.table();
  if (table.rows.empty()) throw Error("has no readings of an inertial sensor", path, kImuFileAdvice);
  if (!joined.note().empty()) add_note(notes, joined.note());
  ImuColumns layout = find_layout(file, table, notes);
  if (!layout.reference) check_order(table.rows, &layout, notes);
  if (layout.sensors[kAccelerometer]) find_force_unit(file, table.rows, &layout, notes);

  ImuRecording recording;
  recording.has_gyroscope = layout.sensors[kGyroscope].has_value();
  recording.has_accelerometer = layout.sensors[kAccelerometer].has_value();
  recording.kinect_axes = layout.fields == 4 && table.head == "timestamp ax ay az";  // so TUM's files call them
  recording.samples.reserve(table.rows.size());
  std::size_t not_finite = 0;
  for (const TextLine& line : table.rows) {
    const std::vector<std::string_view> fields = table_fields(line.text);
    try {
      const ImuSample sample = parse_sample(file, line, fields, layout);
      const bool finite = sample.angular_rate.allFinite() && sample.specific_force.allFinite();
      if (finite) recording.samples.push_back(sample);
      not_finite += finite ? 0 : 1;
      if (const auto reference = parse_reference(file, line, fields, layout, sample.time))
        recording.reference.push_back(*reference);
    } catch (const Error&) {
      if (!is_half_written(line, fields.size() < layout.fields)) throw;
      note_half_written(notes, line);
    }
  }
  const std::string lost = fmt::format("{} of {} samples are not finite", not_finite, table.rows.size());
  if (not_finite > recording.samples.size()) throw Error(lost, path, kImuFileAdvice);
  if (not_finite > 0) add_note(notes, lost + " and were left out");
  if (recording.samples.empty()) throw Error("has no readings of an inertial sensor", path, kImuFileAdvice);
  recording.has_magnetometer = std::any_of(recording.samples.begin(), recording.samples.end(),
                                           [](const ImuSample& s) { return s.magnetic_field.has_value(); });
  sort_and_thin(&recording.samples, "samples", notes);
  sort_and_thin(&recording.reference, "reference orientations", notes);
  check_rates(layout, &recording.samples, notes);
  return recording;
}

bool is_imu_file(const std::string& path) {
  const TextFile file(path);
  const Table table = read_table(file);
  if (table.rows.empty()) return false;
  if (names_sensors_in_rows(table)) return true;
  ImuColumns layout;
  layout.fields = table_fields(table.rows.front().text).size();
  if (is_broad(table, layout)) return true;
  const std::vector<ColumnName> names = named_by_file(column_names(table.head), path);
  if (names.size() != layout.fields) return columns_by_number(&layout) && layout.fields != 15;
  return std::none_of(names.begin(), names.end(),
                      [](const ColumnName& column) { return quaternion_component(column.name) != 0; }) &&
         (names_columns_of(kGyroscope, names) || names_columns_of(kAccelerometer, names));
}

void settle_units(ImuRecording* recording, std::vector<std::string>* notes) {
  std::vector<ImuSample>& samples = recording->samples;
  std::vector<double> forces;
  for (const ImuSample& sample : samples) forces.push_back(sample.specific_force.norm());
  const Look look = look_of(std::move(forces));
  const double per_g = recording->has_accelerometer ? look.gravity_unit() : 0;
  if (per_g > 0 && per_g != kGravity) {
    for (ImuSample& sample : samples) sample.specific_force *= kGravity / per_g;
    add_note(notes,
             fmt::format("the accelerometer reads {:.3g} in the median, where gravity is 9.8 m/s^2: taken for {}",
                         look.median, per_g == 1 ? "g" : fmt::format("counts of {:g} a g", per_g)));
  }
  if (!recording->has_gyroscope || !recording->has_accelerometer) return;
  ImuColumns layout;
  layout.sensors[kGyroscope] = ImuColumns::Triple{};
  check_rates(layout, &samples, notes);
}

std::string find_imu_file(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  for (const char* name : {"imu.csv", "accelerometer.txt"})
    if (fs::is_regular_file(fs::path(folder) / name, error)) return (fs::path(folder) / name).string();
  std::vector<std::string> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = lower(it->path().filename().string());
    const bool is_named =
        contains_word(name, "imu") || name.starts_with("imu") || name.find("gyro") != std::string::npos;
    const fs::path file = it->is_directory(error) ? it->path() / "data.csv" : it->path();
    const std::string extension = lower(file.extension().string());
    if (is_named && (extension == ".csv" || extension == ".txt") && fs::is_regular_file(file, error))
      files.push_back(file.string());
  }
  std::sort(files.begin(), files.end());
  for (const std::string& file : files) try {
      if (is_imu_file(file)) return file;
    } catch (const Error&) {  // some other file
    }
  return {};
}

bool has_gyroscope_columns(const std::string& path) {
  const TextFile file(path);
  const Table table = read_table(file);
  return !table.rows.empty() && names_columns_of(kGyroscope, column_names(table.head));
}

std::optional<Eigen::Matrix3d> mounting_by_format(const std::string& path) {
  const TextFile file(path);
  const std::string_view head = read_table(file).head;
  Eigen::Matrix3d body_from_camera;
  if (head == "timestamp ax ay az") {  // so TUM's files call them
    // x left, y up, z forward: the Kinect's accelerometer against its depth camera.
    body_from_camera = Eigen::Vector3d(-1, -1, 1).asDiagonal();
    return body_from_camera;
  }
  const std::vector<ColumnName> names = column_names(head);
  const bool stray_scanner = std::any_of(names.begin(), names.end(), [](const auto& c) { return c.name == "alpha_x"; });
  if (!stray_scanner) return std::nullopt;
  // A phone's axes: x right and y up as one looks at its screen, held upright; its pictures lie on their side.
  body_from_camera << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  return body_from_camera;
}

void write_imu(const std::string& path, const ImuRecording& recording) {
  AtomicFile file(path);
  std::string head = "timestamp";
  const auto columns = [&](const char* sensor) {
    for (const char axis : {'x', 'y', 'z'}) head += fmt::format(",{}_{}", sensor, axis);
  };
  if (recording.has_gyroscope) columns("gyro");
  if (recording.has_accelerometer) columns("accelerometer");
  if (recording.has_magnetometer) columns("magnetometer");
  file.write(head + "\n");
  std::string row;
  const auto add = [&](const Eigen::Vector3d& v) { row += fmt::format(",{:.9g},{:.9g},{:.9g}", v.x(), v.y(), v.z()); };
  for (const ImuSample& sample : recording.samples) {
    row = format_seconds(sample.time, 9);
    if (recording.has_gyroscope) add(sample.angular_rate);
    if (recording.has_accelerometer) add(sample.specific_force);
    if (recording.has_magnetometer && sample.magnetic_field) add(*sample.magnetic_field);
    if (recording.has_magnetometer && !sample.magnetic_field) row += ",,,";
    file.write(row + "\n");
  }
  file.commit();
}

}  // namespace plumbline
