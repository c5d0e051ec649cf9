#include "plumbline/frame.h"

namespace plumbline {

DepthImage readings_of(const Image<float>& metres, double depth_scale) {
  DepthImage depth(metres.width, metres.height);
  for (std::size_t i = 0; i < metres.pixels.size(); ++i) {
    const double reading = metres.pixels[i] * depth_scale + 0.5;
    depth.pixels[i] = reading >= 1 && reading < 65536 ? static_cast<std::uint16_t>(reading) : std::uint16_t{0};
  }
  return depth;
}

}  // namespace plumbline
