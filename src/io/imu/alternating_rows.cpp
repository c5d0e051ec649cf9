#include "io/imu/alternating_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include "io/camera.h"
#include "io/imu/imu_columns.h"
#include "io/text_file.h"

namespace plumbline {
namespace {

using Cells = std::vector<std::string_view>;

/// Three readings of one sensor.
struct Row {
  const TextLine* line = nullptr;
  std::string_view stamp;
  std::array<std::string_view, 3> values{};
  double time = 0;
};

/// Of a word such as "gyro", "ACC" or "android.sensor.gyroscope".
std::optional<ImuSensor> sensor_by_word(std::string_view text) {
  const std::string word = lower(text);
  if (word.empty() || parse_double(word)) return std::nullopt;
  if (word.find("uncal") != std::string::npos || word.find("linear") != std::string::npos) return std::nullopt;
  if (word.find("gyr") != std::string::npos) return kGyroscope;
  if (word.find("acc") != std::string::npos) return kAccelerometer;
  if (word.find("mag") != std::string::npos) return kMagnetometer;
  return std::nullopt;
}

std::optional<ImuSensor> sensor_by_number(std::string_view text) {
  if (text == "1") return kAccelerometer;
  if (text == "2") return kMagnetometer;
  if (text == "4") return kGyroscope;
  return std::nullopt;
}

/// The column that names a row's sensor, and how.
struct NameColumn {
  std::size_t column = 0;
  std::optional<ImuSensor> (*sensor)(std::string_view text) = nullptr;
};

std::optional<NameColumn> name_column(const Table& table) {
  constexpr std::size_t kFields = 5;  // stamp, name, three readings
  if (table.rows.empty()) return std::nullopt;
  const Cells first = table_fields(table.rows.front().text);
  if (first.size() < kFields) return std::nullopt;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (sensor_by_word(first[i])) return NameColumn{i, sensor_by_word};
  const std::vector<ColumnName> names = column_names(table.head);
  if (names.size() != first.size()) return std::nullopt;
  for (std::size_t i = 0; i < first.size(); ++i)
    for (const std::string_view known : {"sensor", "type", "sensor_type", "sensortype", "sensor_id"})
      if (names[i].name == known && sensor_by_number(first[i])) return NameColumn{i, sensor_by_number};
  return std::nullopt;
}

/// The fields of a line in their order, without the name: the stamp and three readings. Empty for other lines.
std::optional<Row> named_row(const TextLine& line, const Cells& fields, std::size_t name) {
  std::array<std::string_view, 4> rest{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < fields.size() && count < rest.size(); ++i)
    if (i != name) rest[count++] = fields[i];
  const auto time = parse_double(rest[0]);
  if (count < rest.size() || !time) return std::nullopt;
  return Row{&line, rest[0], {rest[1], rest[2], rest[3]}, *time};
}

/// The readings of `rows`, by time, at a moment between two of them, as text; empty beyond them and where they are no
/// numbers.
std::string between(const std::vector<Row>& rows, double time) {
  const auto after =
      std::lower_bound(rows.begin(), rows.end(), time, [](const Row& row, double t) { return row.time < t; });
  if (after == rows.end() || (after == rows.begin() && after->time > time)) return "";
  const Row &b = *after, &a = after->time == time ? b : *(after - 1);
  const double part = b.time > a.time ? (time - a.time) / (b.time - a.time) : 0;
  std::string text;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto x = parse_double(a.values[i]), y = parse_double(b.values[i]);
    if (!x || !y) return "";
    text += fmt::format(",{:.12g}", *x + part * (*y - *x));
  }
  return text;
}

void sort_by_time(std::vector<Row>* rows) {
  std::stable_sort(rows->begin(), rows->end(), [](const Row& a, const Row& b) { return a.time < b.time; });
}

/// The columns of one sensor's x, y and z by a heading.
std::optional<std::array<std::size_t, 3>> columns_of(const std::vector<ColumnName>& names, ImuSensor sensor) {
  std::array<std::size_t, 3> columns{};
  int found = 0;
  for (std::size_t i = names.size(); i-- > 0;) {
    const auto component = component_of(with_unit_apart(names[i]).name);
    if (!component || component->first != sensor) continue;
    columns[static_cast<std::size_t>(component->second)] = i;
    found |= 1 << component->second;
  }
  return found == 7 ? std::optional(columns) : std::nullopt;
}

bool all_empty(const Cells& fields, const std::array<std::size_t, 3>& columns) {
  return std::all_of(columns.begin(), columns.end(), [&](std::size_t column) { return fields[column].empty(); });
}

}  // namespace

