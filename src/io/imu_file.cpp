#include "io/imu_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/orientation.h"
#include "io/named_columns.h"
#include "io/text_file.h"

namespace plumbline {
namespace {

constexpr const char* kAdvice =
    "write each reading as: t,gyro_x,gyro_y,gyro_z,accelerometer_x,accelerometer_y,accelerometer_z and, if there is "
    "one, magnetometer_x,magnetometer_y,magnetometer_z, under a heading with these names";
constexpr double kStandardGravity = 9.80665;  // m/s²

enum Channel { kGyroscope, kAccelerometer, kMagnetometer, kChannels };

/// Where the parts of a reading stand, and what makes them SI.
struct Layout {
  std::size_t fields = 0;
  bool nanoseconds = false;
  std::array<std::optional<std::array<std::size_t, 3>>, kChannels> columns;
  std::array<double, kChannels> unit = {1, 1, 1};
  std::optional<std::array<std::size_t, 4>> quaternion;  ///< of a reference, w x y z
  std::optional<std::size_t> movement;
};

/// One name a column, "gyr[rad/s] xyz" standing for three, "quaternion w x y z" for four.
std::vector<std::string> expanded_names(std::string_view head) {
  std::vector<std::string> names;
  for (const std::string_view text : split_heading(head)) {
    const std::string name = lower(text);
    const auto put = [&](std::string_view suffix, std::string_view letters) {
      const std::size_t at = name.find(suffix);
      if (at == std::string::npos) return false;
      for (const char letter : letters) names.push_back(std::string(trim(name.substr(0, at))) + '_' + letter);
      return true;
    };
    if (!put(" w x y z", "wxyz") && !put(" xyz", "xyz")) names.push_back(name);
  }
  return names;
}

/// The name without its unit, and without the component in `component`.
std::string stem_of(std::string name, char* component) {
  std::string plain;
  int depth = 0;
  for (const char c : name) {
    if (c == '[' || c == '(') ++depth;
    if (depth == 0 && c != ' ' && c != '"') plain += c;
    if (c == ']' || c == ')') --depth;
  }
  *component = plain.empty() ? '\0' : plain.back();
  if (*component < 'w' || *component > 'z') *component = '\0';
  if (*component != '\0') plain.pop_back();
  while (!plain.empty() && (plain.back() == '_' || plain.back() == '.' || plain.back() == '/')) plain.pop_back();
  return plain;
}

std::optional<Channel> channel_of(const std::string& stem) {
  const auto is_one_of = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), stem) != names.end();
  };
  if (is_one_of({"g", "w", "gyr", "gyro", "gyroscope", "omega", "w_rs_s", "angular_velocity", "angular_rate"}))
    return kGyroscope;
  if (is_one_of({"a", "acc", "accel", "accelerometer", "a_rs_s", "linear_acceleration", "specific_force"}))
    return kAccelerometer;
  if (is_one_of({"m", "mag", "magnetometer", "magnetic_field"})) return kMagnetometer;
  return std::nullopt;
}

double unit_of(Channel channel, const std::string& name) {
  if (channel == kGyroscope && name.find("deg") != std::string::npos) return std::numbers::pi / 180;
  if (channel == kAccelerometer && name.find("[g]") != std::string::npos) return kStandardGravity;
  return 1;
}

/// The names belong to the last columns: a comment may say more before them. Too few tell nothing.
void layout_by_names(std::vector<std::string> names, Layout* layout) {
  if (names.size() < layout->fields) return;
  names.erase(names.begin(), names.end() - static_cast<std::ptrdiff_t>(layout->fields));
  for (std::size_t i = 0; i < names.size(); ++i) {
    char component = '\0';
    const std::string stem = stem_of(names[i], &component);
    if (names[i].starts_with("movement")) layout->movement = i;
    if (stem.ends_with("quaternion") && component == 'w' && i + 3 < names.size())
      layout->quaternion = {i, i + 1, i + 2, i + 3};
    const std::optional<Channel> channel = channel_of(stem);
    if (!channel || component != 'x' || i + 2 >= names.size()) continue;
    char second = '\0', third = '\0';
    if (stem_of(names[i + 1], &second) != stem || stem_of(names[i + 2], &third) != stem || second != 'y' ||
        third != 'z')
      continue;
    layout->columns[*channel] = {i, i + 1, i + 2};
    layout->unit[*channel] = unit_of(*channel, names[i]);
  }
}

void layout_by_number(Layout* layout) {
  std::vector<Channel> channels;
  if (layout->fields == 4) channels = {kAccelerometer};
  if (layout->fields == 7) channels = {kGyroscope, kAccelerometer};
  if (layout->fields == 10) channels = {kGyroscope, kAccelerometer, kMagnetometer};
  std::size_t at = 1;
  for (const Channel channel : channels) {
    layout->columns[channel] = {at, at + 1, at + 2};
    at += 3;
  }
}

/// The lines without a heading, and the heading's text or the comment in its place.
std::string_view take_heading(const TextFile& file, std::vector<TextLine>* lines) {
  if (lines->empty() || !is_heading(lines->front())) return file.head();
  const std::string_view head = lines->front().text;
  lines->erase(lines->begin());
  return head;
}

