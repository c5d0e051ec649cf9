#include "run/tracked_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "backend/backend.h"
#include "calibration/depth_calibration_file.h"
#include "cli/interrupt.h"
#include "cli/progress.h"
#include "core/median.h"
#include "io/prefetch.h"
#include "plumbline/error.h"
#include "plumbline/pipeline.h"
#include "plumbline/trajectory.h"
#include "run/frame_source.h"

namespace plumbline::app {
namespace {

// Before a run: four pieces of fifty frames, or of every fourth frame at most if the camera is slow, so that it sees as
// much of the scene. On fr1/xyz, pieces of sixty successive frames gave 87 pairs and made the run worse (0.012 to
// 0.014 m); every fourth frame gave 281 and made it better (0.011 m).
constexpr int kPieces = 4, kPieceFrames = 50, kAllPieces = kPieces * kPieceFrames, kWidestStride = 4;
constexpr double kCalmStep = 3.5 * std::numbers::pi / 180;  // of view_change
constexpr std::size_t kFewestFrames = 100, kFewestPairs = 100;

// A distortion that is there takes 18 to 32 % off what pairs disagree by (fr1, simulated scenes); one that is not, or
// that cannot be told from a corridor's walls, at most 3 %, and taking it out then made the run a little worse.
constexpr double kLeastGain = 0.95;

// The second time the path is held by what the first made of it: mountings of three hard dances err by 0.044°, 0.090°
// and 0.042° in place of 0.059°, 0.103° and 0.059°.
constexpr int kPathRounds = 2;

using Tracked = DepthCalibration::Tracked;

class PathTracker {
 public:
  /// `stopping` is asked before each frame.
  PathTracker(const Sequence& sequence, const TrackingOptions& options, std::function<bool()> stopping)
      : sequence_(sequence),
        options_(options),
        stopping_(std::move(stopping)),
        backend_(make_backend(options.backend, options.threads)) {}

  Backend& backend() { return *backend_; }

  /// One pass. `calibration`, if there is one, gets the frames as they were measured.
  TrackedPath track(const std::vector<int>& indices, const DepthDistortion& distortion, DepthCalibration* calibration) {
    Pipeline pipeline(options_.parameters, sequence_.info().camera, *backend_);
    Progress progress(static_cast<int>(indices.size()), options_.quiet);
    Prefetcher reader(sequence_, indices);
    TrackedPath path;
    while (std::optional<Frame> frame = reader.next()) {
      if (stopping_()) throw Error("interrupted", sequence_.info().path, "");
      if (calibration != nullptr) calibration->add(*frame);
      distortion.correct(frame->depth_scale, &frame->depth);
      const FrameReport report = pipeline.process(*frame);
      ++path.frames;
      if (report.tracking.status != TrackingStatus::lost) path.poses.push_back({report.time, report.world_from_camera});
      const int tracked = static_cast<int>(path.poses.size());
      progress.update(path.frames, tracked, path.frames - tracked);
    }
    return path;
  }

