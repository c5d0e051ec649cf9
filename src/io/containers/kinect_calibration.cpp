#include "io/containers/kinect_calibration.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "plumbline/error.h"

namespace plumbline {
namespace {

using nlohmann::json;

constexpr const char* kKinectCalibrationAdvice = "give the intrinsics of the depth camera (fx, fy, cx, cy in pixels)";

/// How a mode's image lies in that of the sensor: binned to `full` pixels a side, then cut out from `left`, `top` on.
struct Window {
  int full_width, full_height, left, top, width, height;
};

Window depth_window(std::string_view mode, const std::string& name) {
  if (mode == "NFOV_2X2BINNED") return {512, 512, 96, 90, 320, 288};
  if (mode == "NFOV_UNBINNED") return {1024, 1024, 192, 180, 640, 576};
  if (mode == "WFOV_2X2BINNED") return {512, 512, 0, 0, 512, 512};
  if (mode == "WFOV_UNBINNED") return {1024, 1024, 0, 0, 1024, 1024};
  throw Error(fmt::format("the depth mode '{}' is not known", mode), name, kKinectCalibrationAdvice);
}

/// The sensor is of 4:3; modes of 16:9 leave out rows above and below.
Window color_window(int width, int height, const std::string& name) {
  const int full_height = width * 3 / 4;
  if (height != full_height && height * 16 != width * 9)
    throw Error(fmt::format("colour of {}x{} is none of the camera's modes", width, height), name,
                kKinectCalibrationAdvice);
  return {width, full_height, 0, (full_height - height) / 2, width, height};
}

struct Camera {
  Pinhole pinhole;
  Distortion distortion;
  SE3 camera_from_rig;
};

SE3 parse_pose(const json& rt) {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
  for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = rt.at("Rotation").at(static_cast<std::size_t>(i)).get<double>();
  for (int i = 0; i < 3; ++i) translation[i] = rt.at("Translation").at(static_cast<std::size_t>(i)).get<double>();
  return SE3(rotation, translation).normalized();
}

/// The sensor's intrinsics are in units of its sides, from the corner of its first pixel.
Camera parse_camera(const json& entry, const Window& window, const std::string& name) {
  const json& intrinsics = entry.at("Intrinsics");
  const auto model = intrinsics.at("ModelType").get<std::string>();
  if (model != "CALIBRATION_LensDistortionModelBrownConrady")
    throw Error(fmt::format("the lens model '{}' is not known", model), name, kKinectCalibrationAdvice);
  std::array<double, 14> m{};  // cx cy fx fy k1 … k6 codx cody p2 p1
  for (std::size_t i = 0; i < m.size(); ++i) m[i] = intrinsics.at("ModelParameters").at(i).get<double>();
  if (m[10] != 0 || m[11] != 0)
    throw Error("the centre of the lens distortion is not the principal point", name, kKinectCalibrationAdvice);
  Camera camera;
  camera.pinhole = {static_cast<float>(m[2] * window.full_width),
                    static_cast<float>(m[3] * window.full_height),
                    static_cast<float>(m[0] * window.full_width - window.left - 0.5),
                    static_cast<float>(m[1] * window.full_height - window.top - 0.5),
                    window.width,
                    window.height};
  camera.distortion = {m[4], m[5], m[13], m[12], m[6], m[7], m[8], m[9]};
  camera.camera_from_rig = parse_pose(entry.at("Rt"));
  if (!camera.pinhole.is_valid() || !camera.camera_from_rig.is_finite())
    throw Error("the calibration's numbers are not those of a camera", name, kKinectCalibrationAdvice);
  return camera;
}

const json& entry_with(const json& list, const char* key, std::string_view value, const std::string& name) {
  for (const json& entry : list)
    if (entry.value(key, "") == value) return entry;
  throw Error(fmt::format("the calibration has no {}", value), name, kKinectCalibrationAdvice);
}

KinectCalibration parse(const json& calibration, const Window& depth_view, int color_width, int color_height,
                        const std::string& name) {
  const json& information = calibration.at("CalibrationInformation");
  const json& cameras = information.at("Cameras");
  KinectCalibration result;
  const Camera depth =
      parse_camera(entry_with(cameras, "Location", "CALIBRATION_CameraLocationD0", name), depth_view, name);
  result.depth = depth.pinhole;
  result.depth_distortion = depth.distortion;
  if (color_width > 0) {
    const Camera color = parse_camera(entry_with(cameras, "Location", "CALIBRATION_CameraLocationPV0", name),
                                      color_window(color_width, color_height, name), name);
    result.color = color.pinhole;
    result.color_distortion = color.distortion;
    result.color_from_depth = color.camera_from_rig * depth.camera_from_rig.inverse();
  }
  for (const json& sensor : information.value("InertialSensors", json::array()))
    if (sensor.value("SensorType", "") == "CALIBRATION_InertialSensorType_Accelerometer")
      result.body_from_depth = (parse_pose(sensor.at("Rt")) * depth.camera_from_rig.inverse()).rotation();
  return result;
}

}  // namespace

KinectCalibration parse_kinect_calibration(std::string_view text, std::string_view depth_mode, int depth_width,
                                           int depth_height, int color_width, int color_height,
                                           const std::string& name) {
  const Window view = depth_window(depth_mode, name);
  if (view.width != depth_width || view.height != depth_height)
    throw Error(fmt::format("the depth images are {}x{}, and those of the mode {} {}x{}", depth_width, depth_height,
                            depth_mode, view.width, view.height),
                name, kKinectCalibrationAdvice);
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);  // the recorder attaches a C string
  try {
    return parse(json::parse(text), view, color_width, color_height, name);
  } catch (const json::exception& error) {
    throw Error(fmt::format("the attached calibration cannot be read ({})", error.what()), name,
                kKinectCalibrationAdvice);
  }
}

}  // namespace plumbline
