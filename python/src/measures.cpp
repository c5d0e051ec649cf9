// Evaluation and calibration.
#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "bindings.h"
#include "plumbline/calibration.h"
#include "plumbline/evaluation.h"
#include "plumbline/files.h"
#include "plumbline/orientation_calibration.h"
#include "plumbline/reconstruct.h"
#include "plumbline/surface_error.h"

namespace plumbline::python {
namespace {

struct Evaluation {
  eval::AbsoluteError absolute;
  std::optional<eval::RelativeError> relative;
};

Trajectory trajectory_of(const py::object& given) {
  if (py::isinstance<PyTrajectory>(given)) return given.cast<const PyTrajectory&>().poses;
  return read_trajectory(given.cast<Path>().string());
}

Evaluation evaluate(const py::object& reference, const py::object& estimate, double max_difference, double offset,
                    double delta) {
  const Trajectory truth = trajectory_of(reference), poses = trajectory_of(estimate);
  const py::gil_scoped_release release;
  Evaluation result;
  result.absolute = eval::absolute_trajectory_error(truth, poses, {from_seconds(max_difference), from_seconds(offset)});
  if (delta > 0)
    result.relative = eval::relative_trajectory_error(truth, poses, {.delta = delta, .offset = from_seconds(offset)});
  return result;
}

void add_evaluate(py::module_& m) {
  py::class_<eval::Statistics>(m, "Statistics", "The summary of a set of errors, in their unit.")
      .def_readonly("count", &eval::Statistics::count)
      .def_readonly("rmse", &eval::Statistics::rmse)
      .def_readonly("mean", &eval::Statistics::mean)
      .def_readonly("median", &eval::Statistics::median)
      .def_readonly("std", &eval::Statistics::std, "Of the population.")
      .def_readonly("min", &eval::Statistics::min)
      .def_readonly("max", &eval::Statistics::max)
      .def("__repr__", [](const eval::Statistics& s) {
        return "<plumbline.Statistics: rmse " + std::to_string(s.rmse) + ", median " + std::to_string(s.median) +
               ", max " + std::to_string(s.max) + " of " + std::to_string(s.count) + ">";
      });
  py::class_<Evaluation>(m, "Evaluation", "Errors of a trajectory, as the TUM RGB-D benchmark defines them.")
      .def_property_readonly(
          "ate", [](const Evaluation& e) { return e.absolute.translation; },
          "Absolute trajectory error, metres, after the best rigid alignment.")
      .def_property_readonly(
          "reference_from_estimate", [](const Evaluation& e) { return to_array(e.absolute.reference_from_estimate); },
          "(4, 4) float64: that alignment.")
      .def_property_readonly(
          "errors",
          [](const Evaluation& e) {
            py::array_t<double> errors(static_cast<py::ssize_t>(e.absolute.pairs.size()));
            for (std::size_t i = 0; i < e.absolute.pairs.size(); ++i)
              errors.mutable_data()[i] = e.absolute.pairs[i].translation;
            return errors;
          },
          "(N,) float64, metres: of each pair of poses, by the reference's time.")
      .def_property_readonly(
          "rpe_translation",
          [](const Evaluation& e) -> std::optional<eval::Statistics> {
            if (!e.relative) return std::nullopt;
            return e.relative->translation;
          },
          "Relative pose error over `delta`, metres; None without a delta.")
      .def_property_readonly(
          "rpe_rotation",
          [](const Evaluation& e) -> std::optional<eval::Statistics> {
            if (!e.relative) return std::nullopt;
            return e.relative->rotation;
          },
          "The same, radians.");
  m.def("evaluate", &evaluate, py::arg("reference"), py::arg("estimate"), py::kw_only(),
        py::arg("max_difference") = 0.02, py::arg("offset") = 0.0, py::arg("delta") = 0.0,
        "Errors of a trajectory. Both: a Trajectory or a file. max_difference: seconds between two stamps. offset: "
        "seconds added to the estimate's. delta: seconds over which the relative error is taken, 0: it is not.");
}

void add_surface(py::module_& m) {
  py::class_<eval::SurfaceScore>(m, "SurfaceScore", "Fractions at one threshold.")
      .def_readonly("threshold", &eval::SurfaceScore::threshold, "metres")
      .def_readonly("precision", &eval::SurfaceScore::precision)
      .def_readonly("recall", &eval::SurfaceScore::recall)
      .def_readonly("f_score", &eval::SurfaceScore::f_score);
  py::class_<eval::SurfaceError>(m, "SurfaceError", "Distances between two surfaces, metres.")
      .def_readonly("accuracy", &eval::SurfaceError::accuracy, "Reconstruction to reference.")
      .def_readonly("completeness", &eval::SurfaceError::completeness, "Reference to reconstruction.")
      .def_readonly("scores", &eval::SurfaceError::scores);
  m.def(
      "compare_meshes",
      [](const Mesh& mesh, const Mesh& reference, const std::vector<double>& thresholds, std::size_t samples) {
        return eval::compare_meshes(mesh, reference, thresholds, samples);
      },
      py::arg("mesh"), py::arg("reference"), py::kw_only(), py::arg("thresholds") = std::vector<double>{0.01, 0.02},
      py::arg("samples") = std::size_t{200000}, py::call_guard<py::gil_scoped_release>(),
      "Distances in both directions by so many points on each; thresholds in metres. Both in one frame.");
}

/// What was found about a recording.
struct Calibration {
  CameraPath path;
  std::optional<MountingCalibration> mounting;
  OrientationConvention convention;
};

Calibration calibrate(const std::shared_ptr<Sequence>& sequence, const std::optional<Path>& orientation,
                      const std::optional<Parameters>& parameters, int threads) {
  CalibrationOptions options;
  options.parameters = parameters.value_or(Parameters());
  options.threads = threads;
  std::exception_ptr raised;
  options.stopping = [&] {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) raised = std::make_exception_ptr(py::error_already_set());
    return static_cast<bool>(raised);
  };
  std::vector<int> frames(static_cast<std::size_t>(sequence->size()));
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i] = static_cast<int>(i);
  const py::gil_scoped_release release;
  Calibration result;
  try {
    const std::optional<SensorReadings> sensor =
        orientation ? std::optional(read_sensor(orientation->string())) : std::nullopt;
    result.path = track_path(*sequence, frames, TrackedDepth::undistorted, options);
    if (sensor) {
      result.mounting = calibrate_mounting(result.path.poses, *sensor->orientation);
      result.convention = sensor->orientation->options().convention;
    }
  } catch (...) {
    if (raised) std::rethrow_exception(raised);
    throw;
  }
  return result;
}

