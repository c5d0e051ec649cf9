#include "io/recorded_camera.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "io/atomic_file.h"
#include "io/pose_matrix.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr const char* kMatrixAdvice = "write the matrix as three lines: fx 0 cx, 0 fy cy, 0 0 1";

/// Every number of the file; brackets count as blanks.
std::vector<double> numbers_of(const TextFile& file) {
  std::vector<double> numbers;
  for (const TextLine& line : file.lines()) {
    std::string text(line.text);
    for (char& c : text)
      if (c == '[' || c == ']' || c == '(' || c == ')' || c == ';') c = ' ';
    for (const std::string_view field : split_fields(text, true)) {
      const auto value = parse_double(field);
      if (!value || !std::isfinite(*value))
        file.fail(line, fmt::format("'{}' is not a finite number", field), kMatrixAdvice);
      numbers.push_back(*value);
    }
  }
  return numbers;
}

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kRecordedCameraAdvice = "give the intrinsics of the depth images with --intrinsics fx,fy,cx,cy";

RecordedCamera made(double fx, double fy, double cx, double cy, double width, double height, const std::string& path) {
  const auto side = [](double v) { return v > 0 && v <= 16384 ? static_cast<int>(v) : 0; };
  RecordedCamera result;
  result.choice.camera = {static_cast<float>(fx),
                          static_cast<float>(fy),
                          static_cast<float>(cx),
                          static_cast<float>(cy),
                          side(width),
                          side(height)};
  result.choice.source = fs::path(path).filename().string();
  return result;
}

RecordedCamera from_matrix(const std::vector<double>& m, const std::string& path) {
  const std::size_t row = m.size() == 9 ? 3 : 4;
  const auto at = [&](std::size_t r, std::size_t c) { return m[r * row + c]; };
  if (std::abs(at(0, 1)) > 1e-6 || at(1, 0) != 0 || at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1)
    throw Error("is not the matrix of a camera without skew", path, kMatrixAdvice);
  return made(at(0, 0), at(1, 1), at(0, 2), at(1, 2), 0, 0, path);
}

double number_in(const json& object, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (object.contains(name) && object.at(name).is_number()) return object.at(name).get<double>();
  return 0;
}

/// Readings a metre, 0 where the object tells none. RealSense writes metres a reading, the others readings a metre.
double scale_in(const json& object) {
  for (const char* name : {"depth_unit", "depth_units", "depthUnit"})
    if (object.contains(name) && object.at(name).is_string()) {
      const std::string unit = lower(object.at(name).get<std::string>());
      return unit == "mm" || unit.starts_with("milli") ? 1000 : unit == "cm" || unit.starts_with("centi") ? 100 : 0;
    }
  const double scale = number_in(object, {"scale", "depth_scale", "depthScale", "png_depth_scale", "depth_factor",
                                          "depth_units", "depth_unit", "depthUnits", "depth_scale_factor"});
  return scale > 0 && scale < 0.1 ? 1 / scale : scale > 10 ? scale : 0;
}

/// The part of the file that is the depth camera's, where several cameras lie side by side.
const json& camera_part(const json& root) {
  for (const char* name : {"depth", "depth_camera", "depth_intrinsics", "depthCamera", "depth_intrinsic", "camera"})
    if (root.is_object() && root.contains(name) && root.at(name).is_object()) return root.at(name);
  return root;
}

/// Nine numbers in rows, or in columns as Open3D and Record3D write them: told apart by where the last 1's row is.
RecordedCamera from_json_matrix(json values, double width, double height, const std::string& path) {
  if (values.size() == 3) {
    json flat = json::array();
    for (const json& row : values)
      for (const json& value : row) flat.push_back(value);
    values = flat;
  }
  std::array<double, 9> m{};
  if (values.size() != m.size()) throw Error("has no matrix of 9 numbers", path, kRecordedCameraAdvice);
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = values.at(i).get<double>();
  const bool columns = m[2] == 0 && m[5] == 0;
  return made(m[0], m[4], columns ? m[6] : m[2], columns ? m[7] : m[5], width, height, path);
}

/// A unit quaternion x y z w.
Eigen::Matrix3d mounting_in(const json& values, const std::string& path) {
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  if (values.is_array() && values.size() == 4)
    for (std::size_t i = 0; i < 4; ++i) q[static_cast<int>(i)] = values.at(i).get<double>();
  if (!(std::abs(q.norm() - 1) < 1e-2))
    throw Error("its body_from_camera is no unit quaternion", path, "write it as [qx, qy, qz, qw]");
  return Eigen::Quaterniond(q).normalized().toRotationMatrix();
}

