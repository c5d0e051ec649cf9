#include "sim/scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "plumbline/error.h"
#include "plumbline/mesh.h"
#include "sim/buildings.h"
#include "sim/props.h"

namespace plumbline::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr const char* kScenesWhere = "scene";

/// On the walls of a room of the given half size: `along` runs to the right as one faces the wall from inside.
struct Walls {
  Vector2d half;

  SE3 north(double along, double z) const { return stand(along, half.y(), z, 0); }
  SE3 south(double along, double z) const { return stand(-along, -half.y(), z, std::numbers::pi); }
  SE3 east(double along, double z) const { return stand(half.x(), -along, z, -std::numbers::pi / 2); }
  SE3 west(double along, double z) const { return stand(-half.x(), along, z, std::numbers::pi / 2); }
};

Paint parquet() {
  return [](const Vector3d& p) {
    const double plank = std::floor(p.y() / 0.12),
                 shade = lattice_noise({plank * 7.3, std::floor(p.x() / 0.9 + 0.37 * plank), 0}, 7);
    const double grain = lattice_noise({p.x() / 0.25, p.y() / 0.02, 0}, 8);
    return blend({190, 150, 104}, {140, 100, 62}, 0.5 + 0.35 * shade + 0.15 * grain);
  };
}

Paint plaster(Mesh::Rgb color, std::uint64_t key) {
  return mottled(color, blend(color, {255, 255, 255}, 0.3), {0.7, 0.7, 0.7}, key);
}

// ---- desk

void furnish_first_desk(MeshBuilder& m) {
  const double z = 0.74;
  props::monitor(m, stand(-0.30, 0.28, z, 0.15));
  props::monitor(m, stand(0.32, 0.30, z, -0.2));
  props::keyboard(m, stand(-0.12, -0.02, z, 0.05));
  props::mouse(m, stand(0.24, -0.04, z, -0.1));
  props::papers(m, stand(0.52, 0.02, z, 0.3), 1);
  props::cup(m, stand(-0.48, 0.02, z, 0.8), {190, 60, 50});
  props::cup(m, stand(0.42, -0.22, z, 2.4), {60, 110, 160});
  props::desk_lamp(m, stand(-0.72, 0.30, z, 0.9), {200, 70, 50});
  props::telephone(m, stand(-0.66, -0.02, z, 0.3));
  props::book_stack(m, stand(0.70, 0.30, z, 0.2), 5, 3);
  props::pen_holder(m, stand(0.02, 0.24, z), 4);
  props::bottle(m, stand(0.78, -0.16, z), {70, 120, 84});
  props::open_book(m, stand(-0.42, -0.22, z, 0.25));
  props::teddy(m, stand(0.02, 0.36, z, -0.2), 0.22, {176, 126, 74});
}

void furnish_second_desk(MeshBuilder& m) {
  const double z = 0.74;
  props::laptop(m, stand(0.15, 0.02, z, -0.1));
  props::globe(m, stand(-0.60, 0.24, z, 0.5));
  props::plant(m, stand(0.66, 0.26, z), 0.42, 5);
  props::book_stack(m, stand(-0.30, 0.22, z, -0.4), 7, 6);
  props::open_book(m, stand(-0.36, -0.12, z, -0.2));
  props::cup(m, stand(0.50, -0.08, z, 1.1), {226, 190, 80});
  props::box_carton(m, stand(-0.66, -0.12, z, 0.35), {0.11, 0.09, 0.06});
  props::desk_lamp(m, stand(0.36, 0.32, z, -0.4), {60, 64, 72});
  props::bowl_of_fruit(m, stand(0.64, -0.2, z), 7);
  props::book_row(m, stand(-0.1, 0.30, z, 0.03), 0.28, 8);
  props::papers(m, stand(-0.06, -0.24, z, -0.5), 9);
  props::vase(m, stand(0.08, 0.16, z), {80, 110, 140});
}

