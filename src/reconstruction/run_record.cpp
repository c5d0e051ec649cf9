#include "reconstruction/run_record.h"

namespace plumbline {

void RunRecord::observe(const ProcessedFrame& processed) {
  const FrameReport& report = processed.report;
  const bool is_taken_back = report.is_after_interruption || report.tracking.reason == LostReason::unconfirmed;
  if (is_taken_back) take_back();
  run_.frames.push_back(report);
  if (report.tracking.status == TrackingStatus::provisional) provisional_.push_back(run_.frames.size() - 1);
  if (!has_pose(report.tracking.status)) return;
  for (const std::size_t i : provisional_) add_pose(run_.frames[i]);
  provisional_.clear();
  add_pose(report);
}

void RunRecord::take_back() {
  for (const std::size_t i : provisional_) {
    run_.frames[i].tracking.status = TrackingStatus::lost;
    run_.frames[i].tracking.reason = LostReason::unconfirmed;
  }
  provisional_.clear();
}

}  // namespace plumbline
