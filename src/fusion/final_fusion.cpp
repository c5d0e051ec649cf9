// `fuse_frames`: which voxels, how much memory, and the pass over the frames.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "backend/backend.h"
#include "core/median.h"
#include "fusion/fine_map.h"
#include "fusion/free_memory.h"
#include "fusion/mesh_cleanup.h"
#include "plumbline/backend.h"
#include "plumbline/error.h"
#include "plumbline/fusion.h"
#include "plumbline/pinhole.h"
#include "plumbline/prefetch.h"

namespace plumbline {
namespace {

// A voxel finer than the noise and the pixels shows them, not the surface.
constexpr double kFinest = 0.004, kCoarsest = 0.010, kStep = 0.0005;  // metres
constexpr std::size_t kSampledFrames = 16;
constexpr double kCoarser = 1.5;                              // voxels' growth where memory does not suffice
constexpr double kMinDetail = 0.0005, kMaxDetail = 1;         // metres, that make sense
constexpr std::size_t kUnknownMemory = std::size_t{1} << 30;  // taken where the system does not say

void check(const FusionOptions& options) {
  if (options.detail != 0 && !(options.detail >= kMinDetail && options.detail <= kMaxDetail))
    throw Error("the voxels' side is out of range", "final fusion", "Give 0.5 mm to 1 m.");
  if (options.min_readings < 1 || !(options.min_island >= 0))
    throw Error("a limit is out of range", "final fusion", "Give at least 1 reading, and islands from 0.");
}

/// Damaged frames say nothing.
std::optional<Frame> read_if_possible(const Sequence& sequence, int index) {
  try {
    return sequence.read(index);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Depths of some readings in range over the whole recording, metres.
std::vector<double> sampled_depths(const Sequence& sequence, const std::vector<FusionFrame>& frames,
                                   const PreprocessParameters& range) {
  constexpr std::size_t kEvery = 61;  // pixels: no divisor of a usual width
  std::vector<double> depths;
  const std::size_t step = (frames.size() + kSampledFrames - 1) / kSampledFrames;
  for (std::size_t i = 0; i < frames.size(); i += step) {
    const std::optional<Frame> frame = read_if_possible(sequence, frames[i].index);
    for (std::size_t k = 0; frame && k < frame->depth.pixels.size(); k += kEvery) {
      const double z = frame->depth.pixels[k] / frame->depth_scale;
      if (z > 0 && z >= range.min_depth && z <= range.max_depth) depths.push_back(z);
    }
  }
  return depths;
}

/// The median of a pixel's footprint or the noise, whichever is larger, and so large that nine of ten readings are near
/// enough to make a surface; within limits. docs/method.md §10.
double chosen_detail(std::vector<double> depths, double focal_length) {
  std::vector<double> resolutions;
  for (const double z : depths) resolutions.push_back(std::max(z / focal_length, reading_sigma(z)));
  const auto far = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() * 9 / 10);
  std::nth_element(depths.begin(), far, depths.end());
  const double detail = std::max(median(std::move(resolutions)), reading_sigma(*far) / FineMap::max_sigma(1));
  return std::clamp(kStep * std::round(detail / kStep), kFinest, kCoarsest);
}

/// Where that is more than a few.
void note_far_readings(const std::vector<double>& depths, FusionResult* result) {
  constexpr double kFew = 0.05;
  const double limit = FineMap::max_sigma(result->detail);
  const auto far = std::count_if(depths.begin(), depths.end(), [&](double z) { return reading_sigma(z) > limit; });
  const double share = static_cast<double>(far) / static_cast<double>(depths.size());
  if (share < kFew) return;
  result->notes.push_back(fmt::format(
      "{:.0f} % of the readings are too far for voxels of {:.1f} mm, with a noise of more than {:.0f} mm: they make no "
      "surface (a larger --detail reaches farther)",
      100 * share, 1e3 * result->detail, 1e3 * limit));
}

enum class Pass { done, stopped, no_room };

/// One attempt with voxels of one size.
class FusionPass {
 public:
  FusionPass(const Sequence& sequence, const std::vector<FusionFrame>& frames, const FusionOptions& options)
      : sequence_(sequence), frames_(frames), options_(options) {}

  Pass run(FineMap* map, FusionResult* result) const {
    std::vector<int> indices;
    for (const FusionFrame& frame : frames_) indices.push_back(frame.index);
    Prefetcher reader(sequence_, std::move(indices));
    result->frames = 0;
    result->notes.clear();
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (options_.stopping && options_.stopping()) return Pass::stopped;
      const std::optional<Frame> frame = next(&reader, result);
      const auto fused = frame ? map->fuse(*frame, frames_[i].world_from_camera) : FineMap::Fused::nothing;
      if (fused == FineMap::Fused::no_room) return Pass::no_room;
      result->frames += fused == FineMap::Fused::yes ? 1 : 0;
      if (options_.on_progress) options_.on_progress({static_cast<int>(i) + 1, static_cast<int>(frames_.size())});
    }
    return Pass::done;
  }

 private:
  static std::optional<Frame> next(Prefetcher* reader, FusionResult* result) {
    try {
      return reader->next();
    } catch (const Error& error) {
      result->notes.push_back(fmt::format("a frame could not be read again: {}", error.what()));
      return std::nullopt;
    }
  }

  const Sequence& sequence_;
  const std::vector<FusionFrame>& frames_;
  const FusionOptions& options_;
};

std::size_t memory_limit(const FusionOptions& options, const Backend& backend) {
  if (options.memory != 0) return options.memory;
  const std::size_t of_device = backend.free_memory(), free = of_device != 0 ? of_device : free_memory();
  return free != 0 ? free / 2 : kUnknownMemory;
}

/// The finest that the expected surface leaves room for; the wanted one if nobody knows what to expect.
double detail_that_fits(double detail, double area, std::size_t max_bricks) {
  while (detail < kMaxDetail && FineMap::expected_bricks(area, detail) > static_cast<double>(max_bricks))
    detail *= kCoarser;
  return detail;
}

void note_coarser(double wanted, double detail, std::size_t memory, FusionResult* result) {
  if (detail == wanted) return;
  result->notes.push_back(
      fmt::format("voxels of {:.1f} mm instead of {:.1f}, as finer ones need more than {:.1f} GB of memory",
                  1e3 * detail, 1e3 * wanted, 1e-9 * static_cast<double>(memory)));
}

void finish(const FineMap& map, const FusionOptions& options, FusionResult* result) {
  result->bricks = map.bricks();
  result->bytes = map.bytes();
  result->mesh = map.extract_mesh(options.min_readings);
  const double side = options.min_island * result->detail;
  result->islands = remove_islands(side * side, &result->mesh);
  if (options.max_triangles > 0) simplify(options.max_triangles, &result->mesh);
}

}  // namespace

std::optional<FusionResult> fuse_frames(const Sequence& sequence, const std::vector<FusionFrame>& frames,
                                        const FusionOptions& options) {
  check(options);
  if (frames.empty()) return std::nullopt;
  const std::shared_ptr<Backend> backend = make_backend(options.backend, options.threads);
  const bool color = options.color && sequence.info().color_frames > 0;
  const std::size_t memory = memory_limit(options, *backend), max_bricks = memory / FineMap::bytes_per_brick(color);
  const std::vector<double> depths = sampled_depths(sequence, frames, options.preprocess);
  if (depths.empty()) return std::nullopt;
  const double wanted =
      options.detail != 0 ? options.detail : chosen_detail(depths, std::abs(double{sequence.info().camera.fx}));
  FusionResult result;
  for (result.detail = detail_that_fits(wanted, options.expected_area, max_bricks);; result.detail *= kCoarser) {
    FineMap map(sequence.info().camera, {result.detail, max_bricks, color, options.preprocess}, *backend);
    const Pass pass = FusionPass(sequence, frames, options).run(&map, &result);
    if (pass == Pass::stopped) return std::nullopt;
    if (pass == Pass::no_room && result.detail * kCoarser <= kMaxDetail) continue;
    if (pass == Pass::no_room) throw std::bad_alloc();
    if (result.frames == 0) return std::nullopt;
    note_coarser(wanted, result.detail, memory, &result);
    note_far_readings(depths, &result);
    finish(map, options, &result);
    return result;
  }
}

}  // namespace plumbline
