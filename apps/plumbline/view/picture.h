// Small images of what the camera sees.
#pragma once

#include "plumbline/image.h"

namespace plumbline::app {

/// Every n-th pixel of a frame: little to copy within the frame loop.
struct SmallFrame {
  DepthImage depth;
  ColorImage color;  ///< empty without colour
  double depth_scale = 0;
};
/// At most `max_width` pixels a row.
SmallFrame small_frame(const DepthImage& depth, const ColorImage& color, double depth_scale, int max_width);

/// Depth as colours, from near (warm) to far (cold); black: no reading.
ColorImage depth_colors(const DepthImage& depth, double depth_scale);

/// What the depth image says of the distance.
struct DepthStatistics {
  double share = 0;   ///< of the pixels that have a reading
  double median = 0;  ///< metres, of the readings; 0 without
};
DepthStatistics depth_statistics(const DepthImage& depth, double depth_scale);

/// How fast brightness changes from pixel to pixel, by how much it changes over four pixels: the less, the more the
/// image is smeared along its rows or columns, whichever is the worse. 0 for an image of one brightness.
double sharpness(const ColorImage& color);

}  // namespace plumbline::app
