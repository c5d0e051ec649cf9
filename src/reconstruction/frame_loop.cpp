#include "reconstruction/frame_loop.h"

namespace plumbline {

void run_frames(FrameSource& source, Pipeline& pipeline, const std::vector<FrameObserver*>& observers,
                const std::function<bool()>& stopping, const Note& note) {
  while (const std::optional<Frame> frame = source.next(stopping)) {
    FrameDiagnostics diagnostics;
    for (FrameObserver* observer : observers) observer->before(*frame, &diagnostics);
    const FrameReport report = pipeline.process(*frame, &diagnostics);
    const ProcessedFrame processed{*frame, report, diagnostics, source.read_times(), source.reading(), source.live()};
    for (FrameObserver* observer : observers) observer->observe(processed);
    for (const std::string& message : source.take_messages()) note(message);
  }
}

}  // namespace plumbline