/// A builder of its own gives the things of a table their own frame.
void append(MeshBuilder& into, const SE3& pose, void (*furnish)(MeshBuilder&), Mesh* mesh) {
  MeshBuilder local;
  local.cell = into.cell;
  furnish(local);
  const auto first = static_cast<std::uint32_t>(mesh->positions.size());
  for (const Mesh::Float3& p : local.mesh().positions) {
    const Eigen::Vector3f world = (pose * Vector3d(p.x, p.y, p.z)).cast<float>();
    mesh->positions.push_back({world.x(), world.y(), world.z()});
  }
  mesh->colors.insert(mesh->colors.end(), local.mesh().colors.begin(), local.mesh().colors.end());
  for (const Mesh::Triangle& t : local.mesh().triangles)
    mesh->triangles.push_back({t.a + first, t.b + first, t.c + first});
}

void office(MeshBuilder& m) {
  const Walls walls{{3.2, 3.2}};
  m.cell = 0.06;
  props::room(m, walls.half, 2.8, mottled({112, 118, 126}, {140, 144, 148}, {0.05, 0.05, 0.05}, 1),
              plaster({214, 214, 204}, 2));
  m.cell = 0.03;
  props::table(m, stand(0, 0.41, 0), {0.9, 0.4}, 0.74, wood({212, 182, 138}, {190, 156, 110}, 3));
  props::table(m, stand(0, -0.41, 0), {0.9, 0.4}, 0.74, wood({206, 174, 130}, {184, 148, 104}, 4));
  props::office_chair(m, stand(0.25, 1.25, 0, std::numbers::pi + 0.4), {46, 70, 110});
  props::office_chair(m, stand(-0.35, -1.25, 0, 0.5), {120, 50, 48});
  props::computer_tower(m, stand(-0.7, 0.45, 0, 0.1));
  props::waste_bin(m, stand(1.15, -0.3, 0));
  props::cabinet(m, stand(1.25, 0.45, 0, -std::numbers::pi / 2), {0.22, 0.28, 0.3}, 3, {186, 190, 194});
  props::plant(m, stand(1.25, 0.45, 0.6), 0.5, 10);
  props::box_carton(m, stand(-1.3, -0.9, 0, 0.4), {0.2, 0.26, 0.16});
  props::ball(m, stand(-1.2, 0.8, 0), 0.12, {200, 60, 50}, {236, 230, 220});
  props::bookcase(m, walls.north(-1.9, 0), 1.0, 2.0, 5, 11);
  props::bookcase(m, walls.north(-0.8, 0), 1.0, 2.0, 5, 12);
  props::cabinet(m, stand(1.0, 2.95, 0), {0.5, 0.24, 0.45}, 3, {204, 200, 190});
  props::book_stack(m, stand(0.8, 2.95, 0.9), 6, 13);
  props::globe(m, stand(1.2, 2.95, 0.9));
  props::picture(m, walls.north(1.1, 1.8), 0.8, 0.6, 14);
  props::door(m, walls.north(2.4, 0));
  props::window(m, walls.east(-1.2, 0.9), 1.6, 1.3);
  props::window(m, walls.east(1.2, 0.9), 1.6, 1.3);
  props::radiator(m, walls.east(-1.2, 0), 1.4);
  props::radiator(m, walls.east(1.2, 0), 1.4);
  props::curtain(m, walls.east(0, 0.1), 0.6, 2.4, {120, 140, 120});
  props::plant(m, stand(2.8, 2.7, 0), 1.1, 15);
  props::wall_shelf(m, walls.south(-1.3, 1.3), 1.4, 16);
  props::wall_shelf(m, walls.south(-1.3, 1.75), 1.4, 17);
  props::table(m, stand(1.3, -2.8, 0), {0.8, 0.36}, 0.74, wood({180, 140, 96}, {150, 110, 70}, 18));
  props::monitor(m, stand(1.2, -2.95, 0.74, std::numbers::pi));
  props::keyboard(m, stand(1.2, -2.65, 0.74, std::numbers::pi));
  props::book_stack(m, stand(1.8, -2.85, 0.74), 6, 19);
  props::plant(m, stand(0.7, -2.9, 0.74), 0.4, 20);
  props::office_chair(m, stand(1.2, -2.1, 0, 0.3), {60, 62, 66});
  props::picture(m, walls.south(0.6, 1.7), 0.9, 0.6, 21);
  props::cabinet(m, stand(-1.6, -2.9, 0, std::numbers::pi), {0.5, 0.26, 0.5}, 4, {170, 150, 120});
  props::vase(m, stand(-1.6, -2.85, 1.0), {170, 90, 60});
  props::sofa(m, stand(-2.6, 0.2, 0, std::numbers::pi / 2), 1.7, {150, 140, 110});
  props::picture(m, walls.west(-0.6, 1.6), 0.6, 0.8, 22);
  props::picture(m, walls.west(0.9, 1.6), 0.9, 0.6, 23);
  props::bookcase(m, walls.west(2.4, 0), 0.9, 1.9, 5, 24);
  props::ceiling_lamp(m, stand(0, 1.2, 2.8));
  props::ceiling_lamp(m, stand(0, -1.2, 2.8));
}

