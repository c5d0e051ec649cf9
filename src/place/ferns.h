// Randomised ferns: a short code of what a depth image shows, so that images alike can be found among thousands without
// looking at them (Glocker, Shotton, Criminisi, Izadi, "Real-time RGB-D camera relocalization via randomized ferns",
// 2015). Here on depth and normals alone.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "plumbline/image.h"

namespace plumbline {

/// A view in few pixels: inverse depth (1/m) and normal of each, camera's frame; zeros where there is none.
struct Thumbnail {
  static constexpr int kWidth = 20, kHeight = 15, kChannels = 4;
  std::array<std::array<float, kChannels>, kWidth * kHeight> pixels{};
};

/// Depth and normals of a pyramid level on the host, averaged. Images of one size, metres and unit vectors.
Thumbnail make_thumbnail(const Image<float>& depth, const std::array<Image<float>, 3>& normals);

/// What every fern says of a view: 4 bits, or `kBlank` where it looks at a pixel without reading.
struct FernCode {
  static constexpr std::uint8_t kBlank = 255;
  std::vector<std::uint8_t> ferns;
};

/// Of the ferns that say something of both views, the share that differ; 1 where those are few.
double dissimilarity(const FernCode& a, const FernCode& b);

/// A fern asks of one pixel whether each of its channels is above a limit. Pixels and limits are drawn once, from a
/// fixed seed: codes of any two runs can be compared.
class Ferns {
 public:
  Ferns();
  FernCode encode(const Thumbnail& view) const;

 private:
  struct Fern {
    int pixel;
    std::array<float, Thumbnail::kChannels> limits;
  };
  std::vector<Fern> ferns_;
};

}  // namespace plumbline
