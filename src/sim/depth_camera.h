// A depth and colour camera that looks at a mesh: exact rays, and the errors of a structured-light sensor.
//
// The noise model, where it comes from:
//  · axial (along the optical axis) and lateral standard deviation as functions of depth and of the angle of incidence:
//    Nguyen, Izadi, Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and tracking", 3DIMPVT 2012;
//  · readings are steps of disparity: Khoshelham and Elberink, "Accuracy and resolution of Kinect depth data", Sensors
//    2012; lookup of a laterally shifted pixel, noise on the disparity, then rounding: Handa, Whelan, McDonald,
//    Davison, "A benchmark for RGB-D visual odometry, 3D reconstruction and SLAM", ICRA 2014;
//  · errors of neighbouring pixels are alike, as they share most of the matching window: Bohg, Romero, Herzog, Schaal,
//    "Robot arm pose estimation through pixel-wise part classification", ICRA 2014;
//  · each sensor bends disparity by a smooth pattern of its own, the same in every frame: Herrera, Kannala, Heikkilä,
//    "Joint depth and color camera calibration with distortion correction", PAMI 2012; centimetres at 2 to 3 m, as they
//    and Teichman, Miller, Thrun (CLAMS, RSS 2013) show;
//  · no reading where the projector's light does not reach (its shadow lies to the left of near things), where too
//    little of it comes back (reflectance, incidence and distance; ours), at grazing incidence (Nguyen et al. could not
//    measure beyond 70°; the ramp is ours), and at some pixels of depth edges.
//
// What the publications leave open is set by fr1/xyz and fr1/rpy of the TUM benchmark, never by how well a run tracks
// (bench/compare_noise.py, docs/results.md): `axial` by the residual of planes through 15×15 pixels between 0.6 and 2
// m; `correlation` by that residual's correlation at 2 and 4 pixels; `signal` by the share of pixels without a reading;
// `distortion` by the point-to-plane rms of registering fr1/xyz, which also holds what is not modelled: an upper bound.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "plumbline/frame.h"
#include "plumbline/mesh.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline::sim {

/// The defaults are a first-generation Kinect.
struct DepthNoise {
  double axial = 1.2;               ///< factor on the axial standard deviation
  double lateral = 1;               ///< factor on the lateral standard deviation
  double baseline = 0.075;          ///< metres from camera to projector
  double focal_length = 580;        ///< pixels; with the baseline it turns depth into disparity
  double disparity_step = 0.125;    ///< pixels; 0 = continuous
  double correlation = 6;           ///< pixels over which errors are alike, at least 1
  double distortion = 0.4;          ///< pixels of disparity rms, fixed over the image of one sensor (one seed)
  double min_range = 0.4;           ///< metres; nearer surfaces give no reading
  double max_range = 5.0;           ///< metres; neither do farther ones
  double grazing_start = 1.134464;  ///< radians from the normal at which holes begin (65°)
  double grazing_end = 1.483530;    ///< radians at which nothing is left (85°)
  double signal = 0.025;            ///< no reading where reflectance · cos(incidence) / (z/m)² is lower
  double edge_holes = 0.3;          ///< share of the pixels beside a depth edge that give no reading
  bool shadow = true;               ///< the projector's
};

/// Metres, of readings on a plane at depth z (metres) seen at `incidence` (radians from its normal): Nguyen et al.
/// 2012, eq. 5. Beyond 82° the value for 82°, as the formula grows without bounds.
double axial_sigma(double z, double incidence);
/// Pixels: Nguyen et al. 2012, eq. 1.
double lateral_sigma(double incidence);
/// Probability that a surface at this incidence gives no reading, beside shadow and edges.
double grazing_hole_rate(const DepthNoise& noise, double incidence);

struct DepthCameraOptions {
  Pinhole camera{525, 525, 319.5f, 239.5f, 640, 480};
  double depth_scale = 5000;  ///< readings per metre
  bool noise = true;          ///< false: exact depth, rounded to readings, whatever the range
  DepthNoise model;
  bool color = true;
  double readout = 0;        ///< seconds from the first row to the last (rolling shutter); 0 = all rows at once
  double exposure = 0;       ///< seconds over which the light is gathered; 0 = an instant
  int exposure_samples = 4;  ///< instants that stand for it, 1…64
  std::uint64_t seed = 1;
};

/// world_from_camera at a time in seconds.
using PoseAt = std::function<SE3(double seconds)>;

/// All members may be called from several threads at once.
class DepthCamera {
 public:
  /// Copies the mesh. Throws Error if an option is out of range or a triangle names a vertex that is not there.
  DepthCamera(const Mesh& mesh, const DepthCameraOptions& options);
  ~DepthCamera();
  DepthCamera(DepthCamera&&) noexcept;
  DepthCamera& operator=(DepthCamera&&) noexcept;

  const DepthCameraOptions& options() const { return options_; }

  /// The picture whose middle row is exposed around `seconds`. Its noise depends on the seed and `index` alone. Colour
  /// is the mesh's own, unlit; grey for a mesh without colours, black where there is no surface.
  Frame capture(const PoseAt& world_from_camera, double seconds, int index) const;
  /// Of a camera at rest.
  Frame capture(const SE3& world_from_camera, int index) const;

 private:
  class Implementation;
  DepthCameraOptions options_;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace plumbline::sim