RecordedCamera parse_json_camera(const json& root, const std::string& path) {
  const json& object = camera_part(root);
  const double width = number_in(object, {"width", "w", "W", "image_width"});
  const double height = number_in(object, {"height", "h", "H", "image_height"});
  RecordedCamera result;
  for (const char* name : {"intrinsic_matrix", "K", "camera_matrix", "intrinsics"})
    if (object.contains(name) && object.at(name).is_array()) {
      result = from_json_matrix(object.at(name), width, height, path);
      break;
    }
  if (result.choice.source.empty()) {
    const json& k =
        object.contains("intrinsics") && object.at("intrinsics").is_object() ? object.at("intrinsics") : object;
    const double fx = number_in(k, {"fx", "fl_x", "focal_x"}), fy = number_in(k, {"fy", "fl_y", "focal_y"});
    if (fx == 0 || fy == 0) throw Error("has no intrinsics", path, kRecordedCameraAdvice);
    result = made(fx, fy, number_in(k, {"cx", "ppx"}), number_in(k, {"cy", "ppy"}),
                  width > 0 ? width : number_in(k, {"width", "w"}), height > 0 ? height : number_in(k, {"height", "h"}),
                  path);
  }
  if (object.contains("body_from_camera")) result.body_from_camera = mounting_in(object.at("body_from_camera"), path);
  result.depth_scale = scale_in(object);
  if (result.depth_scale == 0) result.depth_scale = scale_in(root);
  return result;
}

struct KnownFile {
  const char* name;
  RecordedCamera (*read)(const std::string& path);
};

/// What tells the depth camera comes before what may be the colour camera's.
constexpr std::array kKnownFiles = {
    KnownFile{"intrinsic_depth.txt", read_text_camera},
    KnownFile{"intrinsics_depth.txt", read_text_camera},
    KnownFile{"depth_intrinsics.txt", read_text_camera},
    KnownFile{"depth_intrinsic.txt", read_text_camera},
    KnownFile{"camera_intrinsic.json", read_json_camera},
    KnownFile{"camera_intrinsics.json", read_json_camera},
    KnownFile{"intrinsic.json", read_json_camera},
    KnownFile{"intrinsics.json", read_json_camera},
    KnownFile{"cam_params.json", read_json_camera},
    KnownFile{"_info.txt", read_info_camera},
    KnownFile{"info.txt", read_info_camera},
    KnownFile{"calibration.txt", read_text_camera},
    KnownFile{"camera_matrix.csv", read_text_camera},
    KnownFile{"camera-intrinsics.txt", read_text_camera},
    KnownFile{"intrinsics.txt", read_text_camera},
    KnownFile{"intrinsic.txt", read_text_camera},
    KnownFile{"camera_intrinsics.txt", read_text_camera},
    KnownFile{"K.txt", read_text_camera},
    KnownFile{"camera.txt", read_text_camera},
    KnownFile{"camera.json", read_json_camera},
    KnownFile{"transforms.json", read_json_camera},
};

/// intrinsic_color.txt for intrinsic_depth.txt; other names stay as they are.
std::string color_name(std::string name) {
  const std::size_t at = name.find("_depth.txt");
  return at == std::string::npos ? name : name.replace(at, 6, "_color");
}

/// What the files of one place tell, the likeliest first, and what is wrong with those that tell nothing.
struct CamerasOfPlace {
  std::vector<RecordedCamera> found;
  std::vector<Warning> unread;
};

/// ScanNet's extrinsic_color.txt and extrinsic_depth.txt, of both cameras against one frame; none: one place.
SE3 extrinsics_in(const fs::path& folder) {
  const auto extrinsic = [&](const char* name) {
    std::error_code error;
    if (!fs::is_regular_file(folder / name, error)) return SE3();
    const std::string path = (folder / name).string();
    return pose_of_matrix(numbers_of(TextFile(path)), path).value_or(SE3());
  };
  return extrinsic("extrinsic_color.txt").inverse() * extrinsic("extrinsic_depth.txt");
}

void read_into(const KnownFile& file, const fs::path& folder, CamerasOfPlace* cameras) {
  try {
    RecordedCamera camera = file.read((folder / file.name).string());
    const fs::path color = folder / color_name(file.name);
    std::error_code error;
    if (color.filename() != file.name && fs::is_regular_file(color, error))
      camera.color = read_text_camera(color.string()).choice.camera;
    if (camera.color) camera.color_from_depth = extrinsics_in(folder);
    cameras->found.push_back(std::move(camera));
  } catch (const Error& error) {
    const std::string_view text = error.what();
    const std::size_t end = text.find('\n');
    cameras->unread.push_back({fmt::format("a file with the camera's name is not used: {}", text.substr(0, end)),
                               std::string(trim(text.substr(std::min(end, text.size()))))});
  }
}

