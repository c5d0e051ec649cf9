#include "io/orientation_calibration.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/text_file.h"

namespace plumbline {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr const char* kAdvice = "Let `plumbline calibrate` write it anew.";

/// The values of one file, with errors that name the line.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {
    try {
      root_ = toml::parse(read_file(path), path);
    } catch (const toml::parse_error& error) {
      throw Error(std::string(error.description()), fmt::format("{}:{}", path, error.source().begin.line), kAdvice);
    }
  }

  /// `count` numbers of at most `largest`.
  std::vector<double> numbers(const char* key, std::size_t count, double largest) const {
    const toml::node* node = find(key);
    const toml::array* array = node->as_array();
    std::vector<double> values;
    if (array != nullptr)
      for (const toml::node& item : *array) values.push_back(item.value<double>().value_or(std::nan("")));
    else
      values.push_back(node->value<double>().value_or(std::nan("")));
    const bool good = values.size() == count && std::all_of(values.begin(), values.end(), [&](double v) {
                        return std::abs(v) <= largest;  // false for NaN
                      });
    if (!good) fail(*node, fmt::format("{} is not {}", key, count == 1 ? "a number in range" : "a list of numbers"));
    return values;
  }

  template <class E>
  E choice(const char* key) const {
    const toml::node* node = find(key);
    const auto known = names(E{});
    const auto found = std::find(known.begin(), known.end(), node->value_or(std::string_view()));
    if (found == known.end()) fail(*node, fmt::format("{} has no such value", key));
    return static_cast<E>(found - known.begin());
  }

 private:
  const toml::node* find(const char* key) const {
    const toml::node* node = root_.at_path(key).node();
    if (node == nullptr) throw Error(fmt::format("there is no {}", key), path_, kAdvice);
    return node;
  }
  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw Error(what, fmt::format("{}:{}", path_, node.source().begin.line), kAdvice);
  }

  std::string path_;
  toml::table root_;
};

template <class E>
std::string_view name_of(E value) {
  return names(E{})[static_cast<std::size_t>(value)];
}

}  // namespace

void write_orientation_calibration(const std::string& path, const OrientationCalibration& c,
                                   const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += "# " + comment + "\n";
  const Eigen::Quaterniond q(c.body_from_camera);
  const Eigen::Vector3d sd = c.mounting_sd / kDegree;
  text += fmt::format(
      "\n[mounting]\nbody_from_camera = [{:.9f}, {:.9f}, {:.9f}, {:.9f}]  # qx qy qz qw\n"
      "sd_deg = [{:.4f}, {:.4f}, {:.4f}]  # about the camera's axes x, y, z\n"
      "\n[time]\noffset = {:.6f}  # s, added to the sensor's stamps\nsd = {:.6f}  # s\n"
      "\n[readings]\nquaternion = \"{}\"\norientation_of = \"{}\"\nearth = \"{}\"\n",
      q.x(), q.y(), q.z(), q.w(), sd.x(), sd.y(), sd.z(), c.time_offset, c.time_offset_sd,
      name_of(c.convention.quaternion.value_or(QuaternionOrder::xyzw)), name_of(c.convention.orientation_of),
      name_of(c.convention.earth));
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

OrientationCalibration read_orientation_calibration(const std::string& path) {
  const Reader reader(path);
  OrientationCalibration c;
  const std::vector<double> q = reader.numbers("mounting.body_from_camera", 4, 1.01);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (std::abs(rotation.norm() - 1) > 0.01)
    throw Error("mounting.body_from_camera is no unit quaternion", path, kAdvice);
  c.body_from_camera = rotation.normalized().toRotationMatrix();
  const std::vector<double> sd = reader.numbers("mounting.sd_deg", 3, 360);
  c.mounting_sd = kDegree * Eigen::Vector3d(sd[0], sd[1], sd[2]);
  c.time_offset = reader.numbers("time.offset", 1, 1e9)[0];
  c.time_offset_sd = reader.numbers("time.sd", 1, 1e9)[0];
  c.convention.quaternion = reader.choice<QuaternionOrder>("readings.quaternion");
  c.convention.orientation_of = reader.choice<OrientationOf>("readings.orientation_of");
  c.convention.earth = reader.choice<EarthAxes>("readings.earth");
  return c;
}

}  // namespace plumbline
