#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "capture/clock.h"
#include "capture/recorder.h"
#include "cli/arguments.h"
#include "cli/capture_arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/sequence_text.h"
#include "cli/status_line.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"
#include "view/view_arguments.h"

namespace plumbline::app {
namespace {

constexpr std::size_t kWaitingFrames = 8;  // between camera and recorder, which has a queue of its own
constexpr std::chrono::milliseconds kPoll{50};
constexpr Nanoseconds kPageInterval = 200'000'000;
constexpr double kSlowSync = 0.5;  // seconds

struct RecordArguments {
  CaptureArguments capture;
  ViewArguments view;
  std::string output, intrinsics, mounting;
  double duration = 0;  // seconds, 0 = until Ctrl-C
  bool no_color = false, no_raw = false, quiet = false;
};

std::optional<Pinhole> given_intrinsics(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const std::vector<double> n = parse_numbers(text, 4, "--intrinsics", "fx,fy,cx,cy");
  return Pinhole{
      static_cast<float>(n[0]), static_cast<float>(n[1]), static_cast<float>(n[2]), static_cast<float>(n[3]), 0, 0};
}

/// body_from_camera; empty where it is not given.
std::optional<Eigen::Matrix3d> given_mounting(const std::string& text) {
  if (text.empty()) return std::nullopt;
  parse_numbers(text, 4, "--mounting", "\"QX QY QZ QW\"");
  return parse_pose("0 0 0 " + text, "--mounting").rotation();
}

/// One recording from its devices to its files.
class Session {
 public:
  explicit Session(const RecordArguments& arguments) : arguments_(arguments), line_(arguments.quiet) {}

  int run() {
    open();
    const InterruptGuard interrupt;
    std::exception_ptr failure;
    try {
      capture(interrupt);
    } catch (...) {
      failure = std::current_exception();
    }
    close(failure);
    if (failure) std::rethrow_exception(failure);
    return 0;  // Ctrl-C is how a recording ends
  }

 private:
  void open() {
    if (arguments_.capture.depth == "none" && arguments_.capture.imu == "none")
      throw UsageError("there is nothing to record", "--depth none --imu none", "Give a camera or a sensor.");
    camera_ =
        open_depth(arguments_.capture, !arguments_.no_color, given_intrinsics(arguments_.intrinsics), kWaitingFrames);
    // Readings that come before the recorder stands are of no use.
    imu_ = open_imu(arguments_.capture, [this](const capture::ImuReading& reading) {
      if (recording_) recorder_->add(reading);
    });
    capture::RecorderOptions options;
    options.folder = arguments_.output;
    if (camera_) {
      options.camera = camera_->info().camera;
      options.depth_scale = camera_->info().depth_scale;
      options.color = camera_->info().has_color;
    }
    options.body_from_camera = given_mounting(arguments_.mounting);
    options.orientation = imu_ != nullptr;
    options.raw = imu_ != nullptr && !arguments_.no_raw;
    recorder_ = std::make_unique<capture::Recorder>(options);
    recording_ = true;
    describe();
    open_page();
  }

  void describe() const {
    if (arguments_.quiet) return;
    if (camera_) {
      const capture::DepthDeviceInfo& info = camera_->info();
      say("camera     {}, {}", info.name, info.has_color ? "with colour" : "no colour");
      say("           {}, from {}", camera_text(info.camera), info.camera_source);
      for (const std::string& note : info.notes) say("note       {}", note);
    }
    if (imu_) say("sensor     {}", imu_->description());
    say("output     {}; Ctrl-C ends the recording", arguments_.output);
  }

  void open_page() {
    view_ = open_view(arguments_.view);
    if (!view_) return;
    ViewScene scene;
    scene.title = scene.output = arguments_.output;
    scene.is_live = true;
    scene.has_map = false;
    if (camera_) scene.camera = camera_->info().camera;
    view_->set_scene(scene);
    view_->set_phase(ViewPhase::running);
  }

  /// A page can ask nothing else of a recording.
  bool is_finished_by_page() {
    bool finished = false;
    while (const std::optional<Request> request = view_ ? view_->take_request() : std::nullopt)
      finished = finished || request->kind == RequestKind::finish;
    return finished;
  }

  double seconds() const { return to_seconds(capture::now() - begin_); }

  void capture(const InterruptGuard& interrupt) {
    while (interrupt.signal() == 0 && !is_finished_by_page() &&
           (arguments_.duration == 0 || seconds() < arguments_.duration)) {
      if (camera_) {
        if (auto frame = camera_->next(kPoll)) add(std::move(*frame));
        if (camera_->status().ended) break;
      } else {
        std::this_thread::sleep_for(kPoll);
      }
      recorder_->check();
      tell();
    }
  }

