// A frame on its way into the tracker: metres, smoothing, pyramid, normals. docs/method.md §1, "depth filter" to
// "normals".
#pragma once

#include "backend/maps.h"
#include "kernels/preprocess.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/parameters.h"
#include "plumbline/pinhole.h"

namespace plumbline {

/// Half window of the plane fit, pixels: 7×7.
constexpr int kNormalRadius = 3;
/// A neighbour belongs to the surface within this fraction of the depth.
constexpr float kNormalDepthGate = 0.03f;

/// KinectFusion's filter of the depth that is tracked.
kernels::BilateralFilter bilateral_filter(const Plane<float>& depth, const Plane<float>& filtered);

/// Of a level's measured depth, as every frame gets them.
void estimate_normals(const Backend& backend, DepthLevel& level);

/// The buffers of the current frame in a backend's memory, made once and used for every frame.
class LiveFrame {
 public:
  /// Levels finer than `finest_level` get no normals: they are not tracked.
  LiveFrame(const Pinhole& camera, const PreprocessParameters& parameters, int levels, const Backend& backend,
            bool with_color, int finest_level = 0);

  /// Uploads a frame and prepares it. Throws Error if its images are not of the camera's size.
  void prepare(const Frame& frame);

  const DepthPyramid& pyramid() const { return pyramid_; }            ///< smoothed depth and normals, for tracking
  const Plane<std::uint16_t>& readings() const { return readings_; }  ///< as they were taken
  const Plane<float>& raw_depth() const { return raw_depth_; }        ///< metres as measured, for fusion
  /// 0x00BBGGRR a pixel; empty when the frame has no colour.
  const Plane<std::int32_t>* color() const { return has_color_ ? &color_ : nullptr; }
  bool has_depth() const { return has_depth_; }

 private:
  void upload_color(const ColorImage& color);
  void to_metres(const Frame& frame, const Plane<float>& depth) const;
  void make_pyramid_of(const Frame& frame);

  const Backend* backend_;
  PreprocessParameters parameters_;
  std::size_t finest_level_;
  Plane<std::uint16_t> readings_;
  Plane<float> raw_depth_;
  Plane<std::int32_t> color_;
  DepthPyramid pyramid_;
  bool has_color_ = false, has_depth_ = false;
};

}  // namespace plumbline