bool names_sensors_in_rows(const Table& table) { return name_column(table).has_value(); }

JoinedRows::JoinedRows(Table table) : table_(std::move(table)) {
  if (names_sensors_in_rows(table_))
    join_named();
  else
    join_empty_cells();
  for (std::size_t i = 0; i < text_.size(); ++i) table_.rows[i].text = text_[i];
  if (!head_.empty()) table_.head = head_;
}

void JoinedRows::join_named() {
  const NameColumn name = *name_column(table_);
  const std::vector<TextLine> lines = table_.rows;
  std::array<std::vector<Row>, kSensors> rows;
  std::size_t other = 0;
  for (const TextLine& line : lines) {
    const Cells fields = table_fields(line.text);
    const auto sensor = name.column < fields.size() ? name.sensor(fields[name.column]) : std::nullopt;
    const auto row = sensor ? named_row(line, fields, name.column) : std::nullopt;
    if (row)
      rows[*sensor].push_back(*row);
    else
      ++other;
  }
  for (std::vector<Row>& of_sensor : rows) sort_by_time(&of_sensor);
  const bool turns = !rows[kGyroscope].empty(), forces = !rows[kAccelerometer].empty();
  table_.rows.clear();
  for (const Row& row : turns ? rows[kGyroscope] : rows[kAccelerometer]) {
    const std::string force = turns && forces ? between(rows[kAccelerometer], row.time) : "";
    if (turns && forces && force.empty()) continue;
    table_.rows.push_back(*row.line);
    text_.push_back(fmt::format("{},{}{}", row.stamp, fmt::join(row.values, ","), force));
  }
  const std::vector<ColumnName> names = column_names(table_.head);
  const std::size_t stamp = name.column == 0 ? 1 : 0;
  head_ = table_.has_heading && names.size() > stamp ? names[stamp].name : "timestamp";
  if (head_ != "timestamp" && !names[stamp].unit.empty()) head_ += "[" + names[stamp].unit + "]";
  if (turns) head_ += ",gyro_x,gyro_y,gyro_z";
  if (forces) head_ += ",acc_x,acc_y,acc_z";
  table_.has_heading = true;
  note_ =
      fmt::format("each row is of one sensor, by its name: {} of the gyroscope and {} of the accelerometer were joined",
                  rows[kGyroscope].size(), rows[kAccelerometer].size());
  if (name.sensor == sensor_by_number) note_ += "; the sensors' numbers are Android's (1 accelerometer, 4 gyroscope)";
  if (other + rows[kMagnetometer].size() > 0)
    note_ += fmt::format("; {} rows of other sensors are not used", other + rows[kMagnetometer].size());
}

void JoinedRows::join_empty_cells() {
  const std::vector<ColumnName> names = column_names(table_.head);
  const auto turn = columns_of(names, kGyroscope), force = columns_of(names, kAccelerometer);
  if (!turn || !force) return;
  std::vector<Row> turns, forces;
  std::size_t alone = 0;
  const std::vector<TextLine> lines = table_.rows;
  for (const TextLine& line : lines) {
    const Cells fields = table_fields(line.text);
    const auto time = fields.size() == names.size() ? parse_double(fields[0]) : std::nullopt;
    if (!time) return;  // the reader of the rows says what is wrong
    const bool turns_here = !all_empty(fields, *turn), forces_here = !all_empty(fields, *force);
    const auto row = [&](const std::array<std::size_t, 3>& c) {
      return Row{&line, fields[0], {fields[c[0]], fields[c[1]], fields[c[2]]}, *time};
    };
    if (turns_here) turns.push_back(row(*turn));
    if (forces_here) forces.push_back(row(*force));
    alone += turns_here != forces_here ? 1 : 0;
  }
  if (alone == 0 || turns.empty() || forces.empty()) return;
  sort_by_time(&forces);
  table_.rows.clear();
  for (const Row& row : turns) {
    const std::string at = between(forces, row.time);
    if (at.empty()) continue;
    Cells fields = table_fields(row.line->text);
    const Cells readings = table_fields(at);  // the first is empty
    for (std::size_t i = 0; i < 3; ++i) fields[(*force)[i]] = readings[i + 1];
    table_.rows.push_back(*row.line);
    text_.push_back(fmt::format("{}", fmt::join(fields, ",")));
  }
  note_ = fmt::format(
      "gyroscope and accelerometer stand in rows apart, with empty cells for the other: {} and {} rows "
      "were joined",
      turns.size(), forces.size());
}

}  // namespace plumbline