Mesh desk() {
  MeshBuilder m;
  office(m);
  Mesh mesh = m.mesh();
  append(m, stand(0, 0.41, 0, std::numbers::pi), furnish_first_desk, &mesh);
  append(m, stand(0, -0.41, 0), furnish_second_desk, &mesh);
  return mesh;
}

// ---- room

void living_walls(MeshBuilder& m, const Walls& walls) {
  m.cell = 0.06;
  props::room(m, walls.half, 2.7, parquet(), plaster({222, 208, 184}, 31));
  m.cell = 0.03;
  props::window(m, walls.north(-0.4, 0.8), 1.8, 1.4);
  props::curtain(m, walls.north(-1.55, 0.05), 0.5, 2.4, {150, 70, 60});
  props::curtain(m, walls.north(0.75, 0.05), 0.5, 2.4, {150, 70, 60});
  props::radiator(m, walls.north(-0.4, 0), 1.5);
  props::bookcase(m, walls.north(1.8, 0), 1.1, 2.1, 6, 32);
  props::bookcase(m, walls.east(-1.3, 0), 1.2, 2.0, 5, 33);
  props::bookcase(m, walls.east(0.0, 0), 1.2, 1.2, 3, 34);
  props::picture(m, walls.east(0.0, 1.75), 0.9, 0.65, 35);
  props::door(m, walls.east(1.5, 0));
  props::wall_shelf(m, walls.south(-0.6, 1.35), 1.5, 36);
  props::wall_shelf(m, walls.south(-0.4, 1.75), 1.1, 37);
  props::picture(m, walls.south(1.5, 1.6), 0.7, 0.9, 38);
  props::picture(m, walls.west(-1.3, 1.6), 0.6, 0.6, 39);
  props::picture(m, walls.west(-0.5, 1.5), 0.6, 0.8, 40);
  props::wall_shelf(m, walls.west(1.2, 1.4), 1.2, 41);
  props::ceiling_lamp(m, stand(0, 0, 2.7));
}

