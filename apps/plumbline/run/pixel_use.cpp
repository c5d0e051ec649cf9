#include "run/pixel_use.h"

#include <algorithm>
#include <array>

#include "io/images/png.h"
#include "kernels/icp.h"
#include "plumbline/mesh.h"

namespace plumbline::app {
namespace {

/// In the order of kernels::PixelUse.
constexpr std::array<Mesh::Rgb, 8> kUsePalette = {{{64, 160, 72},     // used
                                                   {0, 0, 0},         // no depth
                                                   {120, 120, 120},   // no normal
                                                   {52, 96, 190},     // out of view
                                                   {128, 72, 160},    // no model
                                                   {205, 48, 40},     // distance
                                                   {240, 140, 30},    // angle
                                                   {245, 220, 60}}};  // filtered
static_assert(kUsePalette.size() == static_cast<std::size_t>(kernels::PixelUse::filtered) + 1);

}  // namespace

void write_pixel_use(const std::string& path, const Image<std::uint8_t>& codes) {
  ColorImage picture(codes.width, codes.height, 3);
  for (std::size_t i = 0; i < codes.pixels.size(); ++i) {
    const Mesh::Rgb& color = kUsePalette[std::min<std::size_t>(codes.pixels[i], kUsePalette.size() - 1)];
    picture.pixels[3 * i] = color.r;
    picture.pixels[3 * i + 1] = color.g;
    picture.pixels[3 * i + 2] = color.b;
  }
  write_color_png(path, picture);
}

}  // namespace plumbline::app
