// `calibrate_depth`: which frames of a recording are tracked and compared, and whether what they tell is accepted.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/camera_path.h"
#include "calibration/depth_calibration.h"
#include "core/median.h"
#include "plumbline/angles.h"
#include "plumbline/calibration.h"
#include "plumbline/parameters.h"
#include "plumbline/trajectory.h"

namespace plumbline {
namespace {

// Four pieces of fifty frames, or of every fourth frame at most if the camera is slow, so that it sees as much of the
// scene. On fr1/xyz, pieces of sixty successive frames gave 87 pairs and made the run worse (0.012 to 0.014 m); every
// fourth frame gave 281 and made it better (0.011 m).
constexpr int kPieces = 4, kPieceFrames = 50, kAllPieces = kPieces * kPieceFrames, kMaxStride = 4;
constexpr double kCalmStep = radians(3.5);  // of view_change
constexpr std::size_t kMinRecordingFrames = 30, kMinRecordingPairs = 30;

// A distortion that is there takes 18 to 32 % off what pairs disagree by (fr1, simulated scenes); one that is not, or
// that cannot be told from a corridor's walls, at most 3 %, and taking it out then made the run a little worse.
constexpr double kMaxRemaining = 0.95;

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

/// Every how many-th frame of a camera that moved like this: a slow one sees more of the scene in the same number of
/// frames.
int calm_stride(const Trajectory& path) {
  if (path.size() < 2) return 1;
  std::vector<double> steps;
  for (std::size_t i = 1; i < path.size(); ++i)
    steps.push_back(view_change(path[i - 1].world_from_camera.inverse() * path[i].world_from_camera));
  return std::clamp(static_cast<int>(kCalmStep / std::max(median(std::move(steps)), 1e-6)), 1, kMaxStride);
}

/// At most so that all pieces together span the recording.
int max_stride(std::size_t frames) {
  return std::max(1, (4 * static_cast<int>(frames) + kAllPieces) / (4 * kAllPieces));
}

/// Pieces of a recording, tracked one after the other, each in its own world.
class PieceCalibration {
 public:
  PieceCalibration(const Sequence& sequence, const CalibrationOptions& options)
      : tracker_(sequence, options),
        calibration_(sequence.info().camera, options.parameters.preprocess, tracker_.backend(), kAllPieces),
        threads_(options.threads) {}

  void add(const std::vector<int>& piece) {
    calibration_.begin_piece();
    const Trajectory poses = tracker_.track(piece, {}, &calibration_).poses;
    path_.insert(path_.end(), poses.begin(), poses.end());
  }

  const Trajectory& path() const { return path_; }
  std::optional<DepthCalibrationResult> estimate() const {
    return calibration_.estimate(path_, DepthCalibration::Tracked::as_measured, threads_);
  }

 private:
  PathTracker tracker_;
  DepthCalibration calibration_;
  Trajectory path_;
  int threads_;
};

/// Why what was found is not accepted; empty if it is.
std::string reason_against(const std::optional<DepthCalibrationResult>& found) {
  if (!found) return "too few frames overlap after the camera has moved";
  if (found->pairs < kMinRecordingPairs)
    return fmt::format("only {} pairs of frames overlap after the camera has moved, and {} are needed", found->pairs,
                       kMinRecordingPairs);
  if (found->after > kMaxRemaining * found->before)
    return fmt::format("pairs of frames that judge it disagree by {:.1f} % {} without it, and {:.0f} % less are needed",
                       100 * std::abs(1 - found->after / found->before),
                       found->after > found->before ? "more than" : "less than", 100 * (1 - kMaxRemaining));
  return "";
}

}  // namespace

std::optional<DepthCalibrationResult> calibrate_depth(const Sequence& sequence, const std::vector<int>& frames,
                                                      const CalibrationOptions& options, std::string* refusal) {
  const auto refuse = [&](std::string why) {
    if (refusal != nullptr) *refusal = std::move(why);
    return std::optional<DepthCalibrationResult>();
  };
  if (frames.size() < kMinRecordingFrames)
    return refuse(fmt::format("{} frames tell too little, and {} are needed", frames.size(), kMinRecordingFrames));
  CalibrationOptions fast = options;
  fast.parameters = fast_parameters(options.parameters.preprocess);
  const std::vector<int> probe(frames.begin(),
                               frames.begin() + std::min<std::ptrdiff_t>(kPieceFrames, std::ssize(frames)));
  std::optional<PieceCalibration> calibration(std::in_place, sequence, fast);
  calibration->add(probe);
  const std::vector<std::vector<int>> pieces =
      pieces_of(frames, std::min(calm_stride(calibration->path()), max_stride(frames.size())));
  const bool starts_with_probe = pieces.front() == probe;
  if (!starts_with_probe) calibration.emplace(sequence, fast);
  for (std::size_t i = starts_with_probe ? 1 : 0; i < pieces.size(); ++i) calibration->add(pieces[i]);
  std::optional<DepthCalibrationResult> found = calibration->estimate();
  if (std::string why = reason_against(found); !why.empty()) return refuse(std::move(why));
  return found;
}

}  // namespace plumbline
