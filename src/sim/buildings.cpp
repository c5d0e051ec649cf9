#include "sim/buildings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "plumbline/se3.h"
#include "sim/mesh_builder.h"
#include "sim/props.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kCeiling = 2.6, kWallThickness = 0.1, kDoorWidth = 1.0, kDoorHeight = 2.1;  // metres

Paint wall_paint(std::uint64_t key) { return mottled({216, 212, 200}, {236, 234, 226}, {0.7, 0.7, 0.7}, key); }

void wall_piece(MeshBuilder& m, const SE3& pose, double from, double to, double bottom) {
  if (to - from < 1e-6) return;
  m.box(pose * stand((from + to) / 2, 0, (bottom + kCeiling) / 2),
        {(to - from) / 2, kWallThickness / 2, (kCeiling - bottom) / 2}, wall_paint(91));
}

/// Along the pose's x, `length` metres about its origin, with openings at `doors`.
void wall(MeshBuilder& m, const SE3& pose, double length, const std::vector<double>& doors) {
  double from = -length / 2;
  for (const double door : doors) {
    wall_piece(m, pose, from, door - kDoorWidth / 2, 0);
    wall_piece(m, pose, door - kDoorWidth / 2, door + kDoorWidth / 2, kDoorHeight);
    from = door + kDoorWidth / 2;
  }
  wall_piece(m, pose, from, length / 2, 0);
}

void floor_and_ceiling(MeshBuilder& m, const Vector2d& half) {
  m.cell = 0.12;
  m.sheet(stand(0, 0, 0), half, wood({190, 150, 104}, {140, 100, 62}, 92));
  m.cell = 0.5;
  m.sheet(turned(0, 0, kCeiling, std::numbers::pi, 0, 0), half, plain({240, 240, 236}));
  m.cell = 0.12;
}

/// One of the things that stand or hang at a wall; the pose is on the wall at the floor, local −y faces the room.
void furnish_wall(MeshBuilder& m, const SE3& wall, Random& random) {
  const auto key = static_cast<std::uint64_t>(random.below(1 << 20));
  const Mesh::Rgb colour = blend({200, 190, 160}, {90, 110, 140}, random.uniform());
  const double size = random.uniform();
  switch (random.below(7)) {
    case 0:
      return props::bookcase(m, wall, 0.7 + 0.4 * size, 1.2 + 0.9 * size, 4, key);
    case 1:
      props::cabinet(m, wall * stand(0, -0.26, 0), {0.3 + 0.2 * size, 0.24, 0.4}, 3, colour);
      return props::plant(m, wall * stand(0.1, -0.26, 0.8), 0.3 + 0.3 * size, key);
    case 2:
      props::radiator(m, wall, 0.7 + 0.4 * size);
      return props::window(m, wall * stand(0, 0, 0.95), 0.8 + 0.3 * size, 1.2);
    case 3:
      props::wall_shelf(m, wall * stand(0, 0, 1.1 + 0.4 * size), 0.9, key);
      return props::box_carton(m, wall * stand(0.1, -0.25, 0, size), {0.2, 0.18, 0.15 + 0.1 * size});
    case 4:
      props::plant(m, wall * stand(-0.2, -0.3, 0), 0.8 + 0.5 * size, key);
      return props::picture(m, wall * stand(0.2, 0, 1.5), 0.5 + 0.3 * size, 0.6, key);
    case 5:
      props::table(m, wall * stand(0, -0.32, 0), {0.5, 0.28}, 0.74, wood({180, 140, 96}, {150, 110, 70}, key));
      props::monitor(m, wall * stand(0.1, -0.25, 0.74, 0.2 * size));
      return props::book_stack(m, wall * stand(-0.3, -0.3, 0.74, size), 4, key);
    default:
      props::waste_bin(m, wall * stand(0.3, -0.25, 0));
      return props::cabinet(m, wall * stand(-0.2, -0.2, 0), {0.25, 0.18, 0.5 + 0.4 * size}, 4, colour);
  }
}

/// Along a wall of `length` metres, left free where a door is.
void furnish_along(MeshBuilder& m, const SE3& pose, double length, const std::vector<double>& doors, Random& random) {
  constexpr double kStep = 1.3, kReach = 0.55;  // metres
  for (double x = -length / 2 + 0.75; x < length / 2 - 0.6; x += kStep + 0.5 * random.uniform()) {
    const bool is_free = std::all_of(doors.begin(), doors.end(),
                                     [&](double door) { return std::abs(x - door) > kDoorWidth / 2 + kReach + 0.1; });
    if (is_free) furnish_wall(m, pose * stand(x, 0, 0), random);
  }
}

void furnish_middle(MeshBuilder& m, const SE3& pose, Random& random) {
  const auto key = static_cast<std::uint64_t>(random.below(1 << 20));
  const double half = 0.5 + 0.35 * random.uniform();
  props::table(m, pose, {half, 0.45}, 0.74, wood({206, 174, 130}, {184, 148, 104}, key));
  for (int i = 0; i < 5; ++i) {
    const double x = random.uniform(-half + 0.12, half - 0.12), y = random.uniform(-0.33, 0.33);
    props::trinket(m, pose * stand(x, y, 0.74, random.uniform(0, 6)), random);
  }
  props::kitchen_chair(m, pose * stand(0.1, 0.75, 0, random.uniform(-0.5, 0.5)));
  props::office_chair(m, pose * stand(-0.2, -0.8, 0, std::numbers::pi + random.uniform(-0.6, 0.6)), {120, 50, 48});
  props::ceiling_lamp(m, pose * stand(0, 0, kCeiling));
}