Layout find_layout(const TextFile& file, std::string_view head, const std::vector<TextLine>& lines) {
  Layout layout;
  layout.fields = split_fields(lines.front().text, true).size();
  layout.nanoseconds = has_nanoseconds(head, lines);
  layout_by_names(expanded_names(head), &layout);
  if (!layout.columns[kAccelerometer] && !layout.columns[kGyroscope]) layout_by_number(&layout);
  if (!layout.columns[kAccelerometer])
    file.fail(lines.front(),
              fmt::format("has {} fields and no name that says which are the acceleration", layout.fields), kAdvice);
  return layout;
}

double number(const TextFile& file, const TextLine& line, std::string_view field) {
  const auto value = parse_double(field);
  if (!value) file.fail(line, fmt::format("'{}' is not a number", field), kAdvice);
  return *value;
}

/// One line taken apart.
class LineReader {
 public:
  LineReader(const TextFile& file, const Layout& layout) : file_(file), layout_(layout) {}

  ImuReading reading(const TextLine& line, const std::vector<std::string_view>& fields) const {
    if (fields.size() != layout_.fields)
      file_.fail(line, fmt::format("has {} fields where the lines before have {}", fields.size(), layout_.fields),
                 kAdvice);
    ImuReading reading;
    reading.time = parse_stamp(file_, line, fields.front(), layout_.nanoseconds, kAdvice);
    Eigen::Vector3d* const parts[] = {&reading.angular_rate, &reading.specific_force, &reading.magnetic_field};
    for (int channel = 0; channel < kChannels; ++channel)
      if (const auto& columns = layout_.columns[static_cast<std::size_t>(channel)])
        for (int axis = 0; axis < 3; ++axis)
          (*parts[channel])[axis] = layout_.unit[static_cast<std::size_t>(channel)] *
                                    number(file_, line, fields[(*columns)[static_cast<std::size_t>(axis)]]);
    return reading;
  }

  /// The optical orientation, where the line has one that counts.
  std::optional<OrientationSample> reference(const TextLine& line, const std::vector<std::string_view>& fields,
                                             Nanoseconds time) const {
    if (!layout_.quaternion) return std::nullopt;
    if (layout_.movement && number(file_, line, fields[*layout_.movement]) == 0) return std::nullopt;
    Eigen::Vector4d q;
    for (int i = 0; i < 4; ++i) q[i] = number(file_, line, fields[(*layout_.quaternion)[static_cast<std::size_t>(i)]]);
    if (!(std::abs(q.norm() - 1) <= kUnitTolerance)) return std::nullopt;  // the markers were hidden
    OrientationConvention convention;
    convention.quaternion = QuaternionOrder::wxyz;
    return OrientationSample{time, decode_orientation(q, convention)};
  }

 private:
  const TextFile& file_;
  const Layout& layout_;
};

/// What every use of a reading needs.
bool is_complete(const ImuReading& reading, const Layout& layout) {
  return reading.specific_force.allFinite() && (!layout.columns[kGyroscope] || reading.angular_rate.allFinite());
}

void read_lines(const TextFile& file, const std::vector<TextLine>& lines, const Layout& layout, ImuRecording* recording,
                std::vector<std::string>* notes) {
  const LineReader reader(file, layout);
  int incomplete = 0;
  for (const TextLine& line : lines) {
    const std::vector<std::string_view> fields = split_fields(line.text, true);
    try {
      const ImuReading reading = reader.reading(line, fields);
      if (is_complete(reading, layout))
        recording->readings.push_back(reading);
      else
        ++incomplete;
      if (const auto sample = reader.reference(line, fields, reading.time)) recording->reference.push_back(*sample);
    } catch (const Error&) {
      if (!is_half_written(line, fields.size() < layout.fields)) throw;
      note_half_written(notes, line);
    }
  }
  if (incomplete > 0) add_note(notes, fmt::format("{} readings are not finite and were left out", incomplete));
}

}  // namespace

ImuRecording read_imu(const std::string& path, std::vector<std::string>* notes) {
  const TextFile file(path);
  std::vector<TextLine> lines = file.lines();
  const std::string_view head = take_heading(file, &lines);
  if (lines.empty()) throw Error("has no readings", path, kAdvice);
  const Layout layout = find_layout(file, head, lines);
  ImuRecording recording;
  recording.has_gyroscope = layout.columns[kGyroscope].has_value();
  recording.has_magnetometer = layout.columns[kMagnetometer].has_value();
  // TUM's files call the Kinect's chip so.
  recording.kinect_axes = layout.fields == 4 && head == "timestamp ax ay az";
  read_lines(file, lines, layout, &recording, notes);
  if (recording.readings.empty()) throw Error("has no readings", path, kAdvice);
  sort_and_thin(&recording.readings, "readings", notes);
  sort_and_thin(&recording.reference, "reference orientations", notes);
  return recording;
}

bool is_imu_file(const std::string& path) {
  const TextFile file(path);
  std::vector<TextLine> lines = file.lines();
  const std::string_view head = take_heading(file, &lines);
  if (lines.empty()) return false;
  Layout layout;
  layout.fields = split_fields(lines.front().text, true).size();
  layout_by_names(expanded_names(head), &layout);
  return layout.columns[kAccelerometer].has_value();
}

}  // namespace plumbline
