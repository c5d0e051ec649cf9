#include "plumbline/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <sstream>
#include <type_traits>
#include <utility>

#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr int kMaxLevels = 7;  // a 640×480 image is 10×7 at level 6; nothing is left to register beyond

constexpr const char* kPoseAdvice = "Give [tx, ty, tz, qx, qy, qz, qw], metres and a unit quaternion.";

template <class T>
constexpr bool kIsList = std::is_same_v<T, std::vector<int>> || std::is_same_v<T, std::vector<double>>;

// ---- Text of values, ranges and choices ----

std::string value_text(bool value) { return value ? "true" : "false"; }
std::string value_text(int value) { return std::to_string(value); }

/// The shortest decimal that reads back to the same double; always with a point or exponent, so that TOML keeps it
/// real.
std::string value_text(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

template <class T>
std::string value_text(const std::vector<T>& value) {
  std::string text;
  for (const T& item : value) text += (text.empty() ? "" : ", ") + value_text(item);
  return "[" + text + "]";
}

template <class E>
requires std::is_enum_v<E> std::string value_text(E value) {
  return fmt::format("\"{}\"", names(E{})[static_cast<std::size_t>(value)]);
}

std::string range_text(const Range& range) {
  const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
  if (low && high) return fmt::format("{:g} to {:g}", range.low, range.high);
  if (low) return fmt::format("at least {:g}", range.low);
  if (high) return fmt::format("at most {:g}", range.high);
  return {};
}

/// What a field of this type may be, for errors: "a number from 0 to 100".
template <class T>
std::string permitted(const Range& range) {
  const std::string limits = range_text(range).empty() ? "" : ", " + range_text(range);
  if constexpr (std::is_same_v<T, bool>) return "true or false";
  if constexpr (std::is_same_v<T, int>) return "a whole number" + limits;
  if constexpr (std::is_same_v<T, double>) return "a number" + limits;
  if constexpr (std::is_same_v<T, std::vector<int>>)
    return "a list of whole numbers like [4, 5, 10], each " + range_text(range);
  if constexpr (std::is_same_v<T, std::vector<double>>)
    return "a list of numbers like [0.5, 0, 1.2], each " + range_text(range);
  if constexpr (std::is_enum_v<T>) return fmt::format("one of: {}", fmt::join(names(T{}), ", "));
}

// ---- Values out of TOML ----

/// Whether the node holds a T; `value` is set if so. A whole number is also a real one, never the other way round.
bool read_value(const toml::node& node, bool* value) {
  if (!node.is_boolean()) return false;
  *value = node.as_boolean()->get();
  return true;
}

bool read_value(const toml::node& node, int* value) {
  if (!node.is_integer()) return false;
  const std::int64_t wide = node.as_integer()->get();
  if (wide < std::numeric_limits<int>::min() || wide > std::numeric_limits<int>::max()) return false;
  *value = static_cast<int>(wide);
  return true;
}

bool read_value(const toml::node& node, double* value) {
  if (!node.is_number()) return false;
  *value = *node.value<double>();
  return true;
}

template <class T>
bool read_value(const toml::node& node, std::vector<T>* value) {
  const toml::array* array = node.as_array();
  if (array == nullptr) return false;
  std::vector<T> list(array->size());
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!read_value((*array)[i], &list[i])) return false;
  *value = std::move(list);
  return true;
}

template <class E>
requires std::is_enum_v<E>
bool read_value(const toml::node& node, E* value) {
  if (!node.is_string()) return false;
  const auto choices = names(E{});
  const auto found = std::find(choices.begin(), choices.end(), node.as_string()->get());
  if (found == choices.end()) return false;
  *value = static_cast<E>(found - choices.begin());
  return true;
}

/// Written so that NaN is out of every range.
bool in_range(double value, const Range& range) { return value >= range.low && value <= range.high; }

