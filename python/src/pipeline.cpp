// The pipeline: frames in as NumPy arrays, poses and surface out.
#include "plumbline/pipeline.h"

#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings.h"
#include "plumbline/backend.h"
#include "plumbline/error.h"

namespace plumbline::python {
namespace {

/// Keeps what its pipeline needs. Python threads may call it at the same time: they wait for one another.
class PyPipeline {
 public:
  PyPipeline(const Parameters& parameters, const Pinhole& camera, double depth_scale, bool color,
             const std::string& backend, int threads, const SE3& initial_pose, const OrientationSensor& sensor)
      : camera_(camera),
        depth_scale_(depth_scale),
        with_color_(color),
        backend_(make_backend(backend, threads)),
        pipeline_(std::make_unique<Pipeline>(parameters, camera, *backend_, initial_pose, color, sensor)) {}

  FrameReport process(const Frame& frame) {
    const std::lock_guard lock(mutex_);
    frames_ = frame.index + 1;
    return pipeline_->process(frame);
  }
  template <class Get>
  auto locked(const Get& get) const {
    const std::lock_guard lock(mutex_);
    return get(*pipeline_);
  }

  // Frames whose memory is used again: fresh pages cost more than what is copied into them. With the GIL.
  Frame take_spare() {
    if (spare_.empty()) return {};
    Frame frame = std::move(spare_.back());
    spare_.pop_back();
    return frame;
  }
  void give_back(Frame frame) { spare_.push_back(std::move(frame)); }

  const Pinhole& camera() const { return camera_; }
  double depth_scale() const { return depth_scale_; }
  bool with_color() const { return with_color_; }
  int frames() const { return frames_; }

