// Cameras, meshes, maps, trajectories, frames and reports.
#include <algorithm>
#include <string>

#include "bindings.h"
#include "plumbline/files.h"
#include "plumbline/map.h"
#include "plumbline/pinhole.h"
#include "plumbline/pipeline.h"
#include "plumbline/time.h"
#include "plumbline/tracking.h"

namespace plumbline::python {
namespace {

py::ssize_t count(std::size_t n) { return static_cast<py::ssize_t>(n); }

void add_camera(py::module_& m) {
  py::class_<Pinhole>(m, "Camera",
                      "A pinhole camera: x right, y down, z forward; pixel (0, 0) is the centre of the top left one.")
      .def(py::init([](float fx, float fy, float cx, float cy, int width, int height) {
             const Pinhole camera{fx, fy, cx, cy, width, height};
             if (!camera.is_valid()) throw py::value_error("Camera: needs finite numbers, fx > 0, fy != 0, and pixels");
             return camera;
           }),
           py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"), py::arg("width"), py::arg("height"),
           "Intrinsics in pixels.")
      .def_readonly("fx", &Pinhole::fx, "pixels")
      .def_readonly("fy", &Pinhole::fy, "pixels")
      .def_readonly("cx", &Pinhole::cx, "pixels")
      .def_readonly("cy", &Pinhole::cy, "pixels")
      .def_readonly("width", &Pinhole::width, "pixels")
      .def_readonly("height", &Pinhole::height, "pixels")
      .def("__eq__", [](const Pinhole& a, const Pinhole& b) { return a == b; })
      .def("__repr__", [](const Pinhole& k) {
        return "plumbline.Camera(fx=" + std::to_string(k.fx) + ", fy=" + std::to_string(k.fy) +
               ", cx=" + std::to_string(k.cx) + ", cy=" + std::to_string(k.cy) + ", width=" + std::to_string(k.width) +
               ", height=" + std::to_string(k.height) + ")";
      });
}

template <class Element, class Value>
auto rows(std::vector<Element> Mesh::*list) {
  return [list](const py::object& self) {
    auto& elements = self.cast<Mesh&>().*list;
    static_assert(sizeof(Element) == 3 * sizeof(Value));
    return view(reinterpret_cast<const Value*>(elements.data()), {count(elements.size()), 3}, self);
  };
}

/// From arrays, which are copied.
template <class Value, class Element>
void fill(const py::object& array, const char* name, std::vector<Element>* list) {
  if (array.is_none()) return;
  const auto values = py::array_t<Value, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!values || values.ndim() != 2 || values.shape(1) != 3) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + ": is no array of shape (N, 3)");
  }
  list->resize(static_cast<std::size_t>(values.shape(0)));
  std::copy(values.data(), values.data() + values.size(), reinterpret_cast<Value*>(list->data()));
}

void add_mesh(py::module_& m) {
  py::class_<Mesh>(m, "Mesh",
                   "A triangle mesh in metres, world frame. Its arrays are views of its memory, which they keep alive.")
      .def(py::init([](const py::object& vertices, const py::object& triangles, const py::object& normals,
                       const py::object& colors) {
             Mesh mesh;
             fill<float>(vertices, "vertices", &mesh.positions);
             fill<std::uint32_t>(triangles, "triangles", &mesh.triangles);
             fill<float>(normals, "normals", &mesh.normals);
             fill<std::uint8_t>(colors, "colors", &mesh.colors);
             return mesh;
           }),
           py::arg("vertices"), py::arg("triangles"), py::arg("normals") = py::none(), py::arg("colors") = py::none(),
           "From arrays of shape (N, 3), which are copied.")
      .def_property_readonly("vertices", rows<Mesh::Float3, float>(&Mesh::positions), "(N, 3) float32, metres")
      .def_property_readonly("normals", rows<Mesh::Float3, float>(&Mesh::normals),
                             "(N, 3) float32 of length 1, or (0, 3)")
      .def_property_readonly("colors", rows<Mesh::Rgb, std::uint8_t>(&Mesh::colors),
                             "(N, 3) uint8, red green blue, or (0, 3)")
      .def_property_readonly("triangles", rows<Mesh::Triangle, std::uint32_t>(&Mesh::triangles),
                             "(M, 3) uint32, counter-clockwise seen from the free side")
      .def(
          "save", [](const Mesh& self, const Path& path) { write_mesh(path.string(), self); }, py::arg("path"),
          py::call_guard<py::gil_scoped_release>(), "Writes a .ply or .obj file.")
      .def_static(
          "load", [](const Path& path) { return read_mesh(path.string()); }, py::arg("path"),
          py::call_guard<py::gil_scoped_release>(), "Reads a .ply or .obj file.")
      .def("__repr__", [](const Mesh& self) {
        return "<plumbline.Mesh of " + std::to_string(self.positions.size()) + " vertices, " +
               std::to_string(self.triangles.size()) + " triangles>";
      });
}

