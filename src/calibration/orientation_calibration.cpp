#include "plumbline/orientation_calibration.h"

#include <fmt/format.h>

#include <cmath>

#include "calibration/calibration_text.h"
#include "io/atomic_file.h"
#include "io/calibration_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"

namespace plumbline {
void write_orientation_calibration(const std::string& path, const OrientationCalibration& c,
                                   const std::vector<std::string>& comments) {
  std::string text;
  for (const std::string& comment : comments) text += "# " + comment + "\n";
  const Eigen::Quaterniond q(c.body_from_camera);
  const Eigen::Vector3d sd = c.mounting_sd / kRadiansPerDegree;
  text += fmt::format(
      "\n[mounting]\nbody_from_camera = [{:.9f}, {:.9f}, {:.9f}, {:.9f}]  # qx qy qz qw\n"
      "sd_deg = [{:.4f}, {:.4f}, {:.4f}]  # about the camera's axes x, y, z\n"
      "\n[time]\noffset = {:.6f}  # s, added to the sensor's stamps\nsd = {:.6f}  # s\n"
      "\n[readings]\nquaternion = \"{}\"\norientation_of = \"{}\"\nearth = \"{}\"\n",
      q.x(), q.y(), q.z(), q.w(), sd.x(), sd.y(), sd.z(), c.time_offset, c.time_offset_sd,
      name_of(c.convention.quaternion.value_or(QuaternionOrder::xyzw)), name_of(c.convention.orientation_of),
      name_of(c.convention.earth));
  write_file(path, text);
}

OrientationCalibration read_orientation_calibration(const std::string& path) {
  const CalibrationFile reader(path);
  OrientationCalibration c;
  const std::vector<double> q = reader.numbers("mounting.body_from_camera", 4, 1.01);
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (std::abs(rotation.norm() - 1) > 0.01)
    throw Error("mounting.body_from_camera is no unit quaternion", path, CalibrationFile::kAdvice);
  c.body_from_camera = rotation.normalized().toRotationMatrix();
  const std::vector<double> sd = reader.numbers("mounting.sd_deg", 3, 360);
  c.mounting_sd = kRadiansPerDegree * Eigen::Vector3d(sd[0], sd[1], sd[2]);
  c.time_offset = reader.numbers("time.offset", 1, 1e9)[0];
  c.time_offset_sd = reader.numbers("time.sd", 1, 1e9)[0];
  c.convention.quaternion = reader.choice<QuaternionOrder>("readings.quaternion");
  c.convention.orientation_of = reader.choice<OrientationOf>("readings.orientation_of");
  c.convention.earth = reader.choice<EarthAxes>("readings.earth");
  return c;
}

}  // namespace plumbline
