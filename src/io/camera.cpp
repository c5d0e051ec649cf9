#include "io/camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

struct NamedCamera {
  std::string_view name, words;
  Pinhole camera;
  Distortion distortion;
};

/// The published calibrations of 640×480 cameras. bonn: https://www.ipb.uni-bonn.de/data/rgbd-dynamic-dataset.
/// freiburg*: the colour cameras' of https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats, whose frame the
/// depth images are registered to; freiburg3's images come without distortion. ICL-NUIM's y axis points up, hence the
/// negative fy.
const std::array<NamedCamera, 7> kCameras = {{
    {"fr1", "TUM freiburg1", {517.3f, 516.5f, 318.6f, 255.3f, 640, 480}, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}},
    {"fr2", "TUM freiburg2", {520.9f, 521.0f, 325.1f, 249.7f, 640, 480}, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}},
    {"fr3", "TUM freiburg3", {535.4f, 539.2f, 320.1f, 247.6f, 640, 480}, {}},
    {"bonn",
     "Bonn RGB-D Dynamic",
     {542.822841f, 542.576870f, 315.593520f, 237.756098f, 640, 480},
     {0.039903, -0.099343, -0.000730, -0.000144, 0}},
    {"icl", "ICL-NUIM", {481.20f, -480.00f, 319.5f, 239.5f, 640, 480}, {}},
    {"7scenes", "7-Scenes", {585.0f, 585.0f, 320.0f, 240.0f, 640, 480}, {}},
    {"kinect", "Kinect, the ROS default", {525.0f, 525.0f, 319.5f, 239.5f, 640, 480}, {}},
}};

constexpr const char* kCameraAdvice =
    "give the intrinsics (fx, fy, cx, cy in pixels), name a camera (fr1, fr2, fr3, bonn, icl, 7scenes, kinect), or put "
    "the "
    "3x3 matrix into camera-intrinsics.txt in the folder";

const NamedCamera* find_camera(std::string name) {
  name = lower(name);
  if (name.starts_with("freiburg")) name = "fr" + name.substr(8);
  for (const NamedCamera& camera : kCameras)
    if (camera.name == name) return &camera;
  return nullptr;
}

CameraChoice choice_of(const NamedCamera& camera, const std::string& source) {
  return {camera.camera, camera.distortion, source, false};
}

CameraChoice named_camera(const std::string& name) {
  const NamedCamera* camera = find_camera(name);
  if (camera == nullptr) throw Error("there is no camera named '" + name + "'", "camera", kCameraAdvice);
  return choice_of(*camera, fmt::format("camera named {} ({})", name, camera->words));
}

/// A 3×3 matrix fx 0 cx, 0 fy cy, 0 0 1.
CameraChoice read_intrinsics(const std::string& path) {
  const TextFile file(path);
  const std::string advice = "write the matrix as three lines: fx 0 cx, 0 fy cy, 0 0 1";
  std::vector<double> m;
  for (const TextLine& line : file.lines()) {
    for (const std::string_view field : split_fields(line.text, true)) {
      const auto value = parse_double(field);
      if (!value || !std::isfinite(*value)) file.fail(line, fmt::format("'{}' is not a finite number", field), advice);
      m.push_back(*value);
    }
  }
  if (m.size() != 9) throw Error(fmt::format("has {} numbers where the matrix has 9", m.size()), path, advice);
  if (std::abs(m[1]) > 1e-6 || m[3] != 0 || m[6] != 0 || m[7] != 0 || m[8] != 1)
    throw Error("is not the matrix of a camera without skew", path, advice);
  const Pinhole camera{
      static_cast<float>(m[0]), static_cast<float>(m[4]), static_cast<float>(m[2]), static_cast<float>(m[5]), 0, 0};
  return {camera, {}, "camera-intrinsics.txt in the folder", false};
}

std::optional<CameraChoice> camera_by_folder_name(const std::string& folder) {
  for (const std::string& name : folder_names(folder)) {
    for (const std::string_view number : {"1", "2", "3"}) {
      const std::string full = fmt::format("freiburg{}", number), brief = fmt::format("fr{}", number);
      if (lower(name).find(full) == std::string::npos && !contains_word(lower(name), brief)) continue;
      return choice_of(*find_camera(brief), fmt::format("freiburg{} in the folder's name '{}'", number, name));
    }
    if (!contains_word(lower(name), "bonn")) continue;
    CameraChoice choice = choice_of(*find_camera("bonn"), fmt::format("'bonn' in the folder's name '{}'", name));
    choice.is_guess = true;
    return choice;
  }
  return std::nullopt;
}