const MountingCalibration& mounting_of(const Calibration& c) {
  if (!c.mounting) throw py::value_error("no orientation was given, so no mounting was found");
  return *c.mounting;
}

void save_mounting(const Calibration& c, const Path& path) {
  const MountingCalibration& mounting = mounting_of(c);
  write_orientation_calibration(path.string(),
                                {mounting.body_from_camera, mounting.covariance.diagonal().cwiseMax(0).cwiseSqrt(),
                                 mounting.time_offset, mounting.time_offset_sd, c.convention},
                                {"How an orientation sensor is mounted. Made by plumbline.calibrate"});
}

void add_calibrate(py::module_& m) {
  py::class_<Calibration>(m, "Calibration", "What was found about a camera, and an orientation sensor on it.")
      .def_property_readonly(
          "trajectory", [](const Calibration& c) { return PyTrajectory{c.path.poses}; },
          "The camera's path, from depth alone.")
      .def_property_readonly(
          "depth_distortion",
          [](const Calibration& c) -> py::object {
            if (!c.path.depth) return py::none();
            return py::str(c.path.depth->distortion.describe());
          },
          "In words; None if it could not be told.")
      .def_property_readonly(
          "depth_distortion_grid",
          [](const Calibration& c) -> py::object {
            if (!c.path.depth) return py::none();
            const DepthDistortion& d = c.path.depth->distortion;
            py::array_t<double> grid({py::ssize_t{d.rows()}, py::ssize_t{DepthDistortion::kColumns}});
            std::copy(d.values().begin(), d.values().end(), grid.mutable_data());
            return grid;
          },
          "(rows, columns) float64 over the image, 1/m: measured less true inverse depth; or None")
      .def(
          "save_depth",
          [](const Calibration& c, const Path& path) {
            if (!c.path.depth) throw py::value_error("the depth's distortion could not be told");
            write_depth_calibration(path.string(), c.path.depth->distortion,
                                    depth_calibration_comments(*c.path.depth, "plumbline.calibrate"));
          },
          py::arg("path"), "A TOML file for open_sequence(depth_calibration=...).")
      .def_property_readonly(
          "verdict", [](const Calibration& c) { return std::string(to_string(mounting_of(c).verdict)); },
          "Whether the motion was rich enough.")
      .def_property_readonly(
          "advice", [](const Calibration& c) { return mounting_of(c).advice; },
          "What to do; empty if the verdict is good.")
      .def_property_readonly(
          "body_from_camera", [](const Calibration& c) { return to_array(mounting_of(c).body_from_camera); },
          "(3, 3) float64: how the sensor is mounted.")
      .def_property_readonly(
          "time_offset", [](const Calibration& c) { return mounting_of(c).time_offset; },
          "Seconds, to be added to the sensor's stamps.")
      .def("save_mounting", &save_mounting, py::arg("path"),
           "A TOML file for `plumbline run --orientation-calibration`.");
  m.def("calibrate", &calibrate, py::arg("sequence"), py::arg("orientation") = py::none(), py::kw_only(),
        py::arg("parameters") = py::none(), py::arg("threads") = 0,
        "From a recording without a target: the distortion of the camera's depth and, with a file of an orientation "
        "sensor's readings, how that is mounted and how its clock differs. Tracks the whole recording twice.");
}

}  // namespace

void add_measures(py::module_& m) {
  add_evaluate(m);
  add_surface(m);
  add_calibrate(m);
}

}  // namespace plumbline::python
