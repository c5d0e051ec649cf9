#include "tracking/live_frame.h"

#include <algorithm>
#include <string>

#include "plumbline/error.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"

namespace plumbline {
namespace {

// KinectFusion's bilateral filter: 13×13 pixels, and a depth's deviation that keeps edges at a Kinect's noise.
constexpr int kBilateralRadius = 6;
constexpr double kBilateralSigmaSpace = 4.5;   // pixels
constexpr double kBilateralSigmaRange = 0.03;  // metres
constexpr float kDecimationRange = 0.09f;      // metres from the nearest: three of these deviations, as in the paper

/// Whether a reading survives `kernels::ToMetres`, by the same arithmetic.
bool any_in_range(const Frame& frame, const PreprocessParameters& parameters) {
  const auto metres_per_reading = static_cast<float>(1 / frame.depth_scale);
  const auto low = static_cast<float>(parameters.min_depth), high = static_cast<float>(parameters.max_depth);
  return std::any_of(frame.depth.pixels.begin(), frame.depth.pixels.end(), [&](std::uint16_t reading) {
    const float z = static_cast<float>(reading) * metres_per_reading;
    return z > 0 && z >= low && z <= high;
  });
}

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

}  // namespace

kernels::BilateralFilter bilateral_filter(const Plane<float>& depth, const Plane<float>& filtered) {
  return {read_only(depth), filtered.view(), kBilateralRadius,
          static_cast<float>(0.5 / (kBilateralSigmaSpace * kBilateralSigmaSpace)),
          static_cast<float>(0.5 / (kBilateralSigmaRange * kBilateralSigmaRange))};
}

void estimate_normals(const Backend& backend, DepthLevel& level) {
  estimate_plane_normals(backend, level, kNormalRadius, kNormalDepthGate);
}

LiveFrame::LiveFrame(const Pinhole& camera, const PreprocessParameters& parameters, int levels, const Backend& backend,
                     bool with_color, int finest_level)
    : backend_(&backend),
      parameters_(parameters),
      finest_level_(static_cast<std::size_t>(finest_level)),
      pyramid_(make_pyramid(camera, levels, backend)) {
  readings_ = {camera.width, camera.height, backend};
  raw_depth_ = {camera.width, camera.height, backend};
  if (with_color) color_ = {camera.width, camera.height, backend};
}

void LiveFrame::prepare(const Frame& frame) {
  if (frame.depth.width != raw_depth_.width() || frame.depth.height != raw_depth_.height())
    throw Error("the depth image is " + size_text(frame.depth.width, frame.depth.height) + " but the camera is " +
                    size_text(raw_depth_.width(), raw_depth_.height()),
                "frame " + std::to_string(frame.index), "all frames of a sequence must have one size");
  has_depth_ = any_in_range(frame, parameters_);
  upload(*backend_, frame.depth, readings_);
  to_metres(frame, raw_depth_);
  has_color_ = !color_.empty() && !frame.color.empty();
  if (has_color_) upload_color(frame.color);

  make_pyramid_of(frame);
  for (std::size_t level = finest_level_; level < pyramid_.size(); ++level)
    estimate_normals(*backend_, pyramid_[level]);
}

void LiveFrame::to_metres(const Frame& frame, const Plane<float>& depth) const {
  backend_->run(kernels::ToMetres{read_only(readings_), depth.view(), static_cast<float>(1 / frame.depth_scale),
                                  static_cast<float>(parameters_.min_depth),
                                  static_cast<float>(parameters_.max_depth)});
}

/// At the top the smoothed readings, or, without smoothing, the raw ones, which are needed twice only if that level is
/// tracked.
void LiveFrame::make_pyramid_of(const Frame& frame) {
  const Plane<float>* finer = &raw_depth_;
  if (parameters_.bilateral) {
    finer = &pyramid_.front().depth;
    backend_->run(bilateral_filter(raw_depth_, *finer));
  } else if (finest_level_ == 0) {
    to_metres(frame, pyramid_.front().depth);
  }
  for (std::size_t level = 1; level < pyramid_.size(); ++level) {
    backend_->run(kernels::DecimateDepth{read_only(*finer), pyramid_[level].depth.view(), kDecimationRange});
    finer = &pyramid_[level].depth;
  }
}

void LiveFrame::upload_color(const ColorImage& color) {
  if (color.width != color_.width() || color.height != color_.height())
    throw Error("the colour image is " + size_text(color.width, color.height) + " but the depth image is " +
                    size_text(color_.width(), color_.height()),
                "colour", "register the colour images to the depth images, or leave them out with --no-color");
  Image<std::int32_t> packed(color.width, color.height);
  for (std::size_t i = 0; i < packed.pixels.size(); ++i)
    packed.pixels[i] = color.pixels[3 * i] | color.pixels[3 * i + 1] << 8 | color.pixels[3 * i + 2] << 16;
  upload(*backend_, packed, color_);
}

}  // namespace plumbline
