#include "place/ferns.h"

#include <cmath>

#include "core/random.h"

namespace plumbline {
namespace {

constexpr int kFerns = 500;
constexpr int kMinCompared = 100;  // of the ferns, for a share to mean something

using Pixel = std::array<float, Thumbnail::kChannels>;

/// The average of a cell's valid pixels; zeros where those are less than a quarter of it.
Pixel average(const Image<float>& depth, const std::array<Image<float>, 3>& normals, int x0, int x1, int y0, int y1) {
  Pixel sum{};
  int valid = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Pixel normal = {0, normals[0].at(x, y), normals[1].at(x, y), normals[2].at(x, y)};
      const bool has_normal = normal[1] != 0 || normal[2] != 0 || normal[3] != 0;
      if (!(depth.at(x, y) > 0) || !has_normal) continue;
      sum[0] += 1 / depth.at(x, y);
      for (std::size_t c = 1; c < sum.size(); ++c) sum[c] += normal[c];
      ++valid;
    }
  }
  if (valid == 0 || 4 * valid < (x1 - x0) * (y1 - y0)) return {};
  for (float& value : sum) value /= static_cast<float>(valid);
  return sum;
}

}  // namespace

Thumbnail make_thumbnail(const Image<float>& depth, const std::array<Image<float>, 3>& normals) {
  Thumbnail view;
  const auto edge = [](int cell, int cells, int size) { return cell * size / cells; };
  for (int y = 0; y < Thumbnail::kHeight; ++y) {
    for (int x = 0; x < Thumbnail::kWidth; ++x)
      view.pixels[static_cast<std::size_t>(y * Thumbnail::kWidth + x)] =
          average(depth, normals, edge(x, Thumbnail::kWidth, depth.width), edge(x + 1, Thumbnail::kWidth, depth.width),
                  edge(y, Thumbnail::kHeight, depth.height), edge(y + 1, Thumbnail::kHeight, depth.height));
  }
  return view;
}

double dissimilarity(const FernCode& a, const FernCode& b) {
  int compared = 0, different = 0;
  for (std::size_t i = 0; i < a.ferns.size() && i < b.ferns.size(); ++i) {
    if (a.ferns[i] == FernCode::kBlank || b.ferns[i] == FernCode::kBlank) continue;
    ++compared;
    different += a.ferns[i] != b.ferns[i];
  }
  return compared < kMinCompared ? 1 : static_cast<double>(different) / compared;
}

/// The limits span what a hand-held camera sees indoors: surfaces at 0.5 to 5 m, turned by up to 60°.
Ferns::Ferns() {
  constexpr std::uint64_t kKey = 0x706c616365ULL;
  Random random(kKey);
  ferns_.reserve(kFerns);
  for (int i = 0; i < kFerns; ++i) {
    Fern fern{};
    fern.pixel = random.below(Thumbnail::kWidth * Thumbnail::kHeight);
    fern.limits = {static_cast<float>(1 / random.uniform(0.5, 5)), static_cast<float>(random.uniform(-0.8, 0.8)),
                   static_cast<float>(random.uniform(-0.8, 0.8)), static_cast<float>(random.uniform(-1, -0.2))};
    ferns_.push_back(fern);
  }
}

FernCode Ferns::encode(const Thumbnail& view) const {
  FernCode code;
  code.ferns.reserve(ferns_.size());
  for (const Fern& fern : ferns_) {
    const Pixel& pixel = view.pixels[static_cast<std::size_t>(fern.pixel)];
    unsigned bits = 0;
    for (std::size_t c = 0; c < pixel.size(); ++c) bits |= pixel[c] > fern.limits[c] ? 1u << c : 0u;
    code.ferns.push_back(pixel[0] > 0 ? static_cast<std::uint8_t>(bits) : FernCode::kBlank);
  }
  return code;
}

}  // namespace plumbline
