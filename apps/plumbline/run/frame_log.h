// frames.csv: a row per frame, written while the run goes on.
#pragma once

#include <memory>
#include <string>

#include "io/csv.h"
#include "plumbline/parameters.h"
#include "reconstruction/frame_loop.h"

namespace plumbline::app {

/// Rows go to `path`.partial, handed to the system one by one, so that a run that was killed leaves all of them; only
/// `commit` replaces an older `path`.
class FrameLog : public FrameObserver {
 public:
  /// Nothing is written before the first frame.
  FrameLog(std::string path, TrackingParameters parameters);

  /// Throws Error if the disk is full.
  void observe(const ProcessedFrame& processed) override;
  /// Without it the partial table stays, as it may be all that is left of a run. Nothing happens if no frame came.
  void commit();
  /// Where the rows are before commit(); empty if no frame came.
  std::string partial() const { return csv_ ? partial_ : ""; }

 private:
  std::string path_, partial_;
  TrackingParameters parameters_;
  std::unique_ptr<CsvWriter> csv_;
};

}  // namespace plumbline::app