void add_map(py::module_& m) {
  py::class_<Map>(m, "Map",
                  "A truncated signed distance in bricks of 8x8x8 voxels; voxel (i, j, k) is centred at (i + 0.5, j + "
                  "0.5, k + 0.5) * voxel_size in the map's frame. Arrays are views, which keep it alive.")
      .def_readonly("voxel_size", &Map::voxel_size, "metres")
      .def_readonly("truncation", &Map::truncation, "metres")
      .def_property_readonly(
          "world_from_map", [](const Map& self) { return to_array(self.world_from_map); }, "(4, 4)")
      .def_property_readonly(
          "bricks",
          [](const py::object& self) {
            const auto& bricks = self.cast<const Map&>().bricks;
            return view(reinterpret_cast<const std::int32_t*>(bricks.data()), {count(bricks.size()), 3}, self);
          },
          "(B, 3) int32: x, y, z of each brick's lowest voxel")
      .def_property_readonly(
          "distances",
          [](const py::object& self) {
            const auto& map = self.cast<const Map&>();
            return view(map.distances.data(), {count(map.bricks.size()), 8, 8, 8}, self);
          },
          "(B, 8, 8, 8) float32, [brick, z, y, x], metres, positive on the free side")
      .def_property_readonly(
          "weights",
          [](const py::object& self) {
            const auto& map = self.cast<const Map&>();
            return view(map.weights.data(), {count(map.bricks.size()), 8, 8, 8}, self);
          },
          "(B, 8, 8, 8) uint16, [brick, z, y, x]; 0: never seen, and the distance is 0");
}

Trajectory trajectory_of(const py::object& times, const py::object& poses) {
  Trajectory trajectory;
  const py::sequence time_list = times, pose_list = poses;
  if (time_list.size() != pose_list.size()) throw py::value_error("Trajectory: there are not as many times as poses");
  for (std::size_t i = 0; i < time_list.size(); ++i)
    trajectory.push_back({time_of(time_list[i], py::none()), pose_of(pose_list[i], "poses")});
  return trajectory;
}

void add_trajectory(py::module_& m) {
  py::class_<PyTrajectory>(m, "Trajectory", "Poses of the camera, ordered by time.")
      .def(py::init([](const py::object& times, const py::object& poses) {
             return PyTrajectory{trajectory_of(times, poses)};
           }),
           py::arg("times"), py::arg("poses"), "times: (N,) seconds; poses: (N, 4, 4) world_from_camera.")
      .def_property_readonly(
          "times",
          [](const PyTrajectory& self) {
            py::array_t<double> times(count(self.poses.size()));
            for (std::size_t i = 0; i < self.poses.size(); ++i)
              times.mutable_data()[i] = to_seconds(self.poses[i].time);
            return times;
          },
          "(N,) float64, seconds")
      .def_property_readonly(
          "times_ns",
          [](const PyTrajectory& self) {
            py::array_t<std::int64_t> times(count(self.poses.size()));
            for (std::size_t i = 0; i < self.poses.size(); ++i) times.mutable_data()[i] = self.poses[i].time;
            return times;
          },
          "(N,) int64, nanoseconds")
      .def_property_readonly(
          "poses",
          [](const PyTrajectory& self) {
            py::array_t<double> poses({count(self.poses.size()), py::ssize_t{4}, py::ssize_t{4}});
            double* to = poses.mutable_data();
            for (const StampedPose& pose : self.poses) {
              const py::array_t<double> matrix = to_array(pose.world_from_camera);
              to = std::copy(matrix.data(), matrix.data() + 16, to);
            }
            return poses;
          },
          "(N, 4, 4) float64, world_from_camera, metres")
      .def(
          "save", [](const PyTrajectory& self, const Path& path) { write_tum_trajectory(path.string(), self.poses); },
          py::arg("path"), "Writes TUM's format: t tx ty tz qx qy qz qw a line.")
      .def_static(
          "load", [](const Path& path) { return PyTrajectory{read_trajectory(path.string())}; }, py::arg("path"),
          "Reads TUM's format and others: see docs/cli.md, eval.")
      .def("__len__", [](const PyTrajectory& self) { return self.poses.size(); })
      .def("__repr__", [](const PyTrajectory& self) {
        return "<plumbline.Trajectory of " + std::to_string(self.poses.size()) + " poses>";
      });
}