 private:
  const Sequence& sequence_;
  const TrackingOptions& options_;
  std::function<bool()> stopping_;
  std::shared_ptr<Backend> backend_;
};

Parameters quick_parameters(const PreprocessParameters& range) {
  Parameters parameters = preset("plumbline");
  apply_quality("fast", &parameters);
  parameters.preprocess.min_depth = range.min_depth;
  parameters.preprocess.max_depth = range.max_depth;
  return parameters;
}

/// Every `stride`-th frame in pieces that are evenly spread over a long run; a short run in one piece.
std::vector<std::vector<int>> pieces_of(const std::vector<int>& frames, int stride) {
  const int count = static_cast<int>(frames.size());
  const int length = std::min(kPieceFrames * stride, count);
  const int number = count <= kAllPieces * stride ? 1 : kPieces;
  std::vector<std::vector<int>> pieces;
  for (int piece = 0; piece < number; ++piece) {
    const int first = number == 1 ? 0 : piece * (count - length) / (number - 1);
    const int end = number == 1 ? count : first + length;
    pieces.emplace_back();
    for (int i = first; i < end; i += stride) pieces.back().push_back(frames[static_cast<std::size_t>(i)]);
  }
  return pieces;
}

/// How many frames a camera that moved like this may skip: slow ones see more of the scene in as many frames.
int calm_stride(const Trajectory& path) {
  if (path.size() < 2) return 1;
  std::vector<double> steps;
  for (std::size_t i = 1; i < path.size(); ++i)
    steps.push_back(view_change(path[i - 1].world_from_camera.inverse() * path[i].world_from_camera));
  return std::clamp(static_cast<int>(kCalmStep / std::max(median(std::move(steps)), 1e-6)), 1, kWidestStride);
}

}  // namespace

TrackedPath track_path(const Sequence& sequence, const TrackingOptions& options) {
  const InterruptGuard interrupt;
  PathTracker tracker(sequence, options, [&] { return interrupt.signal() != 0; });
  const std::vector<int> frames = chosen_frames(sequence, options.max_frames);
  DepthCalibration calibration(sequence.info().camera, options.parameters.preprocess, tracker.backend(),
                               static_cast<int>(frames.size()));
  TrackedPath path = tracker.track(frames, {}, &calibration);
  if (options.calibrate_depth)
    if (const auto rough = calibration.estimate(path.poses, Tracked::as_measured, options.threads))
      path = tracker.track(frames, rough->distortion, nullptr);
  for (int round = 0; round < kPathRounds; ++round) {
    auto found = calibration.estimate(path.poses, Tracked::straightened, options.threads);
    if (!found) break;
    path.poses = found->path;
    if (options.calibrate_depth) path.depth = std::move(found);
  }
  return path;
}

std::optional<DepthCalibrationResult> calibrate_depth(const Sequence& sequence, const std::vector<int>& frames,
                                                      const TrackingOptions& options,
                                                      const std::function<bool()>& stopping) {
  if (frames.size() < kFewestFrames) return std::nullopt;
  TrackingOptions quick = options;
  quick.parameters = quick_parameters(options.parameters.preprocess);
  quick.quiet = true;
  PathTracker tracker(sequence, quick, stopping);
  std::optional<DepthCalibration> calibration;
  Trajectory path;
  const auto begin = [&] {
    calibration.emplace(sequence.info().camera, quick.parameters.preprocess, tracker.backend(), kAllPieces);
    path.clear();
  };
  const auto add = [&](const std::vector<int>& piece) {
    calibration->begin_piece();
    const Trajectory poses = tracker.track(piece, {}, &*calibration).poses;
    path.insert(path.end(), poses.begin(), poses.end());
  };
  const std::vector<int> probe(frames.begin(), frames.begin() + kPieceFrames);
  begin();
  add(probe);
  const int widest = std::max(1, (4 * static_cast<int>(frames.size()) + kAllPieces) / (4 * kAllPieces));
  const std::vector<std::vector<int>> pieces = pieces_of(frames, std::min(calm_stride(path), widest));
  auto piece = pieces.begin();
  if (*piece == probe)
    ++piece;
  else
    begin();
  for (; piece != pieces.end(); ++piece) add(*piece);
  std::optional<DepthCalibrationResult> found = calibration->estimate(path, Tracked::as_measured, options.threads);
  if (!found || found->pairs < kFewestPairs || found->after > kLeastGain * found->before) return std::nullopt;
  return found;
}

void save_depth_calibration(const std::string& path, const DepthCalibrationResult& found,
                            const std::string& command_line) {
  write_depth_calibration(
      path, found.distortion,
      {"How a depth camera bends what it sees, for `--depth-calibration FILE`. Made by", command_line,
       fmt::format("from {} pairs of frames; they disagree by {:.4f}/m before, {:.4f}/m after.", found.pairs,
                   found.before, found.after)});
}

}  // namespace plumbline::app
