// The model's memory as kernels see it, and the only place that knows how a voxel is found. Voxels stand in bricks of
// 8³; whoever needs one asks for its brick, for the voxels of a brick, or for the neighbours of a point or of a brick.
// This map is a dense cube of bricks, a window on the world that can move by whole bricks: its memory is a ring along
// each axis, so that what stays in the window stays where it is kept. All positions are those in the window.
#pragma once

#include "kernels/lane.h"
#include "plumbline/vec3.h"

namespace plumbline::kernels {

constexpr int kBrickSide = 8;
constexpr int kBrickVoxels = kBrickSide * kBrickSide * kBrickSide;
/// A brick's state. One that is solid holds a voxel behind a surface; one that is free held a surface once, but now
/// only voxels before it; every other brick is 0 and has held none.
constexpr std::int32_t kBrickSolid = 1, kBrickFree = 2;

/// Counted in voxels, from the lowest corner of the volume or of a brick.
struct VoxelPosition {
  int x, y, z;
};

/// Where a voxel is kept.
struct VoxelAddress {
  int brick;   ///< −1 where the map has none
  int offset;  ///< within the brick, below kBrickVoxels
};

/// The position in its brick of the voxel at an offset.
PL_HD VoxelPosition position_in_brick(int offset) { return {offset & 7, offset >> 3 & 7, offset >> 6}; }
/// The offset in its brick of the voxel at a position.
PL_HD int offset_in_brick(const VoxelPosition& p) { return (p.x & 7) | (p.y & 7) << 3 | (p.z & 7) << 6; }
/// The brick that the voxel at a position lies in, counted in bricks; positions may be negative.
PL_HD VoxelPosition brick_of(const VoxelPosition& p) { return {p.x >> 3, p.y >> 3, p.z >> 3}; }
/// The lowest voxel of the brick at a position that is counted in bricks.
PL_HD VoxelPosition first_voxel_of(const VoxelPosition& b) {
  return {b.x * kBrickSide, b.y * kBrickSide, b.z * kBrickSide};
}
/// What the voxels of a lane's worth of offsets are off from the first one's centre, counted in voxels: along x, and
/// beyond eight lanes in the next row. The first offset must be a multiple of the lane's width.
template <class F>
PL_HD Vec3<F> voxel_lanes() {
  const Int<F> lane = Lane<F>::int_index();
  return {to_float(lane & Int<F>(7)), to_float(shift_right<3>(lane)), F(0.0f)};
}

template <class F>
class BrickLanes;
template <class F>
class VoxelNeighbours;
class BrickNeighbours;

/// The voxel that a point lies in and its brick, a lane each.
template <class F>
class VoxelLanes {
 public:
  /// The brick's position in the window, counted in bricks.
  PL_HD Vec3<F> brick_position() const { return {to_float(bx_), to_float(by_), to_float(bz_)}; }

 private:
  friend class BrickMap;
  Int<F> bx_, by_, bz_, brick_, voxel_;
};

/// Voxel (i, j, k) is centred at (i + ½, j + ½, k + ½)·voxel_size in the volume's frame. A voxel is one word (voxel.h),
/// its colour another: a byte each of red, green, blue and weight. A brick is named by a number below `slots()`.
class BrickMap {
 public:
  float voxel_size = 0;  ///< metres
  float truncation = 0;  ///< metres

  BrickMap() = default;
  /// A cube of `resolution` voxels per side, rounded up to whole bricks. It needs memory: see `keep_in`.
  explicit BrickMap(int resolution)
      : bricks_((resolution + kBrickSide - 1) / kBrickSide), brick_stride_((bricks_ + 15) / 16 * 16) {}
  /// Memory of zeros: `voxel_words()` each of voxels and colours (null without), and `state_words()`.
  void keep_in(std::int32_t* voxels, std::int32_t* colors, std::int32_t* states) {
    voxels_ = voxels;
    colors_ = colors;
    states_ = states;
  }

