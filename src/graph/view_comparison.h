// Whether two views can be of one place: what the one sees must not lie where the other looked through.
#pragma once

#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"

namespace plumbline {

/// Pixels of one view carried into the other.
struct ViewOverlap {
  int readings = 0;  ///< that were looked at
  int known = 0;     ///< of those, where the other view has a reading
  int on = 0;        ///< of those, on its surface within the noise
  int in_front = 0;  ///< of those, in space that the other view looked through

  double overlap() const { return readings > 0 ? static_cast<double>(known) / readings : 0; }
  double violation() const { return known > 0 ? static_cast<double>(in_front) / known : 1; }
  double agreement() const { return known > 0 ? static_cast<double>(on) / known : 0; }
};

/// Axial noise of a structured-light sensor at a depth (Nguyen, Izadi, Lovell 2012); metres.
double depth_sigma(double depth);

/// A reading lies in front of the other view's surface, or on it, by the noise of both and by what the surface does
/// within a pixel's neighbours: no limit depends on the scene. Every `stride`-th pixel along both axes.
ViewOverlap compare_views(const Image<float>& depth, const Image<float>& other, const Pinhole& camera,
                          const SE3& other_from_view, int stride);

}  // namespace plumbline
