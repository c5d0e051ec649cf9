#include "run/reconstruction.h"

#include <exception>
#include <vector>

#include "cli/interrupt.h"
#include "plumbline/error.h"
#include "plumbline/time.h"
#include "reconstruction/run_parts.h"
#include "run/diagnostics.h"
#include "run/frame_log.h"
#include "run/open_run.h"
#include "run/progress_observer.h"
#include "run/run_outputs.h"

namespace plumbline::app {
namespace {

/// Keeps what the summary says of reading.
class ReadRecord : public FrameObserver {
 public:
  explicit ReadRecord(Reconstruction* run) : run_(*run) {}
  void observe(const ProcessedFrame& processed) override { run_.reads.push_back(processed.read); }

 private:
  Reconstruction& run_;
};

/// Forgets the frames that a page wants undone, and all that came of the others: they come again. False if the page
/// wants nothing of that kind.
bool go_back(const ReconstructionOptions& options, OpenRun* open, FrameLog* log, Reconstruction* run) {
  const std::optional<GoBack> back = open->guided == nullptr ? std::nullopt : open->guided->take_back();
  if (!back) return false;
  std::vector<int> processed;
  std::size_t kept = 0;
  for (const FrameReport& frame : run->frames) {
    processed.push_back(frame.index);
    const double age = to_seconds(run->frames.back().time - frame.time);
    if (back->seconds && age >= *back->seconds) kept = processed.size();
  }
  run->frames.clear();
  run->trajectory.clear();
  run->reads.clear();
  *log = FrameLog(output_path(options, "frames.csv"), options.parameters.tracking);
  make_pipeline(options, open);
  open->guided->go_back(processed, kept);
  return true;
}

/// All frames, or those before the failure that is returned.
std::exception_ptr process_frames(const ReconstructionOptions& options, OpenRun* open, const InterruptGuard& interrupt,
                                  FrameLog* log, Reconstruction* run) {
  ProgressObserver progress(open->source->total(), options.quiet);
  const Note note = [&](const std::string& line) { progress.note(line); };
  ReadRecord reads(run);
  DiagnosticsObserver diagnostics(options.output, {options.pixel_use_frames, options.icp_frames}, options.parameters,
                                  note);
  std::exception_ptr failure;
  try {
    std::vector<FrameObserver*> observers = {log, &reads, &progress, &diagnostics};
    if (options.view) observers.push_back(options.view.get());
    do {
      progress.begin();
      plumbline::process_frames(*open->source, *open->pipeline,
                                {observers, [&] { return interrupt.signal() != 0; }, note}, run);
    } while (go_back(options, open, log, run));
  } catch (...) {
    failure = std::current_exception();
  }
  run->icp_traces = diagnostics.icp_traces();
  run->signal = interrupt.signal();
  run->wall_seconds = progress.seconds();
  run->live = open->source->live();
  if (options.open_live) run->sequence = open->source->info();
  return failure;
}

/// What is wrong with the input comes before what a volume can be blamed for: a wrong scale first. Null: nothing.
const Warning* likely_cause(const std::vector<Warning>& warnings) {
  for (const Warning& warning : warnings)
    if (warning.what.find("scale") != std::string::npos) return &warning;
  return warnings.empty() ? nullptr : &warnings.front();
}

[[noreturn]] void throw_nothing_tracked(const ReconstructionOptions& options, const Reconstruction& run,
                                        const FrameLog& log) {
  if (run.signal != 0) throw Error("interrupted before the first frame was through", options.sequence, "");
  if (const Warning* warning = likely_cause(run.sequence.warnings))
    throw Error("no frame could be tracked, nothing was written; " + warning->what, options.sequence,
                warning->what_to_do);
  const std::string files = log.partial().empty() ? "" : "; each frame's reason stands in " + log.partial();
  if (run.trajectory.empty())
    throw Error("no frame has enough depth to begin with, nothing was written" + files, options.sequence,
                "Check --depth-scale, preprocess.min_depth and preprocess.max_depth against the images.");
  throw Error("no frame could be tracked, nothing was written" + files, options.sequence,
              "If the scene lies outside the volume, try --set volume.placement=fit or a larger volume.side.");
}

std::string message_of(const std::exception_ptr& failure) {
  if (!failure) return "";
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

/// After a failure that is the error to tell.
void finish(const ReconstructionOptions& options, const OpenRun& open, const InterruptGuard& interrupt,
            const std::exception_ptr& failure, FrameLog* log, Reconstruction* run) {
  try {
    run->failure = message_of(failure);
    write_outputs(options, open, interrupt, log, run);
  } catch (...) {
    if (!failure) throw;
  }
  if (failure) std::rethrow_exception(failure);
}

Reconstruction run_and_write(const ReconstructionOptions& options) {
  Reconstruction run;
  OpenRun open = open_run(options, &run);
  // Old results are not touched before the first frame is through: what cannot start must not cost anything.
  FrameLog log(output_path(options, "frames.csv"), options.parameters.tracking);
  const InterruptGuard interrupt;
  const std::exception_ptr failure = process_frames(options, &open, interrupt, &log, &run);
  if (options.view) {
    options.view->follow(nullptr, true);
    options.view->set_phase(ViewPhase::finishing, "The results are written.");
  }
  if (!is_worth_writing(run)) {
    if (failure) std::rethrow_exception(failure);
    throw_nothing_tracked(options, run, log);
  }
  finish(options, open, interrupt, failure, &log, &run);
  return run;
}

}  // namespace

Reconstruction reconstruct(const ReconstructionOptions& options) {
  if (!options.view) return run_and_write(options);
  try {
    Reconstruction run = run_and_write(options);
    options.view->hand_over(run.report, "The results are written; there is no report.");
    return run;
  } catch (const std::exception& error) {
    options.view->fail(error.what());
    throw;
  }
}

}  // namespace plumbline::app