Mesh living_room() {
  MeshBuilder m;
  const Walls walls{{2.7, 2.4}};
  living_walls(m, walls);
  props::rug(m, stand(-0.2, -0.2, 0, 0.1), {1.2, 0.85}, {140, 60, 54}, {206, 180, 130});
  props::sofa(m, stand(-2.15, -0.1, 0, std::numbers::pi / 2), 2.0, {90, 110, 130});
  props::sofa(m, stand(-0.6, -1.85, 0, std::numbers::pi), 1.5, {130, 120, 90});
  props::table(m, stand(-0.2, -0.2, 0, 0.1), {0.5, 0.3}, 0.42, wood({160, 110, 70}, {120, 78, 46}, 42));
  props::bowl_of_fruit(m, stand(-0.35, -0.25, 0.42), 43);
  props::book_stack(m, stand(0.05, -0.1, 0.42, 0.6), 3, 44);
  props::cup(m, stand(-0.1, -0.35, 0.42, 1), {200, 200, 190});
  props::open_book(m, stand(-0.42, -0.02, 0.42, 0.4));
  props::table(m, stand(1.35, 1.0, 0, 0.2), {0.55, 0.42}, 0.75, wood({200, 160, 110}, {170, 126, 80}, 45));
  props::kitchen_chair(m, stand(1.2, 0.3, 0, std::numbers::pi + 0.3));
  props::kitchen_chair(m, stand(0.55, 1.05, 0, std::numbers::pi / 2 + 0.2));
  props::vase(m, stand(1.35, 1.05, 0.75), {60, 100, 130});
  props::plate(m, stand(1.15, 0.85, 0.75), 0.12);
  props::laptop(m, stand(1.6, 1.1, 0.75, 0.5));
  props::bottle(m, stand(1.0, 1.15, 0.75), {60, 90, 60});
  props::cabinet(m, stand(0.95, -2.1, 0, std::numbers::pi), {0.6, 0.24, 0.32}, 3, {220, 214, 200});
  props::monitor(m, stand(0.95, -2.1, 0.64, std::numbers::pi));
  props::globe(m, stand(1.4, -2.1, 0.64));
  props::teddy(m, stand(0.5, -2.05, 0.64, std::numbers::pi - 0.3), 0.3, {170, 120, 70});
  props::plant(m, stand(2.3, -2.0, 0), 1.2, 46);
  props::plant(m, stand(-2.3, 2.0, 0), 0.9, 47);
  props::desk_lamp(m, stand(2.5, 0.3, 1.2, -1.2), {210, 170, 60});
  props::box_carton(m, stand(-1.3, 1.7, 0, 0.3), {0.22, 0.18, 0.15});
  props::ball(m, stand(-0.8, 1.3, 0), 0.13, {220, 150, 50}, {50, 80, 140});
  props::book_stack(m, stand(-1.5, 1.1, 0, 0.8), 6, 48);
  props::waste_bin(m, stand(2.35, 1.9, 0));
  return m.mesh();
}

// ---- kitchen

/// Metres above the joints.
double tile_relief(double x, double y) {
  const double u = std::abs(std::fmod(std::abs(x) + 0.07, 0.14) - 0.07),
               v = std::abs(std::fmod(std::abs(y) + 0.07, 0.14) - 0.07);
  return std::max(u, v) > 0.064 ? 0.0 : 0.006;
}

void worktop(MeshBuilder& m, const SE3& pose, double width, Mesh::Rgb front) {
  const int units = std::max(1, static_cast<int>(width / 0.6 + 0.5));
  const double unit = width / units;
  for (int i = 0; i < units; ++i)
    props::cabinet(m, pose * stand((i + 0.5) * unit - width / 2, -0.3, 0), {unit / 2 - 0.002, 0.28, 0.43},
                   i % 2 == 0 ? 1 : 3, front);
  m.box(pose * stand(0, -0.31, 0.88), {width / 2 + 0.01, 0.31, 0.02},
        mottled({90, 92, 96}, {140, 142, 146}, {0.02, 0.02, 0.02}, 51));
  // Tiles behind it, their joints as relief.
  m.cell = 0.012;
  m.sheet(pose * turned(0, -0.004, 1.18, std::numbers::pi / 2, 0, 0), {width / 2, 0.28}, tile_relief,
          checkered({226, 230, 224}, {188, 208, 206}, 0.14));
  m.cell = 0.03;
}

void wall_units(MeshBuilder& m, const SE3& pose, int count, Mesh::Rgb front) {
  for (int i = 0; i < count; ++i) {
    const double x = (i - 0.5 * (count - 1)) * 0.6;
    m.box(pose * stand(x, -0.17, 0.35), {0.298, 0.17, 0.35}, plain(blend(front, {0, 0, 0}, 0.15)));
    m.box(pose * stand(x, -0.35, 0.35), {0.285, 0.01, 0.335}, plain(front));
    m.cylinder(pose * turned(x + 0.22, -0.39, 0.06, 0, 0, 0), 0.008, 0.14, plain({170, 174, 180}), 12);
  }
}