  /// Moves the window by so many bricks along each axis. The slots of bricks that leave it are those of bricks that
  /// enter it: they must be cleared.
  void move(const VoxelPosition& bricks) {
    start_ = {ring(start_.x + bricks.x), ring(start_.y + bricks.y), ring(start_.z + bricks.z)};
  }

  PL_HD int resolution() const { return bricks_ * kBrickSide; }       ///< voxels per side
  PL_HD float brick_size() const { return voxel_size * kBrickSide; }  ///< metres
  PL_HD bool has_color() const { return colors_ != nullptr; }

  // Bricks.
  PL_HD int slots() const { return bricks_ * bricks_ * brick_stride_; }
  /// Elements of an array with one for each slot that `BrickLanes` loads from or stores to.
  PL_HD int state_words() const { return slots() + 16; }
  std::size_t voxel_words() const { return static_cast<std::size_t>(slots()) * kBrickVoxels; }
  PL_HD std::int32_t* states() const { return states_; }  ///< one for each slot
  PL_HD std::int32_t& state(int brick) const { return states_[brick]; }
  /// All bricks are those of `brick_rows()` rows with `bricks_per_row()` each, in the order of their memory.
  PL_HD int bricks_per_row() const { return bricks_; }
  PL_HD int brick_rows() const { return bricks_ * bricks_; }
  /// The bricks of a row from its x-th on, a lane each.
  template <class F>
  PL_HD BrickLanes<F> bricks_at(int x, int row) const {
    return {*this, x, row % bricks_, row / bricks_};
  }
  PL_HD bool has_brick(const VoxelPosition& b) const {
    return b.x >= 0 && b.y >= 0 && b.z >= 0 && b.x < bricks_ && b.y < bricks_ && b.z < bricks_;
  }
  /// The brick at a position in the window, counted in bricks.
  PL_HD int slot_of(const VoxelPosition& b) const { return brick_index<std::int32_t>(b.x, b.y, b.z); }
  /// A brick's lowest voxel.
  PL_HD VoxelPosition origin_of(int brick) const {
    const int rest = brick / brick_stride_;
    return {unroll<std::int32_t>(brick % brick_stride_, start_.x) * kBrickSide,
            unroll<std::int32_t>(rest % bricks_, start_.y) * kBrickSide,
            unroll<std::int32_t>(rest / bricks_, start_.z) * kBrickSide};
  }

  // The voxels of a brick: kBrickVoxels words, row by row.
  PL_HD std::int32_t* voxels_of(int brick) const { return voxels_ + static_cast<std::ptrdiff_t>(brick) * kBrickVoxels; }
  PL_HD std::int32_t* colors_of(int brick) const { return colors_ + static_cast<std::ptrdiff_t>(brick) * kBrickVoxels; }
  /// Centre of the voxel at an offset, metres.
  PL_HD Vec3<float> centre_of(int brick, int offset) const {
    const VoxelPosition first = origin_of(brick), p = position_in_brick(offset);
    return {(static_cast<float>(first.x + p.x) + 0.5f) * voxel_size,
            (static_cast<float>(first.y + p.y) + 0.5f) * voxel_size,
            (static_cast<float>(first.z + p.z) + 0.5f) * voxel_size};
  }
  /// `voxel_lanes` in metres.
  template <class F>
  PL_HD Vec3<F> lane_offsets() const {
    return voxel_lanes<F>() * voxel_size;
  }

  // One voxel.
  PL_HD VoxelAddress find(const VoxelPosition& p) const { return {slot_of(brick_of(p)), offset_in_brick(p)}; }
  PL_HD std::int32_t& voxel(const VoxelAddress& at) const { return voxels_of(at.brick)[at.offset]; }
  PL_HD std::int32_t& color(const VoxelAddress& at) const { return colors_of(at.brick)[at.offset]; }