std::vector<fs::path> yaml_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string extension = lower(it->path().extension().string());
    if (extension == ".yaml" || extension == ".yml") files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// camera-intrinsics.txt in the folder itself is choose_camera's.
CamerasOfPlace cameras_in(const fs::path& folder, bool is_parent) {
  std::error_code error;
  CamerasOfPlace cameras;
  for (const KnownFile& file : kKnownFiles)
    if ((is_parent || file.name != std::string_view("camera-intrinsics.txt")) &&
        fs::is_regular_file(folder / file.name, error))
      read_into(file, folder, &cameras);
  if (is_parent) return cameras;
  for (const fs::path& file : yaml_files(folder)) try {
      cameras.found.push_back(read_yaml_camera(file.string()));
    } catch (const Error&) {  // many other things are kept in such files
    }
  return cameras;
}

bool is_depths(const RecordedCamera& camera) { return camera.choice.source.find("depth") != std::string::npos; }

/// Files that tell cameras of one size apart, or two scales: one of them is a leftover.
void warn_of_contradiction(const RecordedCamera& taken, const RecordedCamera& other, std::vector<Warning>* warnings) {
  if (is_depths(taken) != is_depths(other) || other.choice.source == taken.choice.source) return;
  const Pinhole &a = taken.choice.camera, &b = other.choice.camera;
  const bool same_size = a.width == 0 || b.width == 0 || (a.width == b.width && a.height == b.height);
  const bool same_shape = std::abs(a.cx * b.cy / (a.cy * b.cx) - 1) < 0.03f;
  const float factor = same_size && same_shape && a.width == b.width ? 1 : b.cx / a.cx;
  const bool other_camera = same_shape && std::abs(a.fx * factor / b.fx - 1) > 0.02f;
  const bool other_scale =
      taken.depth_scale > 0 && other.depth_scale > 0 && std::abs(taken.depth_scale / other.depth_scale - 1) > 0.01;
  if (!other_camera && !other_scale) return;
  warnings->push_back({other_scale
                           ? fmt::format("{} tells {:g} readings a metre and {} tells {:g}; the first was taken",
                                         taken.choice.source, taken.depth_scale, other.choice.source, other.depth_scale)
                           : fmt::format("{} tells fx {:g} and {} tells fx {:g}; the first was taken",
                                         taken.choice.source, a.fx, other.choice.source, b.fx),
                       "Remove the file that is not of this recording, or give --intrinsics and --depth-scale."});
}

}  // namespace

RecordedCamera read_json_camera(const std::string& path) {
  try {
    return parse_json_camera(json::parse(read_file(path)), path);
  } catch (const json::exception& error) {
    throw Error(fmt::format("is no camera that can be understood ({})", error.what()), path, kRecordedCameraAdvice);
  }
}

RecordedCamera read_text_camera(const std::string& path) {
  const std::vector<double> m = numbers_of(TextFile(path));
  if (m.size() == 9 || m.size() == 16) return from_matrix(m, path);
  if (m.size() == 4) return made(m[0], m[1], m[2], m[3], 0, 0, path);
  throw Error(fmt::format("has {} numbers where a matrix has 9, and fx fy cx cy are 4", m.size()), path, kMatrixAdvice);
}

RecordedCamera read_info_camera(const std::string& path) {
  const TextFile file(path);
  std::map<std::string, std::vector<double>> values;
  for (const TextLine& line : file.lines()) {
    const std::size_t equals = line.text.find('=');
    if (equals == std::string_view::npos) continue;
    std::vector<double>& numbers = values[std::string(trim(line.text.substr(0, equals)))];
    for (const std::string_view field : split_fields(line.text.substr(equals + 1), true))
      if (const auto value = parse_double(field); value && std::isfinite(*value)) numbers.push_back(*value);
  }
  const auto number = [&](const std::string& name) { return values[name].size() == 1 ? values[name].front() : 0.0; };
  const auto camera = [&](const std::string& kind) -> std::optional<Pinhole> {
    const std::vector<double>& m = values[fmt::format("m_calibration{}Intrinsic", kind)];
    if (m.size() != 16 && m.size() != 9) return std::nullopt;
    const Pinhole k = from_matrix(m, path).choice.camera;
    const std::string side = kind == "Depth" ? "m_depth" : "m_color";
    return made(k.fx, k.fy, k.cx, k.cy, number(side + "Width"), number(side + "Height"), path).choice.camera;
  };
  const std::optional<Pinhole> depth = camera("Depth"), color = camera("Color");
  if (depth || color) {
    RecordedCamera result;
    result.choice = {depth ? *depth : *color, {}, fs::path(path).filename().string(), false};
    result.depth_scale = number("m_depthShift");
    if (depth) result.color = color;
    return result;
  }
  // ScanNet's scene0000_00.txt names its numbers one by one.
  if (number("fx_depth") > 0)
    return made(number("fx_depth"), number("fy_depth"), number("mx_depth"), number("my_depth"), number("depthWidth"),
                number("depthHeight"), path);
  throw Error("has no intrinsics of the depth camera", path, kRecordedCameraAdvice);
}