void stove(MeshBuilder& m, const SE3& pose) {
  m.box(pose * stand(0, -0.32, 0.905), {0.28, 0.25, 0.006}, plain({36, 36, 40}));
  for (const double x : {-0.13, 0.13})
    for (const double y : {-0.44, -0.2}) m.cylinder(pose * stand(x, y, 0.91), 0.085, 0.006, plain({80, 80, 84}));
  props::pot(m, pose * stand(-0.13, -0.2, 0.917, 0.4), 0.10, 0.14, {170, 60, 50});
  props::pot(m, pose * stand(0.13, -0.2, 0.917, 1.2), 0.09, 0.10, {176, 180, 186});
  props::kettle(m, pose * stand(0.13, -0.44, 0.917, 2.0));
  m.lathe(pose * stand(0, -0.25, 1.65), {{0.28, 0}, {0.26, 0.05}, {0.1, 0.22}, {0.09, 0.6}}, plain({176, 180, 186}),
          32);
}

void sink(MeshBuilder& m, const SE3& pose) {
  for (const double side : {-1.0, 1.0}) {
    m.box(pose * stand(side * 0.22, -0.32, 0.915), {0.02, 0.2, 0.015}, plain({186, 190, 196}));
    m.box(pose * stand(0, -0.32 + side * 0.2, 0.915), {0.24, 0.02, 0.015}, plain({186, 190, 196}));
  }
  props::tap(m, pose * stand(0, -0.08, 0.9));
  for (int i = 0; i < 4; ++i) props::plate(m, pose * turned(0.34 + 0.035 * i, -0.34, 1.0, 0, 1.3, 0), 0.11);
}

void fridge(MeshBuilder& m, const SE3& pose) {
  const Paint paint = plain({226, 226, 222});
  m.box(pose * stand(0, -0.32, 0.9), {0.3, 0.3, 0.9}, paint);
  m.box(pose * stand(0, -0.635, 0.62), {0.295, 0.015, 0.58}, paint);
  m.box(pose * stand(0, -0.635, 1.51), {0.295, 0.015, 0.28}, paint);
  for (const double z : {0.9, 1.4}) m.cylinder(pose * stand(-0.25, -0.68, z), 0.012, 0.22, plain({150, 154, 160}), 12);
  Random random(61);
  for (int i = 0; i < 9; ++i) {
    const double x = random.uniform(-0.2, 0.2), z = random.uniform(0.8, 1.7), lean = random.uniform(-0.3, 0.3);
    const double half_width = random.uniform(0.02, 0.06), half_height = random.uniform(0.02, 0.07);
    m.box(pose * turned(x, -0.654, z, 0, lean, 0), {half_width, 0.004, half_height},
          mottled({230, 200, 90}, {200, 80, 70}, {0.03, 0.03, 0.03}, static_cast<std::uint64_t>(i)));
  }
}

