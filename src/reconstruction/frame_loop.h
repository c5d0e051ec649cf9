// The one loop of a run: a frame from the source, through the pipeline, to whoever looks on.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/frame.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/pipeline.h"
#include "reconstruction/frame_source.h"

namespace plumbline {

/// A frame that the pipeline has processed.
struct ProcessedFrame {
  const Frame& frame;
  const FrameReport& report;
  const FrameDiagnostics& diagnostics;  ///< what an observer wanted
  ReadTimes read;
  std::optional<OrientationReading> reading;  ///< none without a sensor
  std::optional<LiveCounts> live;             ///< of a live run, so far
};

class FrameObserver {
 public:
  virtual ~FrameObserver() = default;

  /// Says what the pipeline is to keep of a frame that it is about to process.
  virtual void before([[maybe_unused]] const Frame& frame, [[maybe_unused]] FrameDiagnostics* diagnostics) {}
  virtual void observe(const ProcessedFrame& processed) = 0;
};

/// A line for the user while the run goes on.
using Note = std::function<void(const std::string& line)>;

/// Until the source has no more frames, or `stopping` returns true, which is asked before each frame. The observers are
/// called in their order. Throws what source, pipeline and observers throw.
void run_frames(FrameSource& source, Pipeline& pipeline, const std::vector<FrameObserver*>& observers,
                const std::function<bool()>& stopping, const Note& note);

}  // namespace plumbline
