// frames.csv: a row per frame, written while the run goes on.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "io/csv.h"
#include "run/reconstruction.h"

namespace plumbline::app {

/// Rows go to `path`.partial, handed to the system one by one, so that a run that was killed leaves all of them; only
/// `commit` replaces an older `path`.
class FrameLog {
 public:
  FrameLog(std::string path, const TrackingParameters& parameters);
  /// Without a commit(): the partial table stays, as it may be all that is left of a run.
  ~FrameLog() = default;

  /// `missing_reading`: why the frame had no reading of the orientation sensor, for a sequence that has one. Throws
  /// Error if the disk is full.
  void add(const FrameReport& report, const ReadTimes& read, std::string_view missing_reading);
  void commit();

 private:
  std::string path_, partial_;
  int levels_;
  std::unique_ptr<CsvWriter> csv_;
};

}  // namespace plumbline::app