Mesh kitchen() {
  MeshBuilder m;
  const Walls walls{{2.3, 2.0}};
  m.cell = 0.06;
  props::room(m, walls.half, 2.6, checkered({200, 190, 176}, {150, 132, 116}, 0.3), plaster({230, 222, 190}, 62));
  m.cell = 0.03;
  worktop(m, walls.north(-0.3, 0), 3.0, {92, 128, 120});
  stove(m, walls.north(-0.3, 0));
  sink(m, walls.north(0.7, 0));
  wall_units(m, walls.north(-1.4, 1.5), 2, {92, 128, 120});
  wall_units(m, walls.north(0.9, 1.5), 2, {92, 128, 120});
  fridge(m, walls.north(1.75, 0));
  worktop(m, walls.west(-0.2, 0), 1.8, {92, 128, 120});
  props::wall_shelf(m, walls.west(-0.2, 1.6), 1.5, 63);
  props::bowl_of_fruit(m, walls.west(-0.6, 0) * stand(0, -0.35, 0.9), 64);
  props::box_carton(m, walls.west(-0.1, 0) * stand(0, -0.3, 0.9, 0.3), {0.1, 0.08, 0.09});
  props::bottle(m, walls.west(0.3, 0) * stand(0, -0.2, 0.9), {150, 100, 50});
  props::bottle(m, walls.west(0.42, 0) * stand(0, -0.26, 0.9), {60, 100, 60});
  props::pot(m, walls.west(0.1, 0) * stand(0, -0.42, 0.9), 0.08, 0.09, {60, 90, 130});
  props::cup(m, walls.north(-1.2, 0) * stand(0, -0.35, 0.9, 2), {220, 120, 60});
  props::cup(m, walls.north(-1.0, 0) * stand(0, -0.25, 0.9, 1), {70, 120, 160});
  props::vase(m, walls.north(-1.5, 0) * stand(0, -0.3, 0.9), {130, 90, 140});
  props::table(m, stand(0.7, -0.6, 0, 0.15), {0.6, 0.42}, 0.74, wood({214, 176, 124}, {184, 140, 90}, 65));
  for (const double x : {0.45, 1.0}) props::plate(m, stand(x, -0.8, 0.74), 0.12);
  props::pot(m, stand(0.75, -0.5, 0.74, 0.8), 0.11, 0.12, {200, 90, 50});
  props::bottle(m, stand(1.05, -0.4, 0.74), {70, 110, 70});
  props::cup(m, stand(0.3, -0.55, 0.74, 0.5), {230, 220, 200});
  props::open_book(m, stand(0.4, -0.35, 0.74, 0.3));
  props::kitchen_chair(m, stand(0.4, -1.3, 0, 0.2 + std::numbers::pi));
  props::kitchen_chair(m, stand(1.1, -1.35, 0, std::numbers::pi - 0.3));
  props::kitchen_chair(m, stand(1.65, -0.4, 0, -std::numbers::pi / 2));
  props::window(m, walls.east(0.2, 0.9), 1.2, 1.2);
  props::radiator(m, walls.east(0.2, 0), 1.0);
  props::door(m, walls.south(1.2, 0));
  props::picture(m, walls.south(-0.2, 1.5), 0.7, 0.5, 66);
  props::bookcase(m, walls.south(-1.3, 0), 0.9, 1.8, 5, 67);
  props::waste_bin(m, stand(-1.9, -1.6, 0));
  props::ceiling_lamp(m, stand(0.6, -0.5, 2.6));
  return m.mesh();
}

// ---- teddy

Mesh teddy() {
  MeshBuilder m;
  const Walls walls{{3.0, 3.0}};
  m.cell = 0.06;
  props::room(m, walls.half, 2.7, parquet(), plaster({206, 214, 220}, 71));
  m.cell = 0.03;
  props::rug(m, stand(0, 0, 0, 0.3), {0.9, 0.9}, {60, 90, 120}, {196, 176, 130});
  props::teddy(m, stand(0, 0, 0.016), 1.0, {178, 128, 72});
  props::plant(m, stand(0.75, 0.65, 0), 0.8, 72);
  props::ball(m, stand(-0.65, -0.35, 0.01), 0.14, {206, 60, 54}, {236, 226, 200});
  props::book_stack(m, stand(0.62, -0.35, 0.012, 0.5), 5, 73);
  props::box_carton(m, stand(-0.7, 0.55, 0.012, 0.5), {0.2, 0.15, 0.14});
  m.box(stand(0.25, -0.7, 0.07, 0.4), {0.06, 0.06, 0.06}, checkered({60, 120, 160}, {230, 210, 120}, 0.06));
  m.box(stand(0.38, -0.62, 0.06, 0.1), {0.05, 0.05, 0.05}, checkered({190, 70, 60}, {230, 220, 210}, 0.05));
  props::sofa(m, stand(0.2, 2.5, 0), 2.0, {120, 104, 84});
  props::bookcase(m, walls.west(0.8, 0), 1.1, 2.0, 5, 74);
  props::bookcase(m, walls.west(-0.6, 0), 1.1, 1.2, 3, 75);
  props::window(m, walls.east(0, 0.9), 1.6, 1.3);
  props::radiator(m, walls.east(0, 0), 1.3);
  props::plant(m, stand(2.6, -2.5, 0), 1.2, 76);
  props::door(m, walls.south(1.0, 0));
  props::cabinet(m, stand(-0.6, -2.7, 0, std::numbers::pi), {0.6, 0.26, 0.42}, 3, {196, 170, 130});
  props::globe(m, stand(-0.4, -2.7, 0.84));
  props::picture(m, walls.north(0.2, 1.6), 1.1, 0.7, 77);
  props::picture(m, walls.south(-0.6, 1.6), 0.8, 0.6, 78);
  props::picture(m, walls.west(-0.6, 1.7), 0.7, 0.6, 79);
  return m.mesh();
}