 private:
  Pinhole camera_;
  double depth_scale_;
  bool with_color_;
  std::shared_ptr<Backend> backend_;
  std::unique_ptr<Pipeline> pipeline_;
  int frames_ = 0;
  std::vector<Frame> spare_;
  mutable std::mutex mutex_;
};

void check_shape(const py::array& image, const char* name, const Pinhole& camera, int channels) {
  const bool is_image = image.ndim() == (channels == 1 ? 2 : 3) && image.shape(0) == camera.height &&
                        image.shape(1) == camera.width && (channels == 1 || image.shape(2) == channels);
  if (is_image) return;
  std::string shape;
  for (py::ssize_t i = 0; i < image.ndim(); ++i) shape += (i > 0 ? ", " : "") + std::to_string(image.shape(i));
  throw py::value_error(std::string(name) + ": has the shape (" + shape + ") where (" + std::to_string(camera.height) +
                        ", " + std::to_string(camera.width) + (channels == 1 ? ")" : ", 3)") +
                        " of the camera is expected");
}

/// Of an array, however it is laid out, into an image whose memory is used again.
template <class T>
void copy(const py::array& array, const Pinhole& camera, int channels, Image<T>* image) {
  const auto plain = py::array_t<T, py::array::c_style>::ensure(array);
  if (!plain) throw py::error_already_set();
  image->width = camera.width;
  image->height = camera.height;
  image->channels = channels;
  image->pixels.assign(plain.data(), plain.data() + plain.size());
}

void set_depth(const py::array& depth, const PyPipeline& pipeline, Frame* frame) {
  const bool is_float = py::isinstance<py::array_t<float>>(depth);
  if (!is_float && !py::isinstance<py::array_t<std::uint16_t>>(depth))
    throw py::type_error("depth: is an array of " + py::str(depth.dtype()).cast<std::string>() +
                         " where uint16 (readings) or float32 (metres) is expected");
  check_shape(depth, "depth", pipeline.camera(), 1);
  frame->depth_scale = pipeline.depth_scale();
  if (!is_float) return copy(depth, pipeline.camera(), 1, &frame->depth);
  Image<float> metres;
  copy(depth, pipeline.camera(), 1, &metres);
  frame->depth = readings_of(metres, pipeline.depth_scale());
}

void set_color(const py::object& color, const PyPipeline& pipeline, Frame* frame) {
  if (color.is_none()) {
    frame->color = {};
    return;
  }
  if (!py::isinstance<py::array_t<std::uint8_t>>(color)) throw py::type_error("color: is no array of uint8");
  const py::array array = color.cast<py::array>();
  check_shape(array, "color", pipeline.camera(), 3);
  copy(array, pipeline.camera(), 3, &frame->color);
}

FrameReport process(PyPipeline& self, const py::array& depth, const py::object& time, const py::object& color,
                    const py::object& orientation, const py::object& imu, const py::object& time_ns) {
  Frame frame = self.take_spare();
  frame.index = self.frames();
  frame.time = time_of(time, time_ns);
  set_depth(depth, self, &frame);
  set_color(color, self, &frame);
  frame.earth_from_camera.reset();
  if (!orientation.is_none()) frame.earth_from_camera = rotation_of(orientation, "orientation");
  frame.inertial.clear();
  if (!imu.is_none()) frame.inertial = imu_of(imu, "imu");
  FrameReport report;
  {
    const py::gil_scoped_release release;
    report = self.process(frame);
  }
  self.give_back(std::move(frame));
  return report;
}

FrameReport process_frame(PyPipeline& self, const std::shared_ptr<Frame>& frame) {
  const py::gil_scoped_release release;
  return self.process(*frame);
}

OrientationSensor sensor_of(bool has_heading, const py::object& covariance) {
  OrientationSensor sensor;
  sensor.has_heading = has_heading;
  if (covariance.is_none()) return sensor;
  const auto matrix = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(covariance);
  if (!matrix || matrix.ndim() != 2 || matrix.shape(0) != 3 || matrix.shape(1) != 3) {
    PyErr_Clear();
    throw py::value_error("orientation_covariance: is no array of shape (3, 3)");
  }
  sensor.covariance = Eigen::Map<const Eigen::Matrix3d>(matrix.data()).transpose();
  return sensor;
}

std::unique_ptr<PyPipeline> make(const std::optional<Parameters>& parameters, const Pinhole& camera, double depth_scale,
                                 bool color, const std::string& backend, int threads, const py::object& initial_pose,
                                 bool has_heading, const py::object& covariance) {
  if (!(depth_scale > 0) || !std::isfinite(depth_scale)) throw py::value_error("depth_scale: is not greater than 0");
  if (threads < 0) throw py::value_error("threads: is less than 0");
  const SE3 pose = initial_pose.is_none() ? SE3() : pose_of(initial_pose, "initial_pose");
  const OrientationSensor sensor = sensor_of(has_heading, covariance);
  const py::gil_scoped_release release;
  return std::make_unique<PyPipeline>(parameters.value_or(Parameters()), camera, depth_scale, color, backend, threads,
                                      pose, sensor);
}

constexpr const char* kProcess =
    "Tracks a frame, fuses it and predicts the next one. A frame that cannot be tracked is no error but a status in "
    "the "
    "report; it is not fused.\n\n"
    "depth: (H, W) uint16, readings of depth_scale a metre, or float32, metres; 0 and NaN: none.\n"
    "time: seconds; or time_ns: nanoseconds.\n"
    "color: (H, W, 3) uint8, red green blue, registered to the depth.\n"
    "orientation: earth_from_camera (x east, y north, z up), (3, 3) or a quaternion (x, y, z, w).\n"
    "imu: (N, 7) float64 of a gyroscope and an accelerometer since the previous frame: seconds, rad/s, m/s^2 (at rest "
    "9.8 upwards), camera axes, times ascending.";

}  // namespace

void add_pipeline(py::module_& m) {
  py::class_<PyPipeline>(m, "Pipeline",
                         "One reconstruction. The world is the first camera's frame. Calls release the GIL; those of "
                         "several threads to one pipeline wait for one another.")
      .def(py::init(&make), py::arg("parameters"), py::arg("camera"), py::kw_only(), py::arg("depth_scale") = 1000.0,
           py::arg("color") = false, py::arg("backend") = "auto", py::arg("threads") = 0,
           py::arg("initial_pose") = py::none(), py::arg("has_heading") = true,
           py::arg("orientation_covariance") = py::none(),
           "parameters: None takes the preset plumbline. depth_scale: readings a metre of uint16 depth (1000: "
           "millimetres). color: fuse it. threads: 0 takes all; never changes a result. initial_pose: (4, 4) "
           "world_from_camera of the first frame. has_heading: False where the orientation is a tilt only. "
           "orientation_covariance: (3, 3) rad^2 about east, north, up.")
      .def("process", &process, py::arg("depth"), py::arg("time") = py::none(), py::arg("color") = py::none(),
           py::arg("orientation") = py::none(), py::arg("imu") = py::none(), py::kw_only(),
           py::arg("time_ns") = py::none(), kProcess)
      .def("process", &process_frame, py::arg("frame"), "A frame of a sequence, with all that it carries.")
      .def(
          "mesh",
          [](const PyPipeline& self) { return self.locked([](const Pipeline& p) { return p.extract_mesh(); }); },
          py::call_guard<py::gil_scoped_release>(),
          "The surface so far, world frame, metres; costs a pass over all bricks with a surface.")
      .def(
          "map", [](const PyPipeline& self) { return self.locked([](const Pipeline& p) { return p.extract_map(); }); },
          py::call_guard<py::gil_scoped_release>(), "The signed distances so far: 3 KiB for each brick with a surface.")
      .def_property_readonly(
          "world_from_camera",
          [](const PyPipeline& self) {
            return to_array(self.locked([](const Pipeline& p) { return p.world_from_camera(); }));
          },
          "(4, 4) float64, of the latest accepted frame")
      .def_property_readonly(
          "world_from_volume",
          [](const PyPipeline& self) {
            return to_array(self.locked([](const Pipeline& p) { return p.world_from_volume(); }));
          },
          "(4, 4) float64, of the volume's lowest corner; set with the first frame")
      .def_property_readonly(
          "volume_side",
          [](const PyPipeline& self) { return self.locked([](const Pipeline& p) { return p.volume_side(); }); },
          "metres")
      .def_property_readonly("camera", &PyPipeline::camera);
  m.def(
      "backends",
      [] {
        py::dict names;
        for (const BackendInfo& info : list_backends()) names[py::str(info.name)] = info.available;
        return names;
      },
      "What can compute here: name to whether it is available.");
}

}  // namespace plumbline::python
