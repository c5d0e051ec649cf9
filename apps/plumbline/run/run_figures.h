// The figures of a finished run of `plumbline run`, read from its folder.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "plumbline/trajectory.h"

namespace plumbline::app {

struct RunFigures {
  int frames = 0, lost = 0;
  /// Root mean squares, metres; none without a ground truth or with too little to compare.
  std::optional<double> ate;            ///< of the tracked frames, as summary.json has it
  std::optional<double> ate_all;        ///< of all frames: a lost one counts with the previous accepted pose
  std::optional<double> rpe;            ///< over 1 s, of all frames
  std::optional<double> rpe_all_pairs;  ///< of all frames
  double mean_iterations = 0;           ///< of a registered frame, over all levels
  double track_ms = 0, total_ms = 0;    ///< medians
  double inliers = 0;                   ///< matched share of the readings, median of the tracked frames
  std::vector<double> frame_ms;         ///< each frame's time
};

/// Throws Error if a file is missing or of another form.
RunFigures run_figures(const std::string& folder);

/// The rows of a CSV file by the names of its columns; quoted fields may hold commas and line ends (RFC 4180).
class CsvRows {
 public:
  /// Throws Error if the file cannot be read or a row has not as many fields as the header.
  explicit CsvRows(const std::string& path);
  std::size_t size() const { return rows_.size(); }
  /// Throws Error if there is no such column.
  const std::string& text(std::size_t row, const std::string& column) const;
  /// Throws Error if it is no number.
  double number(std::size_t row, const std::string& column) const;

 private:
  std::size_t index_of(const std::string& column) const;
  std::string path_;
  std::vector<std::string> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Every frame's pose as frames.csv has it.
Trajectory all_frames(const CsvRows& frames);

}  // namespace plumbline::app
