// What a volume does when its window moves: bricks that leave it are copied out and their slots cleared, bricks that
// enter it are copied in.
#pragma once

#include "kernels/brick_map.h"
#include "kernels/lane.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

/// Marks the bricks that hold or held a surface and will not be in the window. Lanes run along x over bricks.
struct MarkLeavingBricks {
  BrickMap volume;
  VoxelPosition move;    ///< of the window, counted in bricks
  std::int32_t* marked;  ///< 1 or 0 per brick, `state_words()` of them

  template <class F>
  PL_HD void operator()(int x, int row) const {
    const BrickLanes<F> bricks = volume.bricks_at<F>(x, row);
    const Vec3<F> p = bricks.positions();
    const auto stays = stays_along<F>(p.x, move.x) && stays_along<F>(p.y, move.y) && stays_along<F>(p.z, move.z);
    const auto has_data = to_float(bricks.states()) > F(0.5f);
    bricks.store(marked, to_int(select(has_data && !stays, F(1.0f), F(0.0f))));
  }

 private:
  template <class F>
  PL_HD Mask<F> stays_along(const F& position, int by) const {
    return position >= F(static_cast<float>(by)) && position < F(static_cast<float>(by + volume.bricks_per_row()));
  }
};

/// Bricks outside a volume: kBrickVoxels words each of voxels and colours (null without), one after the other, and a
/// state.
struct BrickCopies {
  std::int32_t *voxels, *colors, *states;
};

/// Copies the listed bricks out and clears their slots; one call is one brick.
struct TakeBrick {
  BrickMap volume;
  const std::int32_t* list;
  BrickCopies copies;

  PL_HD void operator()(int entry) const {
    const int brick = list[entry];
    take(volume.voxels_of(brick), copies.voxels, entry);
    if (volume.has_color()) take(volume.colors_of(brick), copies.colors, entry);
    copies.states[entry] = volume.state(brick);
    volume.state(brick) = 0;
  }

 private:
  PL_HD static void take(std::int32_t* words, std::int32_t* copies_of_all, int entry) {
    std::int32_t* copy = copies_of_all + static_cast<std::ptrdiff_t>(entry) * kBrickVoxels;
    for (int i = 0; i < kBrickVoxels; ++i) {
      copy[i] = words[i];
      words[i] = 0;
    }
  }
};

/// Copies bricks into the listed slots; one call is one brick.
struct PutBrick {
  BrickMap volume;
  const std::int32_t* list;
  BrickCopies copies;

  PL_HD void operator()(int entry) const {
    const int brick = list[entry];
    put(volume.voxels_of(brick), copies.voxels, entry);
    if (volume.has_color()) put(volume.colors_of(brick), copies.colors, entry);
    volume.state(brick) = copies.states[entry];
  }

 private:
  PL_HD static void put(std::int32_t* words, const std::int32_t* copies_of_all, int entry) {
    const std::int32_t* copy = copies_of_all + static_cast<std::ptrdiff_t>(entry) * kBrickVoxels;
    for (int i = 0; i < kBrickVoxels; ++i) words[i] = copy[i];
  }
};

}  // namespace plumbline::kernels