template <class T>
bool value_in_range(const T& value, const Range& range) {
  if constexpr (kIsList<T>) {
    return std::all_of(value.begin(), value.end(), [&](auto v) { return in_range(v, range); });
  } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
    return in_range(static_cast<double>(value), range);
  } else {
    return true;
  }
}

// ---- Visitors ----

struct Named {
  std::string group_name;
  void group(std::string_view name) { group_name = name; }
  std::string key(std::string_view name) const { return group_name + "." + std::string(name); }
};

struct KeyLister : Named {
  std::vector<std::string> keys;
  template <class T>
  void operator()(std::string_view name, const T&, std::string_view, std::string_view, const Range&) {
    keys.push_back(key(name));
  }
};

struct Checker : Named {
  template <class T>
  void operator()(std::string_view name, const T& value, std::string_view, std::string_view, const Range& range) const {
    if (!value_in_range(value, range))
      throw Error(fmt::format("{} is out of range", value_text(value)), key(name),
                  fmt::format("Give {}.", permitted<T>(range)));
  }
};

struct Loader : Named {
  const toml::table* root;
  std::string where;
  bool has_lines;  ///< `where` is a text of more than one line

  template <class T>
  void operator()(std::string_view name, T& member, std::string_view, std::string_view, const Range& range) const {
    const toml::node* node = root->at_path(key(name)).node();
    if (node == nullptr) return;
    T value{};
    if (!read_value(*node, &value))
      throw Error(fmt::format("{} cannot be {}", key(name), described(*node)), place(*node),
                  fmt::format("Give {}.", permitted<T>(range)));
    if (!value_in_range(value, range))
      throw Error(fmt::format("{} = {} is out of range", key(name), value_text(value)), place(*node),
                  fmt::format("Give {}.", permitted<T>(range)));
    member = value;
  }

  std::string place(const toml::node& node) const {
    const auto line = node.source().begin.line;  // 0: the node was not parsed from text
    return has_lines && line > 0 ? fmt::format("{}:{}", where, line) : where;
  }

  static std::string described(const toml::node& node) {
    std::ostringstream text;
    node.visit([&](const auto& n) { text << n; });
    return text.str();
  }
};

struct Printer : Named {
  std::string text;
  void group(std::string_view name) {
    Named::group(name);
    text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", name);
  }
  template <class T>
  void operator()(std::string_view name, const T& value, std::string_view unit, std::string_view help,
                  const Range& range) {
    std::string limits = range_text(range);
    if constexpr (std::is_enum_v<T>) limits = fmt::format("{}", fmt::join(names(T{}), " | "));
    std::string note(unit);
    if (!limits.empty()) note += (note.empty() ? "" : "; ") + limits;
    text += fmt::format("# {}{}\n{} = {}\n", help, note.empty() ? "" : " (" + note + ")", name, value_text(value));
  }
};

// ---- Unknown keys ----

/// Levenshtein's edit distance, one row at a time.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string_view bare_name(std::string_view key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string_view::npos ? key : key.substr(dot + 1);
}

/// The known key that was probably meant, or empty: the whole key misspelt, or the right name in the wrong group.
std::string nearest_key(std::string_view unknown, const std::vector<std::string>& known) {
  std::string best;
  std::size_t best_distance = std::max<std::size_t>(3, unknown.size() / 3) + 1;
  for (const std::string& key : known) {
    const std::size_t moved = edit_distance(bare_name(unknown), bare_name(key)) + 1;
    const std::size_t distance = std::min(edit_distance(unknown, key), moved);
    if (distance < best_distance) {
      best_distance = distance;
      best = key;
    }
  }
  return best;
}

