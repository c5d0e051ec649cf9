#include "run/reconstruction.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <utility>

#include "backend/backend.h"
#include "cli/console.h"
#include "cli/interrupt.h"
#include "cli/orientation_arguments.h"
#include "cli/progress.h"
#include "io/atomic_file.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "report/report.h"
#include "run/frame_log.h"
#include "run/icp_trace.h"
#include "run/orientation_check.h"
#include "run/pixel_use.h"
#include "run/realtime_source.h"
#include "run/summary.h"
#include "run/tracked_path.h"

namespace plumbline::app {
namespace {

void write_text(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

std::string volume_text(const VolumeParameters& volume) {
  const int resolution = (volume.resolution + 7) / 8 * 8;
  return fmt::format("{0}x{0}x{0} voxels of {1:.2f} mm, side {2:g} m, truncation {3:g} m", resolution,
                     1e3 * volume.side / resolution, volume.side, volume.truncation);
}

bool contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

/// One run from its options to its files.
class Runner {
 public:
  explicit Runner(const ReconstructionOptions& options) : options_(options) {}

  Reconstruction run() {
    open();
    // Old results are not touched before the first frame is through: what cannot start must not cost anything.
    const InterruptGuard interrupt;
    process_frames(interrupt);
    if (!is_worth_writing()) {
      if (failure_) std::rethrow_exception(failure_);
      throw_nothing_tracked();
    }
    finish();
    if (failure_) std::rethrow_exception(failure_);
    return std::move(run_);
  }

 private:
  void open() {
    validate(options_.parameters);
    source_ = options_.open_live ? options_.open_live() : open_files();
    run_.sequence = source_->info();
    run_.parameters = options_.parameters;
    run_.command_line = options_.command_line;
    backend_ = make_backend(options_.backend, options_.threads);
    run_.backend = backend_->description();
    run_.orientation = options_.orientation_source;
    // Turns of a sensor without heading cannot be compared with the camera's.
    if (const auto orientation = source_->orientation(); orientation && orientation->convention.has_heading)
      check_.emplace(*orientation);
    load_groundtruth();
    ensure_directory(options_.output);
    make_pipeline();
    describe_run();
  }

  std::unique_ptr<FrameSource> open_files() {
    std::unique_ptr<Sequence> sequence = open_sequence(options_.sequence, options_.input);
    std::vector<int> indices = chosen_frames(*sequence, options_.max_frames, options_.stride);
    if (is_to_be_calibrated()) sequence = straighten(std::move(sequence), indices);
    std::vector<std::string> lines;
    if (options_.orientation)
      lines = describe(*options_.orientation, options_.orientation_source, options_.orientation_notes,
                       options_.parameters.orientation);
    auto files =
        std::make_unique<FileSource>(std::move(sequence), std::move(indices),
                                     options_.orientation ? &*options_.orientation : nullptr, std::move(lines));
    if (options_.realtime == 0) return files;
    return std::make_unique<RealtimeSource>(std::move(files), options_.realtime);
  }

  /// A camera that plays in real time is not known beforehand.
  bool is_to_be_calibrated() const {
    return options_.parameters.preprocess.calibrate_depth && options_.input.depth_distortion.empty() &&
           options_.realtime == 0;
  }

  /// What cannot be read here is told by the run, which keeps all that came before it.
  std::unique_ptr<Sequence> straighten(std::unique_ptr<Sequence> sequence, const std::vector<int>& frames) {
    const auto start = std::chrono::steady_clock::now();
    const InterruptGuard interrupt;
    TrackingOptions tracking{.parameters = options_.parameters, .backend = options_.backend};
    tracking.threads = options_.threads;
    try {
      run_.depth = calibrate_depth(*sequence, frames, tracking, [&] { return interrupt.signal() != 0; });
    } catch (const std::exception&) {
      run_.signal = interrupt.signal();
      if (run_.signal != 0) throw_nothing_tracked();
    }
    run_.depth_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!run_.depth) return sequence;
    return straightened(std::move(sequence), run_.depth->distortion);
  }

  void load_groundtruth() {
    const bool asked = !options_.groundtruth.empty();
    run_.groundtruth = asked ? options_.groundtruth : run_.sequence.groundtruth;
    if (run_.groundtruth.empty()) return;
    try {
      run_.truth = read_trajectory(run_.groundtruth);
    } catch (const Error& error) {
      if (asked) throw;
      run_.ate_note = error.what();  // a damaged companion file is no reason not to reconstruct
    }
  }

  void make_pipeline() {
    const bool color = options_.input.color && source_->has_color() && options_.parameters.volume.color;
    try {
      pipeline_ = std::make_unique<Pipeline>(options_.parameters, run_.sequence.camera, *backend_,
                                             options_.initial_pose, color);
    } catch (const std::bad_alloc&) {
      throw Error("there is not enough memory for " + volume_text(options_.parameters.volume), "volume.resolution",
                  "Make it smaller, for example --set volume.resolution=256.");
    }
  }

  void describe_run() const {
    if (options_.quiet) return;
    for (const std::string& line : source_->describe()) say(line);
    if (run_.depth)
      say("depth      its distortion was found in {:.1f} s, from {} pairs of frames", run_.depth_seconds,
          run_.depth->pairs);
    say("volume     {}", volume_text(options_.parameters.volume));
    say("backend    {}", run_.backend);
    say("output     {}", options_.output);
  }

  void process_frames(const InterruptGuard& interrupt) {
    Progress progress(source_->total(), options_.quiet);
    try {
      while (std::optional<Frame> frame = source_->next([&] { return interrupt.signal() != 0; })) {
        reading_ = source_->reading();
        process(*frame, source_->read_times(), progress);
        for (const std::string& message : source_->take_messages()) progress.note(message);
      }
    } catch (...) {
      failure_ = std::current_exception();
    }
    run_.signal = interrupt.signal();
    run_.wall_seconds = progress.seconds();
    run_.live = source_->live();
    if (options_.open_live) run_.sequence = source_->info();
  }

  void process(const Frame& frame, const ReadTimes& read, Progress& progress) {
    FrameDiagnostics diagnostics;
    diagnostics.want_pixel_use = contains(options_.pixel_use_frames, frame.index);
    diagnostics.want_iterations = contains(options_.icp_frames, frame.index);
    const FrameReport report = pipeline_->process(frame, &diagnostics);
    if (!log_) log_ = std::make_unique<FrameLog>(output("frames.csv"), options_.parameters.tracking);
    log_->add(report, read, reading_ ? to_string(reading_->status) : std::string_view());
    const bool lost = report.tracking.status == TrackingStatus::lost;
    const bool was_lost = !run_.frames.empty() && run_.frames.back().tracking.status == TrackingStatus::lost;
    if (!lost) run_.trajectory.push_back({report.time, report.world_from_camera});
    run_.frames.push_back(report);
    run_.reads.push_back(read);
    if (lost != was_lost)
      progress.note(lost ? fmt::format("frame {} lost: {}", report.index, to_string(report.tracking.reason))
                         : fmt::format("frame {} tracked again", report.index));
    if (reading_) note_orientation(report, progress);
    if (const auto live = source_->live()) progress.add_text(fmt::format("  {} dropped", live->dropped));
    progress.update(static_cast<int>(run_.frames.size()), run_.tracked(), run_.lost());
    write_diagnostics(report, diagnostics, progress);
  }

  void note_orientation(const FrameReport& report, Progress& progress) {
    if (const auto message = check_ ? check_->observe(report, *reading_) : std::nullopt) {
      run_.orientation_message = *message;
      progress.note(*message);
    }
    const OrientationUse before =
        run_.frames.size() > 1 ? run_.frames[run_.frames.size() - 2].orientation : report.orientation;
    const bool distrusted = report.orientation == OrientationUse::distrusted;
    if (distrusted != (before == OrientationUse::distrusted))
      progress.note(fmt::format("frame {}: the orientation {}", report.index,
                                distrusted ? "disagrees with the tracking and is not used" : "agrees again"));
  }

  void write_diagnostics(const FrameReport& report, const FrameDiagnostics& diagnostics, Progress& progress) {
    const auto write = [&](bool wanted, bool empty, const std::string& name, const auto& writer) {
      if (!wanted) return;
      if (empty)
        progress.note(fmt::format("frame {} was not registered: no {}", report.index, output(name)));
      else
        writer(output(name));
    };
    write(diagnostics.want_pixel_use, diagnostics.pixel_use.empty(), fmt::format("pixel_use_{}.png", report.index),
          [&](const std::string& path) { write_pixel_use(path, diagnostics.pixel_use); });
    write(diagnostics.want_iterations, diagnostics.iterations.empty(), fmt::format("icp_{}.json", report.index),
          [&](const std::string& path) {
            run_.icp_traces.push_back(icp_json(report, diagnostics.iterations, options_.parameters));
            write_text(path, run_.icp_traces.back());
          });
  }

  /// A run that never registered one frame to another has nothing to put in place of older results.
  bool is_worth_writing() const {
    if (run_.signal != 0) return !run_.trajectory.empty();
    const bool alone = run_.frames.size() == 1 && !run_.trajectory.empty();
    return alone || std::any_of(run_.frames.begin(), run_.frames.end(), [](const FrameReport& frame) {
             return frame.tracking.status == TrackingStatus::tracked;
           });
  }

  [[noreturn]] void throw_nothing_tracked() const {
    const std::string files = log_ ? "; each frame's reason stands in " + output("frames.csv.partial") : "";
    if (run_.signal != 0) throw Error("interrupted before the first frame was through", options_.sequence, "");
    if (run_.trajectory.empty())
      throw Error("no frame has enough depth to begin with, nothing was written" + files, options_.sequence,
                  "Check --depth-scale, preprocess.min_depth and preprocess.max_depth against the images.");
    throw Error("no frame could be tracked, nothing was written" + files, options_.sequence,
                "If the scene lies outside the volume, try --set volume.placement=fit or a larger volume.side.");
  }

  /// Writes everything that was reached. After a failure the first error is the one to tell.
  void finish() {
    try {
      if (failure_) run_.failure = message_of(failure_);
      write_outputs();
    } catch (...) {
      if (!failure_) throw;
    }
  }

  void write_outputs() {
    // The trajectory first: it is the smallest, and what a full disk should spare.
    write_tum_trajectory(output("trajectory.txt"), run_.trajectory);
    evaluate();
    run_.world_from_volume = pipeline_->world_from_volume();
    run_.volume_side = pipeline_->volume_side();
    if (options_.mesh) {
      run_.mesh = pipeline_->extract_mesh();
      write_ply(output("mesh.ply"), run_.mesh);
    }
    write_text(output("config.toml"), to_toml(options_.parameters));
    write_depth();
    if (log_) log_->commit();
    write_text(output("summary.json"), summary_json(run_));
    write_page();
    if (options_.quiet) return;
    for (const std::string& line : summary_text(run_)) say(line);
    if (!run_.report.empty()) say("report     {}", run_.report);
    if (options_.report && !can_report()) say("report     none: this program was built without it (PLUMBLINE_REPORT)");
  }

  /// For other recordings of this camera. One of an earlier run would tell of another.
  void write_depth() {
    const std::string path = output("depth.toml");
    if (run_.depth) return save_depth_calibration(path, *run_.depth, options_.command_line);
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }

  /// Last, and never what a run fails for: the other files hold all that is in the page.
  void write_page() {
    const std::string path = output("report.html");
    try {
      if (options_.report && can_report()) {
        write_report(path, report_of(run_));
        run_.report = path;
        return;
      }
    } catch (const std::exception& error) {
      warn(fmt::format("there is no report of this run; its other files are whole\n  {}", error.what()));
    }
    std::error_code ignored;  // a page of an earlier run would tell of other results
    std::filesystem::remove(path, ignored);
  }

  void evaluate() {
    if (run_.truth.empty()) return;
    try {
      run_.ate = eval::absolute_trajectory_error(run_.truth, run_.trajectory);
    } catch (const Error& error) {
      run_.ate_note = error.what();
    }
  }

  static std::string message_of(const std::exception_ptr& failure) {
    try {
      std::rethrow_exception(failure);
    } catch (const std::exception& error) {
      return error.what();
    }
  }

  std::string output(const std::string& name) const { return (std::filesystem::path(options_.output) / name).string(); }

  const ReconstructionOptions& options_;
  Reconstruction run_;
  std::unique_ptr<FrameSource> source_;
  std::shared_ptr<Backend> backend_;
  std::unique_ptr<Pipeline> pipeline_;
  std::unique_ptr<FrameLog> log_;
  std::optional<OrientationCheck> check_;
  std::optional<OrientationReading> reading_;  ///< of the current frame; none without a sensor
  std::exception_ptr failure_;
};

}  // namespace

Reconstruction reconstruct(const ReconstructionOptions& options) { return Runner(options).run(); }

}  // namespace plumbline::app
