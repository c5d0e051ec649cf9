// Frame-to-model registration, coarse to fine: from a seed to a pose, and why it is believed.
#pragma once

#include <string_view>
#include <vector>

#include "backend/maps.h"
#include "core/parameters.h"
#include "core/se3.h"

namespace plumbline {

enum class TrackingStatus { initialised, tracked, lost };
enum class LostReason { none, no_depth, few_inliers, singular, implausible_step };
std::string_view to_string(TrackingStatus status);
std::string_view to_string(LostReason reason);

/// One 6×6 term on top of the registration's: 0.5 ξᵀ H ξ − bᵀ ξ, with ξ the left increment of world_from_camera.
struct NormalEquations {
  Matrix6d h = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
};

/// Something known beside the depth image: evaluated afresh at the estimate of every iteration.
class Prior {
 public:
  virtual ~Prior() = default;
  /// `matched_pixels` of `level_pixels` is what this iteration's association found.
  virtual NormalEquations evaluate(const SE3& world_from_camera, int matched_pixels, int level_pixels) const = 0;
};

/// Decides from the distance distributions whether a level has converged.
class ConvergenceTest {
 public:
  virtual ~ConvergenceTest() = default;
  virtual void start_level() = 0;
  virtual bool converged(const IcpSums& sums) = 0;
};

/// What the tracker starts from. The default is the plain KinectFusion of METHOD.md §1.
struct TrackingInput {
  SE3 world_from_model;                    ///< camera pose from which the model was predicted
  SE3 world_from_camera_seed;              ///< initial guess
  const Prior* prior = nullptr;            ///< none: registration alone
  ConvergenceTest* convergence = nullptr;  ///< none: the iterations of the parameters
};

/// What came out of one frame.
struct TrackingResult {
  TrackingStatus status = TrackingStatus::lost;
  LostReason reason = LostReason::none;
  SE3 world_from_camera;
  std::vector<int> iterations;  ///< per level, coarse to fine
  int inliers = 0;              ///< matched pixels of the last iteration
  double inlier_fraction = 0;   ///< of the pixels of the last level that have depth
  double rms = 0;               ///< point-to-plane residual of the matched pixels, metres
  double median_distance = 0;   ///< of the associated pairs, metres, at the histogram's resolution
  int rank = 0;                 ///< of the last 6×6 system, 6 when all directions are held
  double condition = 0;         ///< of the last 6×6 system after scaling
};

/// Levels of both pyramids needed: finest_level + number of entries of iterations.
int pyramid_levels(const TrackingParameters& parameters);

/// The gates of the parameters in a kernel's input, at an estimate.
void set_gates(const TrackingParameters& parameters, const SE3& model_from_live, kernels::IcpInput* in);

/// Registers `live` against `model` (METHOD.md §1, "association" and "minimisation").
TrackingResult track(const Backend& backend, const DepthPyramid& live, const DepthPyramid& model,
                     const TrackingInput& input, const TrackingParameters& parameters);

}  // namespace plumbline