// ---- corridor

Mesh corridor() {
  MeshBuilder m;
  const Walls walls{{6.0, 1.1}};
  m.cell = 0.06;
  props::room(m, walls.half, 2.5, mottled({120, 124, 118}, {138, 142, 136}, {0.4, 0.4, 0.4}, 81),
              plaster({222, 224, 216}, 82));
  m.cell = 0.03;
  props::door(m, walls.north(-3.5, 0));
  props::door(m, walls.south(-1.0, 0));
  props::door(m, walls.north(4.2, 0));
  props::door(m, walls.west(0, 0));
  props::radiator(m, walls.south(3.5, 0), 1.0);
  props::picture(m, walls.south(-4.5, 1.5), 0.8, 0.6, 83);
  props::window(m, walls.east(0, 0.9), 1.2, 1.2);
  props::waste_bin(m, stand(5.6, 0.8, 0));
  return m.mesh();
}

template <Mesh (*Make)()>
Building without_way() {
  return {Make(), {}};
}

Building six_rooms() { return floor_of_rooms({1, 2, 3, 4, 5, 6}); }
Building like_rooms() { return floor_of_rooms({1, 1, 1, 1, 1, 1}); }

struct Entry {
  std::string_view name;
  Building (*make)();
  Vector3d focus;
  double radius;
};

const std::array<Entry, 8>& entries() {
  static const std::array<Entry, 8> list = {{{"desk", &without_way<desk>, {0, 0, 0.85}, 1.2},
                                             {"room", &without_way<living_room>, {0, 0, 0.8}, 2.6},
                                             {"kitchen", &without_way<kitchen>, {0.1, 0.6, 0.9}, 1.9},
                                             {"teddy", &without_way<teddy>, {0, 0, 0.45}, 0.9},
                                             {"corridor", &without_way<corridor>, {0, 0, 1.2}, 2.5},
                                             {"ring", &ring_corridor, {0, -5.5, 1.2}, 6},
                                             {"floor", &six_rooms, {0, 0, 1.2}, 7},
                                             {"twins", &like_rooms, {0, 0, 1.2}, 7}}};
  return list;
}

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const Entry& entry : entries()) names.emplace_back(entry.name);
  return names;
}

Scene make_scene(std::string_view name) {
  std::string known;
  for (const Entry& entry : entries()) {
    if (entry.name == name) {
      Building made = entry.make();
      return {std::string(name), std::move(made.mesh), entry.focus, entry.radius, std::move(made.way)};
    }
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw Error("there is no scene '" + std::string(name) + "'", kScenesWhere,
              "take one of " + known + ", or a PLY or OBJ file");
}

Scene scene_of(std::string name, Mesh mesh) {
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  double total = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Mesh::Triangle& t = mesh.triangles[i];
    if (std::max({t.a, t.b, t.c}) >= mesh.positions.size())
      throw Error("triangle " + std::to_string(i) + " names a vertex beyond the last", name, "check the mesh's faces");
    const auto at = [&](std::uint32_t k) {
      return Vector3d(mesh.positions[k].x, mesh.positions[k].y, mesh.positions[k].z);
    };
    const Vector3d a = at(t.a), b = at(t.b), c = at(t.c), centre = (a + b + c) / 3;
    if (!centre.allFinite())
      throw Error("a vertex of triangle " + std::to_string(i) + " is not finite", name, "remove it");
    const double area = (b - a).cross(c - a).norm() / 2;
    total += area;
    sum += area * centre;
    squares += area * centre.cwiseProduct(centre);
  }
  if (!(total > 0)) throw Error("the mesh has no area", name, "give a mesh with triangles");
  const Vector3d mean = sum / total;
  const double spread = std::sqrt(std::max(0.0, (squares / total - mean.cwiseProduct(mean)).sum()));
  return {std::move(name), std::move(mesh), mean, std::max(spread, 1e-3), {}};
}

}  // namespace plumbline::sim