std::string other_size(const NamedCamera* usual, const CameraClues& clues) {
  if (usual == nullptr) return "";
  return fmt::format(" (the usual ones, {}, are of {}x{} images, but these are {}x{})", usual->words,
                     usual->camera.width, usual->camera.height, clues.width, clues.height);
}

CameraChoice find_choice(const SequenceOptions& options, const CameraClues& clues) {
  if (options.intrinsics) return {*options.intrinsics, {}, "given intrinsics", false};
  if (!options.camera.empty()) return named_camera(options.camera);
  if (clues.calibration) return *clues.calibration;
  const fs::path file = fs::path(clues.folder) / "camera-intrinsics.txt";
  if (std::error_code error; fs::exists(file, error)) return read_intrinsics(file.string());
  if (auto choice = camera_by_folder_name(clues.folder)) return *choice;
  const NamedCamera* usual = find_camera(clues.format_camera);
  const bool is_of_these =
      usual != nullptr &&
      (!clues.format_is_guess || (usual->camera.width == clues.width && usual->camera.height == clues.height));
  if (!is_of_these)
    throw Error("the camera's intrinsics are not known" + other_size(usual, clues) + clues.refusal, clues.folder,
                kCameraAdvice);
  CameraChoice choice = choice_of(*usual, fmt::format("the format's own ({})", usual->words));
  choice.is_guess = clues.format_is_guess;
  return choice;
}

/// A principal point this near to the image's border, or beyond it, belongs to an image of another size.
bool is_far_out(float c, int size) {
  const float relative = (c + 0.5f) / static_cast<float>(size);
  return !(relative > 0.05f && relative < 0.95f);
}

void check_size(const CameraChoice& choice, const CameraClues& clues) {
  const Pinhole& camera = choice.camera;
  if ((camera.width != 0 && camera.width != clues.width) || (camera.height != 0 && camera.height != clues.height))
    throw Error(fmt::format("the camera ({}) is one of {}x{} images, but these are {}x{}", choice.source, camera.width,
                            camera.height, clues.width, clues.height),
                clues.folder, kCameraAdvice);
}

void check_values(const CameraChoice& choice, const CameraClues& clues) {
  const Pinhole& camera = choice.camera;
  const std::string values = fmt::format("fx {} fy {} cx {} cy {}", camera.fx, camera.fy, camera.cx, camera.cy);
  if (!camera.is_valid())
    throw Error(fmt::format("the intrinsics ({}: {}) are not those of a camera", choice.source, values), clues.folder,
                "give a positive fx, an fy that is not zero, and finite cx and cy, in pixels");
  if (is_far_out(camera.cx, camera.width) || is_far_out(camera.cy, camera.height))
    throw Error(fmt::format("the principal point ({}: {}) lies at the edge of the {}x{} images or beyond it; the "
                            "intrinsics seem to belong to images of another size",
                            choice.source, values, camera.width, camera.height),
                clues.folder, "scale the intrinsics to the size of these images");
}

void check_distortion(const Distortion& d, const CameraClues& clues) {
  for (const double k : {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6})
    if (!std::isfinite(k)) throw Error("a distortion coefficient is not finite", clues.folder, "give k1 k2 p1 p2 k3");
}

}  // namespace

std::vector<std::string> camera_names() {
  std::vector<std::string> names;
  names.reserve(kCameras.size());
  for (const NamedCamera& camera : kCameras) names.emplace_back(camera.name);
  return names;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

bool contains_word(std::string_view text, std::string_view word) {
  const auto is_inside = [&](std::size_t i) {
    return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i]));
  };
  for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1))
    if (!is_inside(at - 1) && !is_inside(at + word.size())) return true;  // 0 − 1 is beyond every text
  return false;
}

std::vector<std::string> folder_names(const std::string& path) {
  std::error_code error;
  std::vector<std::string> names;
  for (fs::path p : {fs::absolute(path, error).lexically_normal(), fs::weakly_canonical(path, error)}) {
    if (!p.has_filename()) p = p.parent_path();  // "folder/"
    const std::string name = p.filename().string();
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

CameraChoice choose_camera(const SequenceOptions& options, const CameraClues& clues) {
  CameraChoice choice = find_choice(options, clues);
  check_size(choice, clues);
  choice.camera.width = clues.width;
  choice.camera.height = clues.height;
  check_values(choice, clues);
  if (options.distortion) choice.distortion = *options.distortion;
  check_distortion(choice.distortion, clues);
  return choice;
}

}  // namespace plumbline