/// Keys of earlier versions: what a configuration that has them should say now.
struct FormerKey {
  std::string_view key, advice;
};
constexpr FormerKey kFormerKeys[] = {
    {"preprocess.normals", "Leave it out: normals are those of a plane fitted to each pixel's neighbours."},
    {"preprocess.normal_radius", "Leave it out: normals are fitted to 7x7 pixels."},
    {"preprocess.normal_depth_gate", "Leave it out: neighbours within 3 % of the depth are one surface."},
    {"preprocess.bilateral_radius", "Leave it out: the filter has 13x13 pixels; preprocess.bilateral turns it off."},
    {"preprocess.bilateral_sigma_space", "Leave it out: it is 4.5 pixels; preprocess.bilateral turns the filter off."},
    {"preprocess.bilateral_sigma_range", "Leave it out: it is 0.03 m; preprocess.bilateral turns the filter off."},
    {"preprocess.decimation_range", "Leave it out: it is 0.09 m, three deviations of a reading."},
    {"tracking.widest_gate", "Leave it out: it is 0.3 m; tracking.gate_per_median = 0 keeps the gate from widening."},
    {"tracking.histogram_bins", "Leave it out: the distance distribution is made only where it is used."},
    {"tracking.histogram_range", "Leave it out: the distance distribution reaches to 0.5 m."},
    {"tracking.min_inliers", "Leave it out: it is 300; set tracking.min_inlier_fraction."},
    {"tracking.max_condition", "Leave it out: it is 1e6."},
    {"tracking.residual_sigma",
     "Multiply tracking.redundancy by (residual_sigma / 0.007)^2: only redundancy * residual_sigma^2 counts."},
    {"tracking.steady_turn", "Set tracking.speed_memory: above 0 the motion is expected to go on, its turn too."},
    {"orientation.covariance", "Give the sensor's file with --sensor-model, or tilt_sigma and heading_sigma."},
    {"orientation.probation", "Leave it out: it is 30 frames; orientation.distrust = 0 always uses the sensor."},
    {"raycast.min_distance", "Leave it out: surfaces from 0.05 m on are predicted."},
    {"raycast.max_distance", "Set preprocess.max_depth: surfaces are predicted that far, and to 10 m at least."},
};

void reject_former_key(const std::string& key, const std::string& where) {
  for (const FormerKey& former : kFormerKeys)
    if (key == former.key)
      throw Error(fmt::format("'{}' is no longer a parameter", key), where, std::string(former.advice));
}

[[noreturn]] void throw_unknown(const std::string& key, const std::string& where) {
  reject_former_key(key, where);
  const std::vector<std::string> known = parameter_keys();
  const std::string nearest = nearest_key(key, known);
  throw Error(fmt::format("unknown key '{}'", key), where,
              nearest.empty() ? "`plumbline run --print-config` lists all of them."
                              : fmt::format("Did you mean '{}'?", nearest));
}

bool is_known(std::string_view key) {
  const std::vector<std::string> known = parameter_keys();
  return std::find(known.begin(), known.end(), key) != known.end();
}

bool is_group(std::string_view name) {
  const std::vector<std::string> known = parameter_keys();
  const std::string start = std::string(name) + ".";
  return std::any_of(known.begin(), known.end(), [&](const std::string& key) { return key.starts_with(start); });
}

void reject_unknown_keys(const toml::table& root, const Loader& loader) {
  for (const auto& [group, node] : root) {
    const std::string name(group.str());
    const toml::table* table = node.as_table();
    if (!is_group(name) && (table == nullptr || table->empty())) throw_unknown(name, loader.place(node));
    if (table == nullptr)
      throw Error(fmt::format("'{}' is a group of parameters, not a value", name), loader.place(node),
                  fmt::format("Write `[{}]` and its keys below.", name));
    for (const auto& [key, value] : *table)
      if (!is_known(name + "." + std::string(key.str())))
        throw_unknown(name + "." + std::string(key.str()), loader.place(value));
  }
}

void overlay(const toml::table& root, const std::string& where, bool has_lines, Parameters* parameters) {
  Loader loader{{}, &root, where, has_lines};
  reject_unknown_keys(root, loader);
  Parameters result = *parameters;
  fields(result, loader);
  *parameters = std::move(result);
}

}  // namespace