namespace {

/// `key: value` with one number, and lists in brackets, which may run over several lines: [fx, fy, cx, cy] or a matrix.
struct YamlValues {
  std::map<std::string, double> numbers;
  std::map<std::string, std::vector<double>> lists;

  double number(const std::string& name) const { return numbers.contains(name) ? numbers.at(name) : 0.0; }
};

void read_yaml_line(std::string_view text, std::string* key, bool* inside, YamlValues* values) {
  text = trim(text.substr(0, text.find('#')));
  const std::size_t colon = *inside ? std::string_view::npos : text.find(':');
  if (colon != std::string_view::npos) {
    std::string name(trim(text.substr(0, colon)));
    text = trim(text.substr(colon + 1));
    if (name.starts_with("Camera1.")) name = "Camera." + name.substr(8);
    if (const auto value = parse_double(text); value && std::isfinite(*value)) values->numbers[name] = *value;
    if (name != "data" && name != "rows" && name != "cols" && name != "dt") *key = name;
  }
  const std::size_t open = text.find('[');
  if (!*inside && open == std::string_view::npos) return;
  if (!*inside) {
    values->lists[*key].clear();
    text.remove_prefix(open + 1);
  }
  const std::size_t close = text.find(']');
  *inside = close == std::string_view::npos;
  for (const std::string_view field : split_fields(text.substr(0, close), true))
    values->lists[*key].push_back(parse_double(field).value_or(std::nan("")));
}

YamlValues read_yaml_values(const std::string& path) {
  const TextFile file(path);
  YamlValues values;
  std::string key;
  bool inside = false;
  for (const TextLine& line : file.lines()) read_yaml_line(line.text, &key, &inside, &values);
  return values;
}

/// camera_matrix of ROS and OpenCV, intrinsics of Kalibr.
std::optional<RecordedCamera> from_yaml_lists(const YamlValues& values, const std::string& path) {
  double width = values.number("image_width"), height = values.number("image_height");
  if (values.lists.contains("resolution") && values.lists.at("resolution").size() == 2) {
    width = values.lists.at("resolution")[0];
    height = values.lists.at("resolution")[1];
  }
  for (const char* name : {"camera_matrix", "cameraMatrix", "K", "intrinsics", "intrinsic_matrix"}) {
    const auto found = values.lists.find(name);
    if (found == values.lists.end()) continue;
    const std::vector<double>& v = found->second;
    if ((v.size() != 4 && v.size() != 9) || !std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); }))
      continue;
    RecordedCamera camera = v.size() == 4 ? made(v[0], v[1], v[2], v[3], 0, 0, path) : from_matrix(v, path);
    camera.choice.camera.width = made(1, 1, 0, 0, width, height, path).choice.camera.width;
    camera.choice.camera.height = made(1, 1, 0, 0, width, height, path).choice.camera.height;
    return camera;
  }
  return std::nullopt;
}

}  // namespace

RecordedCamera read_yaml_camera(const std::string& path) {
  const YamlValues values = read_yaml_values(path);
  const auto number = [&](const std::string& name) { return values.number(name); };
  const bool orb = number("Camera.fx") != 0 && number("Camera.fy") != 0;
  const auto listed = orb ? std::nullopt : from_yaml_lists(values, path);
  if (!orb && !listed) throw Error("has no Camera.fx and Camera.fy and no camera_matrix", path, kRecordedCameraAdvice);
  RecordedCamera result = listed ? *listed
                                 : made(number("Camera.fx"), number("Camera.fy"), number("Camera.cx"),
                                        number("Camera.cy"), number("Camera.width"), number("Camera.height"), path);
  if (orb)
    result.choice.distortion = {number("Camera.k1"), number("Camera.k2"), number("Camera.p1"), number("Camera.p2"),
                                number("Camera.k3")};
  const auto& lists = values.lists;
  const auto coefficients = lists.find("distortion_coefficients");
  if (!orb && coefficients != lists.end() && coefficients->second.size() == 5) {
    const std::vector<double>& k = coefficients->second;
    result.choice.distortion = {k[0], k[1], k[2], k[3], k[4]};
  }
  for (const char* name : {"DepthMapFactor", "RGBD.DepthMapFactor", "depth_scale", "png_depth_scale"})
    if (number(name) > 1) result.depth_scale = number(name);
  return result;
}

