// What the parts of the Python module share: NumPy arrays in and out, and the objects that several parts make.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/frame.h"
#include "plumbline/imu.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"

namespace plumbline::python {

namespace py = pybind11;

using Path = std::filesystem::path;  ///< str or os.PathLike in Python

/// A view of memory that `owner` keeps alive; nothing is copied.
template <class T>
py::array_t<T> view(const T* data, std::vector<py::ssize_t> shape, const py::object& owner) {
  return py::array_t<T>(std::move(shape), data, owner);
}

py::array_t<double> to_array(const SE3& pose);                    ///< (4, 4)
py::array_t<double> to_array(const Eigen::Matrix3d& matrix);      ///< (3, 3)
py::array_t<double> to_array(const std::vector<ImuSample>& imu);  ///< (N, 7): seconds, rad/s, m/s²

// These throw ValueError, with the argument's name, for another shape, values that are not finite, and rotations that
// are none. Any array of numbers will do.
SE3 pose_of(const py::object& matrix, const char* name);                    ///< (4, 4)
Eigen::Matrix3d rotation_of(const py::object& rotation, const char* name);  ///< (3, 3), or (4,): x y z w
std::vector<ImuSample> imu_of(const py::object& readings, const char* name);

/// Seconds as a float or int, or nanoseconds as an int; one of the two. Throws ValueError.
Nanoseconds time_of(const py::object& seconds, const py::object& nanoseconds);

/// A trajectory that Python holds. The arrays that it gives are copies: poses are not kept as matrices.
struct PyTrajectory {
  Trajectory poses;
};

// Each adds its part of the module.
void add_parameters(py::module_& m);
void add_values(py::module_& m);  // camera, mesh, map, trajectory, frame, report
void add_pipeline(py::module_& m);
void add_sequences(py::module_& m);  // sequences, run, simulate
void add_measures(py::module_& m);   // evaluate, calibrate

}  // namespace plumbline::python
