// Sequences, whole runs and simulations.
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bindings.h"
#include "plumbline/calibration.h"
#include "plumbline/prefetch.h"
#include "plumbline/reconstruct.h"
#include "plumbline/sequence.h"
#include "plumbline/simulate.h"

namespace plumbline::python {
namespace {

using SharedSequence = std::shared_ptr<Sequence>;

std::vector<int> every_frame(const Sequence& sequence) {
  std::vector<int> indices(static_cast<std::size_t>(sequence.size()));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = static_cast<int>(i);
  return indices;
}

/// Python's iterator: frames decoded ahead by a thread that knows nothing of Python.
class FrameIterator {
 public:
  explicit FrameIterator(SharedSequence sequence)
      : sequence_(std::move(sequence)), frames_(*sequence_, every_frame(*sequence_)) {}

  std::shared_ptr<Frame> next() {
    std::optional<Frame> frame;
    {
      const py::gil_scoped_release release;
      frame = frames_.next();
    }
    for (; told_ < frames_.skipped().size(); ++told_)
      if (PyErr_WarnEx(PyExc_RuntimeWarning, ("frame skipped: " + frames_.skipped()[told_]).c_str(), 2) != 0)
        throw py::error_already_set();
    if (!frame) throw py::stop_iteration();
    return std::make_shared<Frame>(std::move(*frame));
  }

