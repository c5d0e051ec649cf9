// What a user wants to see of single frames: their pixels' use as an image, their iterations as JSON.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "plumbline/parameters.h"
#include "reconstruction/frame_loop.h"

namespace plumbline::app {

/// Writes pixel_use_N.png and icp_N.json for the frames N that are listed, by their index in the sequence.
class DiagnosticsObserver : public FrameObserver {
 public:
  struct Frames {
    std::vector<int> pixel_use, icp;
  };

  DiagnosticsObserver(std::string folder, Frames frames, Parameters parameters, Note note);

  void before(const Frame& frame, FrameDiagnostics* diagnostics) override;
  /// Throws Error if a file cannot be written.
  void observe(const ProcessedFrame& processed) override;

  /// What was written to the files icp_N.json.
  const std::vector<std::string>& icp_traces() const { return icp_traces_; }

 private:
  /// `writer` makes the file at a path; a frame that was not registered has nothing to show.
  void write(int index, bool is_empty, const std::string& name, const std::function<void(const std::string&)>& writer);

  std::string folder_;
  Frames frames_;
  Parameters parameters_;
  Note note_;
  std::vector<std::string> icp_traces_;
};

}  // namespace plumbline::app
