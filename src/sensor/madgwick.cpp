#include "sensor/madgwick.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <optional>

#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/time.h"
#include "sensor/measured.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;

/// Up and north of one reading; without a field the heading is arbitrary.
Quaterniond first_orientation(const ImuSample& r) {
  const Vector3d up = r.specific_force.normalized();
  const Vector3d towards = is_measured(r.magnetic_field) ? *r.magnetic_field : up.unitOrthogonal();
  const Vector3d east = towards.cross(up).normalized();
  Matrix3d earth_from_body;
  earth_from_body << east.transpose(), up.cross(east).transpose(), up.transpose();
  return Quaterniond(earth_from_body);
}

/// Gradient, over the four numbers (w, x, y, z), of ½‖body_from_earth(q) direction − measured‖² (their equations 15 to
/// 22, without expanding them for each direction). With d in the earth: q⁻¹ d q has the derivative 2 (d q) in each
/// component of q on the sphere.
Vector4d gradient(const Quaterniond& earth_from_body, const Vector3d& direction, const Vector3d& measured) {
  const Vector3d error = earth_from_body.conjugate() * direction - measured;
  const double w = earth_from_body.w(), x = earth_from_body.x(), y = earth_from_body.y(), z = earth_from_body.z();
  const double dx = direction.x(), dy = direction.y(), dz = direction.z();
  Eigen::Matrix<double, 3, 4> jacobian;
  jacobian << w * dx + z * dy - y * dz, x * dx + y * dy + z * dz, -y * dx + x * dy - w * dz, -z * dx + w * dy + x * dz,
      w * dy - z * dx + x * dz, y * dx - x * dy + w * dz, x * dx + y * dy + z * dz, -w * dx - z * dy + y * dz,
      w * dz + y * dx - x * dy, z * dx - w * dy - x * dz, w * dx + z * dy - y * dz, x * dx + y * dy + z * dz;
  return 2 * jacobian.transpose() * error;
}

/// One step (their equations 12, 13, 33, 42 to 45).
Quaterniond step(const Quaterniond& q, const ImuSample& r, double seconds, double gain) {
  const Quaterniond rate(0, r.angular_rate.x(), r.angular_rate.y(), r.angular_rate.z());
  const Quaterniond product = q * rate;
  Vector4d change = 0.5 * Vector4d(product.w(), product.x(), product.y(), product.z());
  if (is_measured(r.specific_force)) {
    Vector4d slope = gradient(q, Vector3d::UnitZ(), r.specific_force.normalized());
    if (is_measured(r.magnetic_field)) {
      const Vector3d field = r.magnetic_field->normalized(), h = q * field;
      slope += gradient(q, Vector3d(0, std::hypot(h.x(), h.y()), h.z()), field);
    }
    if (slope.norm() > 0) change -= gain * slope.normalized();
  }
  change *= seconds;
  return Quaterniond(q.w() + change[0], q.x() + change[1], q.y() + change[2], q.z() + change[3]).normalized();
}

}  // namespace

std::vector<OrientationSample> madgwick_orientation(const ImuRecording& recording, double gain) {
  if (!recording.has_gyroscope || recording.samples.empty())
    throw Error("there is no gyroscope in the readings", "Madgwick filter", "give gyroscope and accelerometer");
  std::vector<OrientationSample> samples;
  Quaterniond q = first_orientation(recording.samples.front());
  Nanoseconds previous = recording.samples.front().time;
  for (const ImuSample& reading : recording.samples) {
    q = step(q, reading, to_seconds(reading.time - previous), gain);
    previous = reading.time;
    samples.push_back({reading.time, q.toRotationMatrix()});
  }
  return samples;
}

}  // namespace plumbline