  /// A camera that waits is not hurried: its frames wait for the disk.
  void add(capture::CapturedFrame frame) {
    if (view_) view_->show(frame.depth, frame.color, camera_->info().depth_scale);
    while (camera_->info().waits && !recorder_->has_room()) {
      recorder_->check();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    recorder_->add(std::move(frame));
  }

  void tell() {
    if (imu_)
      for (const std::string& message : imu_->take_messages()) line_.note(message);
    if (camera_)
      if (const auto message = silence_.observe(camera_->status())) line_.note(*message);
    if (line_.is_due()) line_.update(status_text());
    if (view_ && camera_ && capture::now() - page_told_ > kPageInterval) tell_page();
  }

  void tell_page() {
    page_told_ = capture::now();
    view_->set_recording(camera_->status().frames, page_rate_.update(camera_->status().frames, seconds()), dropped(),
                         imu_ ? sensor_text(imu_->status()) : "");
  }

  /// Fits into 80 columns.
  std::string status_text() {
    std::string text = "rec " + duration_text(seconds());
    if (camera_) {
      const capture::GrabberStatus status = camera_->status();
      text += fmt::format("  {:.1f}/s, {} frames, {} dropped", frame_rate_.update(status.frames, seconds()),
                          status.frames, dropped());
    }
    if (imu_) {
      const capture::ImuStatus status = imu_->status();
      text += fmt::format("  imu {:.1f}/s, ", reading_rate_.update(status.readings, seconds()));
      text += status.connected ? calibration_text(status.calibration) : "not connected";
    }
    return text;
  }

  std::uint64_t dropped() const { return camera_->status().dropped + recorder_->status().dropped; }

  /// Ends everything. After a failure the first error is the one to tell.
  void close(std::exception_ptr& failure) {
    const std::uint64_t lost = camera_ ? dropped() : 0;
    camera_.reset();
    std::optional<capture::Bno055Calibration> calibration;
    if (imu_) calibration = imu_->finish();
    try {
      recorder_->finish();
      if (calibration) capture::write_bno055_calibration(file("imu-calibration.txt"), *calibration);
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
    if (!arguments_.quiet) summarise(lost, calibration.has_value());
    if (view_ && !failure) view_->hand_over("", "The recording lies in " + arguments_.output + ".");
  }

  void summarise(std::uint64_t lost, bool calibrated) {
    if (imu_)
      for (const std::string& message : imu_->take_messages()) line_.note(message);
    const capture::RecorderStatus status = recorder_->status();
    say("recorded   {} frames and {} orientations in {}; {} frames dropped", status.frames, status.readings,
        duration_text(seconds()), lost);
    if (status.slowest_sync > kSlowSync)
      say("note       the disk took up to {:.1f} s to keep up; a crash could have cost that much more",
          status.slowest_sync);
    if (imu_) {
      const capture::ImuStatus s = imu_->status();
      say("sensor     calibration {}; {} failed requests, {} over-runs, {} reconnections",
          calibration_text(s.calibration), s.failed, s.overruns, s.reconnections);
    }
    if (calibrated) say("           next time: --imu-calibration {}", file("imu-calibration.txt"));
  }

  std::string file(const std::string& name) const { return (std::filesystem::path(arguments_.output) / name).string(); }

  const RecordArguments& arguments_;
  std::shared_ptr<LiveView> view_;  ///< or null
  Nanoseconds page_told_ = 0;
  StatusLine line_;
  SilenceWatch silence_;
  RateMeter frame_rate_, reading_rate_, page_rate_;
  Nanoseconds begin_ = capture::now();
  std::unique_ptr<capture::Recorder> recorder_;
  std::atomic<bool> recording_ = false;
  std::unique_ptr<capture::FrameGrabber> camera_;
  std::unique_ptr<capture::ImuSource> imu_;  // after the recorder, which it writes to
};

}  // namespace

void add_record_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<RecordArguments>();
  CLI::App* command = app.add_subcommand("record", "Record a depth camera and an orientation sensor into a folder");
  add_capture_arguments(*command, arguments->capture);
  add_view_arguments(*command, arguments->view);
  command->add_option("-o,--output", arguments->output, "Folder of the recording, created if missing")
      ->required()
      ->type_name("DIR");
  command->add_option("--intrinsics", arguments->intrinsics, "Pixels, in place of the camera's own")
      ->type_name("FX,FY,CX,CY");
  command
      ->add_option("--mounting", arguments->mounting,
                   "body_from_camera of the sensor, kept in camera.json: a run then needs no --mounting")
      ->type_name("\"QX QY QZ QW\"");
  command->add_option("--duration", arguments->duration, "Seconds, 0 for until Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_flag("--no-color,--no-colour", arguments->no_color, "Depth alone");
  command->add_flag("--no-raw", arguments->no_raw, "No imu.csv: the orientation alone");
  command->add_flag("--quiet", arguments->quiet, "Print nothing but errors");
  command->footer(
      "Writes a TUM folder that `plumbline run` reads (depth/, rgb/, camera.json), orientation.txt, imu.csv "
      "and\nimu-calibration.txt. It is good at every moment: a crash or power loss costs the final second at most.");
  command->callback([arguments, &chosen] { chosen = [arguments] { return Session(*arguments).run(); }; });
}

}  // namespace plumbline::app