std::optional<RecordedCamera> find_recorded_camera(const std::string& folder, std::vector<Warning>* warnings) {
  std::error_code error;
  fs::path here = fs::absolute(folder, error).lexically_normal();
  if (!here.has_filename()) here = here.parent_path();
  for (const fs::path& place : {here, here / "intrinsic", here.parent_path()}) {
    CamerasOfPlace cameras = cameras_in(place, place == here.parent_path());
    warnings->insert(warnings->end(), cameras.unread.begin(), cameras.unread.end());
    if (cameras.found.empty()) continue;
    for (const RecordedCamera& other : cameras.found) warn_of_contradiction(cameras.found.front(), other, warnings);
    RecordedCamera found = std::move(cameras.found.front());
    found.choice.source += place == here                 ? " in the folder"
                           : place == here.parent_path() ? " one folder up"
                                                         : " in intrinsic/";
    return found;
  }
  return std::nullopt;
}

std::optional<Pinhole> sized_by_centre(Pinhole camera, double shape) {
  constexpr std::array<std::pair<int, int>, 19> kSizes = {{{1920, 1440},
                                                           {1280, 960},
                                                           {640, 480},
                                                           {1920, 1080},
                                                           {256, 192},
                                                           {320, 240},
                                                           {512, 384},
                                                           {960, 720},
                                                           {1024, 768},
                                                           {1280, 720},
                                                           {848, 480},
                                                           {640, 360},
                                                           {960, 540},
                                                           {1296, 968},
                                                           {1440, 1080},
                                                           {2048, 1536},
                                                           {640, 576},
                                                           {3840, 2160},
                                                           {160, 120}}};
  double best = 0.08;
  for (const auto& [longer, shorter] : kSizes)
    for (const auto& [width, height] : {std::pair(longer, shorter), {shorter, longer}}) {
      if (shape > 0 && std::abs(static_cast<double>(width) / height / shape - 1) > 0.01) continue;
      const double off =
          std::max(std::abs((2.0 * camera.cx + 1) / width - 1), std::abs((2.0 * camera.cy + 1) / height - 1));
      if (off >= best) continue;
      best = off;
      camera.width = width;
      camera.height = height;
    }
  return best < 0.08 ? std::optional(camera) : std::nullopt;
}

std::optional<Pinhole> scaled_to(const Pinhole& camera, int width, int height) {
  if (camera.width <= 0 || camera.height <= 0) return std::nullopt;
  const double sx = static_cast<double>(width) / camera.width, sy = static_cast<double>(height) / camera.height;
  if (std::abs(sx / sy - 1) > 0.01) return std::nullopt;
  Pinhole scaled{static_cast<float>(camera.fx * sx),
                 static_cast<float>(camera.fy * sy),
                 static_cast<float>((camera.cx + 0.5) * sx - 0.5),
                 static_cast<float>((camera.cy + 0.5) * sy - 0.5),
                 width,
                 height};
  return scaled;
}

void write_camera_json(const std::string& folder, const Pinhole& camera, double depth_scale,
                       const std::optional<Eigen::Matrix3d>& body_from_camera) {
  std::string text =
      fmt::format("{{\"width\": {}, \"height\": {}, \"fx\": {}, \"fy\": {}, \"cx\": {}, \"cy\": {}, \"scale\": {}",
                  camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, depth_scale);
  if (body_from_camera) {
    const Eigen::Quaterniond q(*body_from_camera);
    text += fmt::format(", \"body_from_camera\": [{:.12g}, {:.12g}, {:.12g}, {:.12g}]", q.x(), q.y(), q.z(), q.w());
  }
  write_file((fs::path(folder) / "camera.json").string(), text + "}\n");
}

Pinhole read_matrix_file(const std::string& path) {
  const std::vector<double> m = numbers_of(TextFile(path));
  if (m.size() != 9 && m.size() != 16)
    throw Error(fmt::format("has {} numbers where the matrix has 9", m.size()), path, kMatrixAdvice);
  return from_matrix(m, path).choice.camera;
}

}  // namespace plumbline