 private:
  SharedSequence sequence_;
  ReadableFrames frames_;
  std::size_t told_ = 0;
};

SharedSequence open(const Path& path, const std::string& camera, const py::object& intrinsics,
                    std::optional<double> depth_scale, bool color, bool strict, const Path& depth_calibration) {
  SequenceOptions options;
  options.camera = camera;
  if (!intrinsics.is_none()) options.intrinsics = intrinsics.cast<Pinhole>();
  options.depth_scale = depth_scale;
  options.color = color;
  options.strict = strict;
  if (!depth_calibration.empty()) options.depth_distortion = read_depth_calibration(depth_calibration.string());
  const py::gil_scoped_release release;
  return open_sequence(path.string(), options);
}

std::shared_ptr<Frame> frame_at(const SharedSequence& self, int index) {
  if (index < 0) index += self->size();
  if (index < 0 || index >= self->size())
    throw py::index_error("the sequence has " + std::to_string(self->size()) + " frames");
  const py::gil_scoped_release release;
  return std::make_shared<Frame>(self->read(index));
}

void add_sequence(py::module_& m) {
  py::class_<FrameIterator, std::unique_ptr<FrameIterator>>(m, "FrameIterator", "Frames of a sequence, decoded ahead.")
      .def("__iter__", [](FrameIterator& self) -> FrameIterator& { return self; })
      .def("__next__", &FrameIterator::next);
  const auto info = [](auto member) { return [member](const Sequence& self) { return self.info().*member; }; };
  py::class_<Sequence, SharedSequence>(m, "Sequence",
                                       "A recording: `for frame in sequence` reads it in order; frames that cannot be "
                                       "read are skipped with a RuntimeWarning.")
      .def("__len__", &Sequence::size)
      .def("__getitem__", &frame_at, py::arg("index"), "Reads one frame. Raises Error if it is damaged.")
      .def("__iter__", [](const SharedSequence& self) { return std::make_unique<FrameIterator>(self); })
      .def_property_readonly("camera", info(&SequenceInfo::camera), "Of the frames.")
      .def_property_readonly("format", info(&SequenceInfo::format), "As docs/formats.md names it.")
      .def_property_readonly("path", info(&SequenceInfo::path))
      .def_property_readonly("depth_scale", info(&SequenceInfo::depth_scale), "Readings a metre.")
      .def_property_readonly("camera_source", info(&SequenceInfo::camera_source), "Where the camera comes from.")
      .def_property_readonly("camera_is_guess", info(&SequenceInfo::camera_is_guess),
                             "Neither given nor told by the recording.")
      .def_property_readonly("depth_scale_is_guess", info(&SequenceInfo::depth_scale_is_guess))
      .def_property_readonly("notes", info(&SequenceInfo::notes), "What the user should know, a sentence each.")
      .def_property_readonly(
          "warnings",
          [](const Sequence& self) {
            std::vector<std::string> texts;
            for (const Warning& warning : self.info().warnings)
              texts.push_back(warning.what + " " + warning.what_to_do);
            return texts;
          },
          "What does not add up, and what to do.")
      .def(
          "groundtruth", [](const Sequence& self) { return PyTrajectory{self.read_groundtruth()}; },
          "The true poses; empty where the recording has none.")
      .def(
          "imu", [](const Sequence& self) { return to_array(self.read_imu().samples); },
          "(N, 7) float64: seconds, rad/s, m/s^2, the sensor's own axes; (0, 7) without a sensor.");
  m.def("open_sequence", &open, py::arg("path"), py::kw_only(), py::arg("camera") = "",
        py::arg("intrinsics") = py::none(), py::arg("depth_scale") = py::none(), py::arg("color") = true,
        py::arg("strict") = false, py::arg("depth_calibration") = "",
        "Opens a folder or a recording in one file (docs/formats.md); what is not given is found out.\n\n"
        "camera: by name, one of camera_names(). intrinsics: a Camera. depth_scale: readings a metre. strict: warnings "
        "are errors. depth_calibration: a depth.toml, whose distortion is taken out of the frames.");
  m.def("camera_names", &camera_names, "Names that open_sequence takes.");
}

/// Callbacks to Python from within a run. What they raise, and Ctrl-C, ends the run and is raised when it returns.
class Callbacks {
 public:
  bool stopping() {
    if (raised_) return true;
    const py::gil_scoped_acquire acquire;
    keep([] {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    });
    return static_cast<bool>(raised_);
  }
  template <class Call>
  void call(const Call& action) {
    if (raised_) return;
    const py::gil_scoped_acquire acquire;
    keep(action);
  }
  void rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  template <class Call>
  void keep(const Call& action) {
    try {
      action();
    } catch (...) {
      raised_ = std::current_exception();
    }
  }
  std::exception_ptr raised_;
};

SharedSequence sequence_of(const py::object& given) {
  if (py::isinstance<Sequence>(given)) return given.cast<SharedSequence>();
  return open(given.cast<Path>(), "", py::none(), {}, true, false, "");
}

std::optional<SensorReadings> readings_of(const std::string& orientation) {
  if (orientation == "auto") return std::nullopt;
  if (orientation == "none") return SensorReadings();
  return read_sensor(orientation);
}

Reconstruction run(const py::object& given, const std::optional<Path>& output,
                   const std::optional<Parameters>& parameters, const std::string& orientation,
                   const std::vector<int>& frames, bool color, bool mesh, const std::string& backend, int threads,
                   const py::object& initial_pose, const py::object& on_frame, const py::object& log) {
  const SharedSequence sequence = sequence_of(given);
  ReconstructOptions options;
  options.parameters = parameters.value_or(Parameters());
  options.sensor = readings_of(orientation);
  options.frames = frames;
  options.color = color;
  options.mesh = mesh;
  options.backend = backend;
  options.threads = threads;
  if (!initial_pose.is_none()) options.initial_pose = pose_of(initial_pose, "initial_pose");
  Callbacks callbacks;
  options.stopping = [&] { return callbacks.stopping(); };
  if (!on_frame.is_none())
    options.on_frame = [&](const Frame&, const FrameReport& report) { callbacks.call([&] { on_frame(report); }); };
  if (!log.is_none())
    options.log = [&](LogLevel level, const std::string& line) {
      callbacks.call([&] { log(level == LogLevel::warning ? "warning" : "note", line); });
    };
  Reconstruction result;
  {
    const py::gil_scoped_release release;
    result = reconstruct(*sequence, options);
    if (!callbacks.stopping() && output) write_reconstruction(output->string(), result);
  }
  callbacks.rethrow();
  return result;
}

void add_run(py::module_& m) {
  py::class_<Reconstruction>(m, "Reconstruction", "What a run did.")
      .def_property_readonly(
          "trajectory", [](const Reconstruction& r) { return PyTrajectory{r.trajectory}; },
          "Of the tracked frames, corrected where the camera came back.")
      .def_property_readonly(
          "live_trajectory", [](const Reconstruction& r) { return PyTrajectory{r.live_trajectory}; },
          "As it was tracked, where it was corrected; else empty.")
      .def_property_readonly(
          "mesh", [](Reconstruction& r) -> Mesh& { return r.mesh; }, py::return_value_policy::reference_internal,
          "The surface, metres, world frame; its arrays keep the run alive.")
      .def_property_readonly(
          "reports", [](const Reconstruction& r) { return r.frames; }, "A FrameReport for every frame.")
      .def_property_readonly("tracked", &Reconstruction::tracked, "Frames with a pose.")
      .def_property_readonly("lost", &Reconstruction::lost)
      .def_readonly("skipped", &Reconstruction::skipped, "Why frames could not be read, a sentence each.")
      .def_readonly("backend", &Reconstruction::backend)
      .def_readonly("parameters", &Reconstruction::parameters)
      .def_readonly("orientation", &Reconstruction::orientation, "The sensor in words; empty if none was used.")
      .def_readonly("orientation_notes", &Reconstruction::orientation_notes)
      .def_readonly("orientation_message", &Reconstruction::orientation_message,
                    "What the user should know about the readings, or empty.")
      .def_property_readonly("notes", [](const Reconstruction& r) { return r.sequence.notes; })
      .def_property_readonly(
          "depth_distortion",
          [](const Reconstruction& r) -> py::object {
            if (!r.depth) return py::none();
            return py::str(r.depth->distortion.describe());
          },
          "The distortion of the depth that was found and taken out, in words; or None.")
      .def(
          "save", [](const Reconstruction& r, const Path& folder) { write_reconstruction(folder.string(), r); },
          py::arg("folder"), py::call_guard<py::gil_scoped_release>(),
          "Writes trajectory.txt, mesh.ply, config.toml and depth.toml.");
  m.def(
      "run", &run, py::arg("sequence"), py::arg("output") = py::none(), py::kw_only(),
      py::arg("parameters") = py::none(), py::arg("orientation") = "auto", py::arg("frames") = std::vector<int>(),
      py::arg("color") = true, py::arg("mesh") = true, py::arg("backend") = "auto", py::arg("threads") = 0,
      py::arg("initial_pose") = py::none(), py::arg("on_frame") = py::none(), py::arg("log") = py::none(),
      "All that `plumbline run` does with a recording, the same to the bit: finds the depth's distortion and takes it "
      "out, takes the recording's sensor, tracks and fuses every frame, extracts the mesh.\n\n"
      "sequence: a Sequence or a path. output: a folder for the files, None: none is written. parameters: None takes "
      "the preset plumbline. orientation: auto (the recording's own sensor), none, or a file. frames: indices, "
      "ascending; empty: all. on_frame: called with each FrameReport. log: called with \"note\" or \"warning\" and a "
      "line.");
}

Simulation make(const Path& folder, const std::string& scene, const std::string& path, int frames, double rate,
                double speed, double duration, const py::object& camera, bool noise, bool color, std::uint64_t seed) {
  SimulateOptions options;
  options.scene = scene;
  options.path = path;
  options.frames = frames;
  options.rate = rate;
  options.speed = speed;
  options.duration = duration;
  if (!camera.is_none()) options.camera = camera.cast<Pinhole>();
  options.noise = noise;
  options.color = color;
  options.seed = seed;
  const py::gil_scoped_release release;
  return simulate(folder.string(), options);
}

void add_simulate(py::module_& m) {
  py::class_<Simulation>(m, "Simulation", "The truth of a simulated recording.")
      .def_property_readonly("trajectory", [](const Simulation& s) { return PyTrajectory{s.world_from_camera}; })
      .def_property_readonly(
          "scene", [](Simulation& s) -> Mesh& { return s.scene; }, py::return_value_policy::reference_internal,
          "The true surface, world frame.");
  const SimulateOptions defaults;
  m.def(
      "simulate", &make, py::arg("folder"), py::kw_only(), py::arg("scene") = defaults.scene,
      py::arg("path") = defaults.path, py::arg("frames") = defaults.frames, py::arg("rate") = defaults.rate,
      py::arg("speed") = defaults.speed, py::arg("duration") = defaults.duration, py::arg("camera") = py::none(),
      py::arg("noise") = defaults.noise, py::arg("color") = defaults.color, py::arg("seed") = defaults.seed,
      "Writes a recording of a made-up scene that open_sequence reads, with exact truth and an orientation sensor.\n\n"
      "scene: desk, room, kitchen, teddy, corridor, ring, floor, twins, or a PLY or OBJ file. path: orbit, sweep, "
      "handheld, turntable, "
      "dance, walk, or a trajectory in TUM's format. frames: 0 for all. rate: a second. duration: seconds. camera: "
      "None is "
      "640x480 with a Kinect's field of view.");
}

}  // namespace

void add_sequences(py::module_& m) {
  add_sequence(m);
  add_run(m);
  add_simulate(m);
}

}  // namespace plumbline::python
