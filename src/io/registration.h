// Colour of a second camera, as the depth camera would see it.
#pragma once

#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline {

struct ColorRegistration {
  Pinhole depth, color;  ///< `depth` of images without distortion
  Distortion color_distortion;
  SE3 color_from_depth;  ///< metres

  /// An image of the depth camera's size: each reading's point is looked up in `image` between its pixels. Black where
  /// there is no reading or the colour camera does not see the point. Points that are hidden from the colour camera
  /// alone get the colour of what hides them, as everywhere where two lenses stand a few centimetres apart.
  ColorImage apply(const DepthImage& readings, double depth_scale, const ColorImage& image) const;
};

/// The depth image that a camera `to` at the same place would see of one of camera `from`: the nearest reading for each
/// pixel, 0 where `from` saw nothing. Both have the image's size.
DepthImage seen_through(const Pinhole& from, const Pinhole& to, const DepthImage& readings);

}  // namespace plumbline