Vector2d room_half() { return {3.25, 3.2}; }

/// A room about the pose's origin with its door in the middle of the wall at −y.
void furnish_room(MeshBuilder& m, const SE3& pose, std::uint64_t key) {
  Random random(stream(key, 93));
  const Vector2d half = room_half();
  furnish_along(m, pose * stand(0, half.y(), 0), 2 * half.x(), {}, random);
  furnish_along(m, pose * stand(half.x(), 0, 0, -std::numbers::pi / 2), 2 * half.y(), {}, random);
  furnish_along(m, pose * stand(0, -half.y(), 0, std::numbers::pi), 2 * half.x(), {0}, random);
  furnish_along(m, pose * stand(-half.x(), 0, 0, std::numbers::pi / 2), 2 * half.y(), {}, random);
  furnish_middle(m, pose * stand(0, 0, 0, 0.3), random);
}

constexpr double kRoomPitch = 6.6, kCorridorHalf = 1.1;  // metres

SE3 room_pose(int room) {
  const double x = (room % 3 - 1) * kRoomPitch, y = kCorridorHalf + kWallThickness + room_half().y();
  return room < 3 ? stand(x, y, 0) : stand(x, -y, 0, std::numbers::pi);
}

/// In through the door, round the table, out again.
void visit(int room, std::vector<Vector2d>* way) {
  const SE3 pose = room_pose(room);
  for (const Vector2d& p : {Vector2d(0, -3.9), Vector2d(0, -2.2), Vector2d(1.9, -1.6), Vector2d(1.9, 1.6),
                            Vector2d(-1.9, 1.6), Vector2d(-1.9, -1.6), Vector2d(0, -2.2), Vector2d(0, -3.9)})
    way->push_back((pose * Vector3d(p.x(), p.y(), 0)).head<2>());
}

}  // namespace

Building ring_corridor() {
  constexpr double kOuter = 6.5, kInner = 4.5, kMiddle = 5.5;
  MeshBuilder m;
  floor_and_ceiling(m, {kOuter, kOuter});
  Random random(94);
  for (int side = 0; side < 4; ++side) {
    const double yaw = side * std::numbers::pi / 2;
    const SE3 turn = stand(0, 0, 0, yaw);
    wall(m, turn * stand(0, kOuter + kWallThickness / 2, 0), 2 * kOuter + 0.2, {});
    wall(m, turn * stand(0, kInner - kWallThickness / 2, 0), 2 * kInner, {});
    furnish_along(m, turn * stand(0, kOuter, 0), 2 * kOuter, {}, random);
    for (double x = -kInner + 1.2; x < kInner - 1; x += 2.1 + 0.4 * random.uniform()) {
      const SE3 inside = turn * stand(x, kInner, 0, std::numbers::pi);
      if (random.below(3) == 0)
        props::door(m, inside);
      else
        props::picture(m, inside * stand(0, 0, 1.4), 0.6, 0.7, static_cast<std::uint64_t>(random.below(999)));
    }
  }
  return {m.mesh(),
          {{-2, -kMiddle},
           {kMiddle, -kMiddle},
           {kMiddle, kMiddle},
           {-kMiddle, kMiddle},
           {-kMiddle, -kMiddle},
           {4, -kMiddle}}};
}

Building floor_of_rooms(const std::array<std::uint64_t, 6>& keys) {
  MeshBuilder m;
  const double half_x = 1.5 * kRoomPitch, room_y = room_pose(0).translation().y(),
               half_y = room_y + room_half().y() + kWallThickness;
  floor_and_ceiling(m, {half_x, half_y});
  const std::vector<double> doors = {-kRoomPitch, 0, kRoomPitch};
  Random random(95);
  for (const double side : {-1.0, 1.0}) {
    wall(m, stand(0, side * (kCorridorHalf + kWallThickness / 2), 0), 2 * half_x, doors);
    wall(m, stand(0, side * (half_y - kWallThickness / 2), 0), 2 * half_x, {});
    for (const double x : {-half_x, -kRoomPitch / 2, kRoomPitch / 2, half_x})
      wall(m, stand(x, side * room_y, 0, std::numbers::pi / 2), 2 * room_half().y() + kWallThickness, {});
    wall(m, stand(side * half_x, 0, 0, std::numbers::pi / 2), 2 * kCorridorHalf, {});
    for (const double x : {-4.4, -2.1, 2.3, 4.5})
      props::picture(m, stand(x, side * kCorridorHalf, 1.45, side > 0 ? 0 : std::numbers::pi), 0.6, 0.7,
                     static_cast<std::uint64_t>(random.below(999)));
  }
  for (int room = 0; room < 6; ++room) furnish_room(m, room_pose(room), keys[static_cast<std::size_t>(room)]);
  Building building{m.mesh(), {{-half_x + 1.2, 0}, {-kRoomPitch, 0}}};
  for (const int room : {0, 3, 4, 1, 2, 5}) visit(room, &building.way);
  building.way.insert(building.way.end(), {{kRoomPitch, 0}, {-kRoomPitch, 0}});
  visit(0, &building.way);
  building.way.emplace_back(-kRoomPitch, 0);
  return building;
}

}  // namespace plumbline::sim