  // The voxel at a point, a lane each; the point is counted in voxels and clamped to the window.
  template <class F>
  PL_HD VoxelLanes<F> voxels_at(const Vec3<F>& p) const {
    const F zero(0.0f), high(static_cast<float>(resolution()) - 0.01f);
    const Int<F> x = to_int(min(max(p.x, zero), high)), y = to_int(min(max(p.y, zero), high)),
                 z = to_int(min(max(p.z, zero), high)), seven(7);
    VoxelLanes<F> at;
    at.bx_ = shift_right<3>(x);
    at.by_ = shift_right<3>(y);
    at.bz_ = shift_right<3>(z);
    at.brick_ = brick_index(at.bx_, at.by_, at.bz_);
    const Int<F> local = (x & seven) + shift_left<3>(y & seven) + shift_left<6>(z & seven);
    at.voxel_ = shift_left<9>(at.brick_) + local;
    return at;
  }
  template <class F>
  PL_HD Int<F> states_of(const VoxelLanes<F>& at) const {
    return gather_int(states_, at.brick_);
  }
  template <class F>
  PL_HD Int<F> words_of(const VoxelLanes<F>& at) const {
    return gather_int(voxels_, at.voxel_);
  }

 private:
  template <class F>
  friend class BrickLanes;
  template <class F>
  friend class VoxelNeighbours;
  friend class BrickNeighbours;

  int ring(int position) const { return (position % bricks_ + bricks_) % bricks_; }
  // From a position in the window, counted in bricks, to that in the ring, and back.
  template <class I>
  PL_HD I roll(const I& position, int start) const {
    return wrap_int(position + I(start), bricks_);
  }
  template <class I>
  PL_HD I unroll(const I& position, int start) const {
    return wrap_int(position + I(bricks_ - start), bricks_);
  }
  template <class I>
  PL_HD I slot_index(const I& x, const I& y, const I& z) const {
    return (z * I(bricks_) + y) * I(brick_stride_) + x;
  }
  template <class I>
  PL_HD I brick_index(const I& bx, const I& by, const I& bz) const {
    return slot_index<I>(roll(bx, start_.x), roll(by, start_.y), roll(bz, start_.z));
  }
  // A voxel's index is the sum of one term an axis, so that neighbours share terms.
  template <class I>
  PL_HD I term_x(const I& x) const {
    return shift_left<9>(roll<I>(shift_right<3>(x), start_.x)) + (x & I(7));
  }
  template <class I>
  PL_HD I term_y(const I& y) const {
    return shift_left<9>(roll<I>(shift_right<3>(y), start_.y) * I(brick_stride_)) + shift_left<3>(y & I(7));
  }
  template <class I>
  PL_HD I term_z(const I& z) const {
    return shift_left<9>(roll<I>(shift_right<3>(z), start_.z) * I(brick_stride_ * bricks_)) + shift_left<6>(z & I(7));
  }

  std::int32_t *voxels_ = nullptr, *colors_ = nullptr, *states_ = nullptr;
  VoxelPosition start_ = {0, 0, 0};  ///< where the window's lowest brick is kept in the ring
  int bricks_ = 0;                   ///< per side
  int brick_stride_ = 0;             ///< bricks from one row of bricks to the next, ≥ bricks_, a multiple of 16
};

/// Bricks of one row of the memory, a lane each.
template <class F>
class BrickLanes {
 public:
  PL_HD Mask<F> exist() const { return inside_row<F>(x_, map_.bricks_); }
  /// In the window, counted in bricks; of bricks that do not exist, anywhere.
  PL_HD Vec3<F> positions() const {
    const auto along = [&](int slot, int start) {
      return F(static_cast<float>(map_.unroll<std::int32_t>(slot, start)));
    };
    const Int<F> x = map_.unroll<Int<F>>(Lane<F>::int_index() + Int<F>(x_), map_.start_.x);
    return {to_float(x), along(y_, map_.start_.y), along(z_, map_.start_.z)};
  }
  /// Metres, in the window's frame.
  PL_HD Vec3<F> centres() const {
    const float size = map_.brick_size();
    const Vec3<F> p = positions();
    return {(p.x + 0.5f) * size, (p.y + 0.5f) * size, (p.z + 0.5f) * size};
  }
  PL_HD Int<F> states() const { return load_int<F>(map_.states_ + first()); }
  /// Into an array with a value for each slot (`BrickMap::state_words`).
  PL_HD void store(std::int32_t* per_brick, const Int<F>& values) const { store_int(per_brick + first(), values); }

