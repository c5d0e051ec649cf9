#include "run/diagnostics.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "io/atomic_file.h"
#include "run/icp_trace.h"
#include "run/pixel_use.h"

namespace plumbline::app {
namespace {

bool contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

}  // namespace

DiagnosticsObserver::DiagnosticsObserver(std::string folder, Frames frames, Parameters parameters, Note note)
    : folder_(std::move(folder)),
      frames_(std::move(frames)),
      parameters_(std::move(parameters)),
      note_(std::move(note)) {}

void DiagnosticsObserver::before(const Frame& frame, FrameDiagnostics* diagnostics) {
  diagnostics->want_pixel_use = contains(frames_.pixel_use, frame.index);
  diagnostics->want_iterations = contains(frames_.icp, frame.index);
}

void DiagnosticsObserver::observe(const ProcessedFrame& processed) {
  const FrameDiagnostics& kept = processed.diagnostics;
  const int index = processed.report.index;
  if (kept.want_pixel_use)
    write(index, kept.pixel_use.empty(), fmt::format("pixel_use_{}.png", index),
          [&](const std::string& path) { write_pixel_use(path, kept.pixel_use); });
  if (kept.want_iterations)
    write(index, kept.iterations.empty(), fmt::format("icp_{}.json", index), [&](const std::string& path) {
      icp_traces_.push_back(icp_json(processed.report, kept.iterations, parameters_));
      write_file(path, icp_traces_.back());
    });
}

void DiagnosticsObserver::write(int index, bool is_empty, const std::string& name,
                                const std::function<void(const std::string&)>& writer) {
  const std::string path = (std::filesystem::path(folder_) / name).string();
  if (is_empty)
    note_(fmt::format("frame {} was not registered: no {}", index, path));
  else
    writer(path);
}

}  // namespace plumbline::app