void add_frame(py::module_& m) {
  py::class_<Frame, std::shared_ptr<Frame>>(m, "Frame",
                                            "One depth image of a sequence. Arrays are views, which keep it alive.")
      .def_readonly("index", &Frame::index, "Position in the sequence, from 0.")
      .def_property_readonly(
          "time", [](const Frame& self) { return to_seconds(self.time); }, "seconds")
      .def_readonly("time_ns", &Frame::time, "nanoseconds")
      .def_readonly("depth_scale", &Frame::depth_scale, "Readings of `depth` a metre.")
      .def_property_readonly(
          "depth",
          [](const py::object& self) {
            const DepthImage& depth = self.cast<const Frame&>().depth;
            return view(depth.pixels.data(), {depth.height, depth.width}, self);
          },
          "(H, W) uint16, readings; 0: none")
      .def_property_readonly(
          "color",
          [](const py::object& self) -> py::object {
            const ColorImage& color = self.cast<const Frame&>().color;
            if (color.empty()) return py::none();
            return view(color.pixels.data(), {color.height, color.width, 3}, self);
          },
          "(H, W, 3) uint8, red green blue, registered to `depth`; or None")
      .def_property_readonly(
          "orientation",
          [](const Frame& self) -> py::object {
            if (!self.earth_from_camera) return py::none();
            return to_array(*self.earth_from_camera);
          },
          "(3, 3) float64, earth_from_camera (x east, y north, z up); or None")
      .def_property_readonly(
          "imu", [](const Frame& self) { return to_array(self.inertial); },
          "(N, 7) float64: seconds, rad/s, m/s^2, camera axes");
}

void add_report(py::module_& m) {
  const auto status = [](const FrameReport& r) { return std::string(to_string(r.tracking.status)); };
  py::class_<FrameReport>(m, "FrameReport", "What became of one frame.")
      .def_readonly("index", &FrameReport::index)
      .def_property_readonly(
          "time", [](const FrameReport& r) { return to_seconds(r.time); }, "seconds")
      .def_readonly("time_ns", &FrameReport::time, "nanoseconds")
      .def_property_readonly("status", status, "initialised, tracked, provisional or lost")
      .def_property_readonly(
          "has_pose", [](const FrameReport& r) { return has_pose(r.tracking.status); },
          "Whether it was tracked (or was the first), and fused.")
      .def_property_readonly(
          "reason", [](const FrameReport& r) { return std::string(to_string(r.tracking.reason)); },
          "Why it was lost; empty if it was not.")
      .def_property_readonly(
          "world_from_camera", [](const FrameReport& r) { return to_array(r.world_from_camera); },
          "(4, 4) float64; for a lost frame the previous accepted pose")
      .def_property_readonly(
          "pose_covariance",
          [](const FrameReport& r) {
            py::array_t<double> matrix({6, 6});
            Eigen::Map<Matrix6d>(matrix.mutable_data()) = r.tracking.pose_covariance;  // symmetric
            return matrix;
          },
          "(6, 6) float64 of (rotation, translation), world axes, rad^2 and m^2")
      .def_property_readonly(
          "iterations", [](const FrameReport& r) { return r.tracking.iterations; },
          "Of each pyramid level, coarse to fine.")
      .def_property_readonly(
          "inliers", [](const FrameReport& r) { return r.tracking.inliers; }, "Matched pixels.")
      .def_property_readonly(
          "inlier_fraction", [](const FrameReport& r) { return r.tracking.inlier_fraction; },
          "Of the pixels with depth.")
      .def_property_readonly(
          "rms", [](const FrameReport& r) { return r.tracking.rms; }, "Point-to-plane residual, metres.")
      .def_property_readonly(
          "median_distance", [](const FrameReport& r) { return r.tracking.median_distance; },
          "Of the associated pairs, metres.")
      .def_property_readonly(
          "rank", [](const FrameReport& r) { return r.tracking.rank; },
          "6 where all directions are held by the images.")
      .def_property_readonly(
          "orientation", [](const FrameReport& r) { return std::string(to_string(r.orientation)); },
          "What became of the sensor's reading: off, missing, first, used, distrusted, dropped.")
      .def_readonly("sensor_lateness", &FrameReport::sensor_lateness,
                    "Seconds by which the inertial sensor's stamps are late, as estimated so far.")
      .def_readonly("starts", &FrameReport::starts, "Poses that registration was begun from.")
      .def_readonly("is_recovered", &FrameReport::is_recovered, "Its place was recognised after an interruption.")
      .def_readonly("is_after_interruption", &FrameReport::is_after_interruption,
                    "Nothing linked it to the previous accepted frame.")
      .def_property_readonly(
          "milliseconds",
          [](const FrameReport& r) {
            const StageTimes& ms = r.milliseconds;
            py::dict times;
            times["preprocess"] = ms.preprocess;
            times["track"] = ms.track;
            times["integrate"] = ms.integrate;
            times["raycast"] = ms.raycast;
            times["total"] = ms.total();
            return times;
          },
          "Wall time of each stage.")
      .def("__repr__", [status](const FrameReport& r) {
        return "<plumbline.FrameReport of frame " + std::to_string(r.index) + ": " + status(r) + ">";
      });
}

}  // namespace

void add_values(py::module_& m) {
  add_camera(m);
  add_mesh(m);
  add_map(m);
  add_trajectory(m);
  add_frame(m);
  add_report(m);
}

}  // namespace plumbline::python
