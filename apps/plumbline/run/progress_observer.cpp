#include "run/progress_observer.h"

#include <fmt/format.h>

namespace plumbline::app {

void ProgressObserver::observe(const ProcessedFrame& processed) {
  const FrameReport& report = processed.report;
  const bool lost = report.tracking.status == TrackingStatus::lost;
  ++frames_;
  if (lost) ++lost_;
  if (report.is_recovered)
    note(fmt::format("frame {}: a known place is recognised", report.index));
  else if (lost != was_lost_)
    note(lost ? fmt::format("frame {} lost: {}", report.index, to_string(report.tracking.reason))
              : fmt::format("frame {} tracked again", report.index));
  was_lost_ = lost;
  if (processed.live) progress_.add_text(fmt::format("  {} dropped", processed.live->dropped));
  progress_.update(frames_, frames_ - lost_, lost_);
}

}  // namespace plumbline::app