 private:
  friend class BrickMap;
  PL_HD BrickLanes(const BrickMap& map, int x, int y, int z) : map_(map), x_(x), y_(y), z_(z) {}
  PL_HD int first() const { return map_.slot_index<std::int32_t>(x_, y_, z_); }

  const BrickMap& map_;
  int x_, y_, z_;  ///< in the ring
};

/// The voxels around a point, a lane each: the corners of a cell, and those one further along each axis.
template <class F>
class VoxelNeighbours {
 public:
  /// Of the cell whose lowest corner is voxel (x, y, z); all its corners must exist.
  PL_HD VoxelNeighbours(const BrickMap& map, const Int<F>& x, const Int<F>& y, const Int<F>& z)
      : map_(map),
        first_{x, y, z},
        terms_{{map.term_x(x), map.term_x(x + Int<F>(1))},
               {map.term_y(y), map.term_y(y + Int<F>(1))},
               {map.term_z(z), map.term_z(z + Int<F>(1))}} {}

  /// Words of corner c: bit 0 of c is a step along x, bit 1 along y, bit 2 along z.
  PL_HD Int<F> corner(int c) const {
    return gather_int(map_.voxels_, terms_[0][c & 1] + terms_[1][c >> 1 & 1] + terms_[2][c >> 2]);
  }

  /// Words of the four voxels before and the four after the cell along an axis, clamped to the window. Bit 0 of their
  /// index is a step along the first of the two other axes, bit 1 along the second.
  PL_HD void beyond(int axis, Int<F> (&before)[4], Int<F> (&after)[4]) const {
    const Int<F> low = term(axis, max_int(first_[axis] - Int<F>(1), Int<F>(0)));
    const Int<F> high = term(axis, min_int(first_[axis] + Int<F>(2), Int<F>(map_.resolution() - 1)));
    const int p = axis == 0 ? 1 : 0, q = axis == 2 ? 1 : 2;
    for (int k = 0; k < 4; ++k) {
      const Int<F> rest = terms_[p][k & 1] + terms_[q][k >> 1];
      before[k] = gather_int(map_.voxels_, low + rest);
      after[k] = gather_int(map_.voxels_, high + rest);
    }
  }

 private:
  PL_HD Int<F> term(int axis, const Int<F>& position) const {
    return axis == 0 ? map_.term_x(position) : axis == 1 ? map_.term_y(position) : map_.term_z(position);
  }

  const BrickMap& map_;
  Int<F> first_[3];
  Int<F> terms_[3][2];  ///< per axis, of the lower and the upper corners
};

/// A brick and the seven that are one further along one axis or more: all that its cells reach.
class BrickNeighbours {
 public:
  PL_HD BrickNeighbours(const BrickMap& map, int brick)
      : map_(map), origin_(map.origin_of(brick)), end_(map.resolution()) {}

  /// The brick's lowest voxel.
  PL_HD const VoxelPosition& origin() const { return origin_; }
  /// The voxel at a position in the brick or one beyond it, 0…8 on each axis.
  PL_HD VoxelAddress find(const VoxelPosition& p) const {
    if (origin_.x + p.x >= end_ || origin_.y + p.y >= end_ || origin_.z + p.z >= end_) return {-1, 0};
    return map_.find({origin_.x + p.x, origin_.y + p.y, origin_.z + p.z});
  }

 private:
  const BrickMap& map_;
  VoxelPosition origin_;
  int end_;
};

}  // namespace plumbline::kernels