void load_parameters(const std::string& path, Parameters* parameters) {
  std::ifstream file(path, std::ios::binary);
  std::error_code ignored;
  if (!file || std::filesystem::is_directory(path, ignored))
    throw Error("the configuration cannot be read", path, "Give the path of a TOML file.");
  const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  parse_parameters(text, path, parameters);
}

void parse_parameters(std::string_view toml, const std::string& where, Parameters* parameters) {
  toml::table root;
  try {
    root = toml::parse(toml, where);
  } catch (const toml::parse_error& error) {
    throw Error(std::string(error.description()), fmt::format("{}:{}", where, error.source().begin.line),
                "The file is TOML: `[group]` lines and `name = value` below them.");
  }
  overlay(root, where, true, parameters);
}

namespace {

/// `name = value`, where the value may be a word without quotes.
toml::table one_value(std::string_view name, std::string_view value) {
  try {
    toml::table table = toml::parse(fmt::format("{} = {}", name, value));
    if (table.size() == 1) return table;
  } catch (const toml::parse_error&) {
  }
  return toml::table{{name, value}};
}

}  // namespace

void apply_setting(std::string_view assignment, Parameters* parameters) {
  const std::string where = fmt::format("--set {}", assignment);
  const std::size_t equals = assignment.find('=');
  const std::size_t dot = assignment.find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos || dot > equals)
    throw Error("not a setting", where, "Write group.name=value, for example tracking.normal_gate=25.");
  const std::string_view key = assignment.substr(0, equals), value = assignment.substr(equals + 1);
  // The key goes through the table, not through the parser: it may be anything, also what TOML could not hold.
  if (!is_known(key)) throw_unknown(std::string(key), where);

  overlay(toml::table{{key.substr(0, dot), one_value(key.substr(dot + 1), value)}}, where, false, parameters);
}

std::string to_toml(const Parameters& parameters) {
  Printer printer;
  fields(parameters, printer);
  return printer.text;
}

std::vector<std::string> parameter_keys() {
  const Parameters parameters;
  KeyLister lister;
  fields(parameters, lister);
  return lister.keys;
}

void validate(const Parameters& parameters) {
  fields(parameters, Checker{});
  const auto& [preprocess, tracking, orientation, motion, volume, mesh] = parameters;
  if (preprocess.min_depth >= preprocess.max_depth)
    throw Error("no depth lies between preprocess.min_depth and preprocess.max_depth", "preprocess.min_depth",
                "Make it smaller than preprocess.max_depth.");
  const int levels = static_cast<int>(tracking.iterations.size());
  if (levels == 0 || std::all_of(tracking.iterations.begin(), tracking.iterations.end(), [](int n) { return n == 0; }))
    throw Error("no iteration at any level", "tracking.iterations", "Give at least one, for example [4, 5, 10].");
  if (tracking.finest_level + levels > kMaxLevels)
    throw Error(fmt::format("{} levels from level {} on are too many", levels, tracking.finest_level),
                "tracking.iterations", fmt::format("Levels 0 to {} exist.", kMaxLevels - 1));
  const int voxels = (volume.resolution + 7) / 8 * 8;
  const double voxel = volume.side / voxels;
  if (volume.truncation < voxel)
    throw Error(
        fmt::format("{:g} m is less than one voxel ({:.4g} m): surfaces would have holes", volume.truncation, voxel),
        "volume.truncation", "Raise it or volume.resolution, or make volume.side smaller.");
  if (volume.truncation > volume.side / 2)
    throw Error(fmt::format("{:g} m is more than half of the volume's side", volume.truncation), "volume.truncation",
                "Make it smaller, or volume.side larger.");
  const std::vector<double>& pose = volume.pose;
  if (pose.size() != 7) throw Error(fmt::format("{} numbers are no pose", pose.size()), "volume.pose", kPoseAdvice);
  if (std::abs(Eigen::Vector4d(pose[3], pose[4], pose[5], pose[6]).norm() - 1) > 0.01)
    throw Error("the last four numbers are no unit quaternion", "volume.pose", kPoseAdvice);
}

}  // namespace plumbline
