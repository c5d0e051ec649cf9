#include <cmath>
#include <string>

#include "bindings.h"
#include "plumbline/time.h"

namespace plumbline::python {
namespace {

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return text + ")";
}

/// Finite numbers of whatever type NumPy makes numbers of.
Doubles numbers(const py::object& object, const char* name) {
  const Doubles array = Doubles::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + ": is no array of numbers");
  }
  for (py::ssize_t i = 0; i < array.size(); ++i)
    if (!std::isfinite(array.data()[i])) throw py::value_error(std::string(name) + ": a value is not finite");
  return array;
}

[[noreturn]] void fail_shape(const char* name, const char* wanted, const py::array& array) {
  throw py::value_error(std::string(name) + ": has the shape " + shape_text(array) + " where " + wanted +
                        " is expected");
}

Eigen::Matrix3d checked(const Eigen::Matrix3d& rotation, const char* name) {
  constexpr double kRounding = 1e-3;
  if (!(rotation * rotation.transpose()).isIdentity(kRounding) || rotation.determinant() < 0)
    throw py::value_error(std::string(name) + ": is no rotation");
  return Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
}

}  // namespace

py::array_t<double> to_array(const SE3& pose) {
  py::array_t<double> array({4, 4});
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(array.mutable_data());
  matrix.setIdentity();
  matrix.topLeftCorner<3, 3>() = pose.rotation();
  matrix.topRightCorner<3, 1>() = pose.translation();
  return array;
}

py::array_t<double> to_array(const Eigen::Matrix3d& matrix) {
  py::array_t<double> array({3, 3});
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(array.mutable_data()) = matrix;
  return array;
}

py::array_t<double> to_array(const std::vector<ImuSample>& imu) {
  py::array_t<double> array({static_cast<py::ssize_t>(imu.size()), py::ssize_t{7}});
  double* row = array.mutable_data();
  for (const ImuSample& sample : imu) {
    *row++ = to_seconds(sample.time);
    for (int axis = 0; axis < 3; ++axis) *row++ = sample.angular_rate[axis];
    for (int axis = 0; axis < 3; ++axis) *row++ = sample.specific_force[axis];
  }
  return array;
}

SE3 pose_of(const py::object& matrix, const char* name) {
  const Doubles array = numbers(matrix, name);
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4) fail_shape(name, "(4, 4)", array);
  const Eigen::Matrix4d m = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(array.data());
  if (!m.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1)))
    throw py::value_error(std::string(name) + ": its last row is not 0 0 0 1");
  return {checked(m.topLeftCorner<3, 3>(), name), m.topRightCorner<3, 1>()};
}

Eigen::Matrix3d rotation_of(const py::object& rotation, const char* name) {
  const Doubles array = numbers(rotation, name);
  if (array.ndim() == 1 && array.shape(0) == 4) {
    const Eigen::Quaterniond q(array.data()[3], array.data()[0], array.data()[1], array.data()[2]);
    if (std::abs(q.norm() - 1) > 0.01) throw py::value_error(std::string(name) + ": the quaternion's length is not 1");
    return q.normalized().toRotationMatrix();
  }
  if (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 3) fail_shape(name, "(3, 3) or (4,)", array);
  return checked(Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(array.data()), name);
}

std::vector<ImuSample> imu_of(const py::object& readings, const char* name) {
  const Doubles array = numbers(readings, name);
  if (array.ndim() != 2 || array.shape(1) != 7) fail_shape(name, "(N, 7)", array);
  std::vector<ImuSample> samples(static_cast<std::size_t>(array.shape(0)));
  const double* row = array.data();
  for (ImuSample& sample : samples) {
    sample.time = from_seconds(row[0]);
    sample.angular_rate = {row[1], row[2], row[3]};
    sample.specific_force = {row[4], row[5], row[6]};
    if (&sample != samples.data() && sample.time <= (&sample - 1)->time)
      throw py::value_error(std::string(name) + ": the times do not ascend");
    row += 7;
  }
  return samples;
}

Nanoseconds time_of(const py::object& seconds, const py::object& nanoseconds) {
  if (seconds.is_none() == nanoseconds.is_none()) throw py::value_error("give one of time (s) and time_ns");
  if (!nanoseconds.is_none()) return nanoseconds.cast<Nanoseconds>();
  const auto s = seconds.cast<double>();
  if (!(std::abs(s) < 9e9)) throw py::value_error("time: is not a finite number of seconds");
  return from_seconds(s);
}

}  // namespace plumbline::python
