#include "sim/props.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace plumbline::sim::props {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Rgb = Mesh::Rgb;

constexpr Rgb kBlack{34, 35, 38}, kDark{62, 64, 70}, kGrey{132, 134, 138}, kSteel{172, 176, 182}, kWhite{236, 235, 230};

SE3 shift(double x, double y, double z) { return stand(x, y, z); }

/// Strong but not garish, as book covers are.
Rgb cover_color(Random& random) {
  constexpr std::array<Rgb, 12> kColors = {{{156, 44, 42},
                                            {38, 72, 122},
                                            {44, 96, 66},
                                            {206, 164, 62},
                                            {88, 56, 106},
                                            {226, 222, 208},
                                            {58, 60, 64},
                                            {190, 104, 52},
                                            {96, 140, 164},
                                            {150, 158, 90},
                                            {120, 74, 50},
                                            {200, 130, 140}}};
  return kColors[static_cast<std::size_t>(random.below(static_cast<int>(kColors.size())))];
}

/// Profile of a vessel: up the outside, down the inside.
std::vector<Vector2d> vessel(const std::vector<Vector2d>& outside, double wall) {
  std::vector<Vector2d> profile = {{0, outside.front().y()}};
  profile.insert(profile.end(), outside.begin(), outside.end());
  for (auto p = outside.rbegin(); p != outside.rend(); ++p)
    profile.emplace_back(std::max(0.0, p->x() - wall), p->y() + (p + 1 == outside.rend() ? wall : 0));
  profile.emplace_back(0, outside.front().y() + wall);
  return profile;
}

}  // namespace

// ---- rooms

void room(MeshBuilder& m, const Vector2d& half, double height, const Paint& floor, const Paint& wall) {
  const double h = height / 2;
  m.sheet(stand(0, 0, 0), half, floor);
  m.sheet(turned(0, 0, height, std::numbers::pi, 0, 0), half, plain({240, 240, 236}));
  m.sheet(turned(0, half.y(), h, std::numbers::pi / 2, 0, 0), {half.x(), h}, wall);
  m.sheet(turned(0, -half.y(), h, std::numbers::pi / 2, 0, std::numbers::pi), {half.x(), h}, wall);
  m.sheet(turned(half.x(), 0, h, std::numbers::pi / 2, 0, -std::numbers::pi / 2), {half.y(), h}, wall);
  m.sheet(turned(-half.x(), 0, h, std::numbers::pi / 2, 0, std::numbers::pi / 2), {half.y(), h}, wall);
  const Paint skirting = plain({226, 222, 214});
  for (const double side : {-1.0, 1.0}) {
    m.box(stand(0, side * (half.y() - 0.01), 0.05), {half.x(), 0.01, 0.05}, skirting);
    m.box(stand(side * (half.x() - 0.01), 0, 0.05), {0.01, half.y(), 0.05}, skirting);
  }
}

void window(MeshBuilder& m, const SE3& pose, double width, double height) {
  const Paint frame = plain({232, 232, 228});
  const double w = width / 2, h = height / 2;
  m.box(pose * shift(0, -0.01, h), {w, 0.005, h}, mottled({176, 206, 232}, {214, 228, 236}, {0.8, 0.8, 0.3}, 3));
  for (const double x : {-w, 0.0, w}) m.box(pose * shift(x, -0.04, h), {0.035, 0.04, h + 0.035}, frame);
  for (const double z : {0.0, 0.7 * height, height}) m.box(pose * shift(0, -0.035, z), {w, 0.035, 0.03}, frame);
  m.box(pose * shift(0, -0.12, -0.04), {w + 0.08, 0.12, 0.015}, plain({220, 216, 208}));
  m.cylinder(pose * turned(0.03, -0.085, h * 0.8, 0, 0.2, 0), 0.01, 0.12, plain(kSteel), 12);
}

void curtain(MeshBuilder& m, const SE3& pose, double width, double height, Rgb color) {
  const auto fold = [=](double x, double y) {
    const double gather = 0.7 + 0.3 * (y / height + 0.5);
    return gather * (0.045 * std::sin(2 * std::numbers::pi * (x + 0.03 * std::sin(3 * y)) / 0.16) +
                     0.02 * lattice_noise({x / 0.2, y / 0.7, 0}, 11));
  };
  m.cell = 0.02;
  m.sheet(pose * turned(0, -0.14, height / 2, std::numbers::pi / 2, 0, 0), {width / 2, height / 2}, fold,
          mottled(color, blend(color, {255, 255, 255}, 0.25), {0.09, 0.5, 1}, 5), true);
  m.cell = 0.03;
  m.cylinder(pose * turned(-width / 2 - 0.1, -0.14, height + 0.03, 0, std::numbers::pi / 2, 0), 0.014, width + 0.2,
             plain(kDark));
}

void door(MeshBuilder& m, const SE3& pose) {
  const Paint leaf = wood({188, 146, 98}, {164, 120, 76}, 21);
  m.box(pose * shift(0, -0.015, 1.0), {0.42, 0.015, 1.0}, leaf);
  for (const double z : {0.55, 1.45}) m.box(pose * shift(0, -0.035, z), {0.28, 0.008, 0.34}, leaf);
  for (const double x : {-0.46, 0.46}) m.box(pose * shift(x, -0.03, 1.02), {0.04, 0.03, 1.02}, plain(kWhite));
  m.box(pose * shift(0, -0.03, 2.05), {0.5, 0.03, 0.04}, plain(kWhite));
  m.blob(pose * shift(0.35, -0.08, 1.02), {0.03, 0.03, 0.03}, plain(kSteel));
  m.cylinder(pose * turned(0.35, -0.03, 1.02, std::numbers::pi / 2, 0, 0), 0.012, 0.05, plain(kSteel), 12);
}

void picture(MeshBuilder& m, const SE3& pose, double width, double height, std::uint64_t key) {
  Random random(stream(key, 77));
  const Rgb a = cover_color(random), b = cover_color(random), c = cover_color(random);
  const auto image = [=](const Vector3d& p) {
    const double n = lattice_noise(p / 0.12, key) + 0.5 * lattice_noise(p / 0.05, key + 1);
    return n > 0.25 ? a : (n > -0.2 ? b : c);
  };
  m.cell = 0.012;
  m.box(pose * shift(0, -0.012, 0), {width / 2, 0.006, height / 2}, image);
  m.cell = 0.03;
  const Paint frame = plain(blend(a, kBlack, 0.7));
  for (const double side : {-1.0, 1.0}) {
    m.box(pose * shift(side * width / 2, -0.015, 0), {0.018, 0.015, height / 2 + 0.018}, frame);
    m.box(pose * shift(0, -0.015, side * height / 2), {width / 2, 0.015, 0.018}, frame);
  }
}

void radiator(MeshBuilder& m, const SE3& pose, double width) {
  const Paint paint = plain({228, 227, 220});
  const int ribs = static_cast<int>(width / 0.08);
  for (int i = 0; i < ribs; ++i)
    m.blob(pose * shift((i - 0.5 * (ribs - 1)) * 0.08, -0.09, 0.42), {0.032, 0.055, 0.30}, paint, 6, 12);
  for (const double z : {0.18, 0.66})
    m.cylinder(pose * turned(-width / 2 - 0.04, -0.09, z, 0, std::numbers::pi / 2, 0), 0.022, width + 0.08, paint);
}

void ceiling_lamp(MeshBuilder& m, const SE3& pose) {
  m.cylinder(pose * shift(0, 0, -0.6), 0.006, 0.6, plain(kDark), 8);
  m.lathe(pose * shift(0, 0, -0.85), vessel({{0.26, 0}, {0.24, 0.08}, {0.17, 0.18}, {0.05, 0.25}}, 0.004),
          plain({240, 226, 190}));
}

// ---- furniture

void table(MeshBuilder& m, const SE3& pose, const Vector2d& half, double height, const Paint& top) {
  m.box(pose * shift(0, 0, height - 0.014), {half.x(), half.y(), 0.014}, top);
  m.box(pose * shift(0, half.y() - 0.07, height - 0.07), {half.x() - 0.08, 0.012, 0.045}, plain(kGrey));
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      const SE3 foot = pose * shift(x * (half.x() - 0.06), y * (half.y() - 0.06), 0);
      m.cylinder(foot, 0.025, height - 0.028, plain(kGrey));
      m.cylinder(foot, 0.035, 0.02, plain(kBlack));
    }
  }
}

void office_chair(MeshBuilder& m, const SE3& pose, Rgb cloth) {
  const Paint fabric = mottled(cloth, blend(cloth, kWhite, 0.2), {0.03, 0.03, 0.03}, 31);
  m.blob(pose * shift(0, 0, 0.48), {0.25, 0.24, 0.05}, fabric, 4);
  m.blob(pose * turned(0, 0.25, 0.80, 0.15, 0, 0), {0.22, 0.045, 0.27}, fabric, 4);
  m.box(pose * turned(0, 0.27, 0.54, 0.15, 0, 0), {0.03, 0.012, 0.16}, plain(kBlack));
  m.cylinder(pose * shift(0, 0, 0.10), 0.03, 0.35, plain(kDark));
  for (int i = 0; i < 5; ++i) {
    const SE3 leg = pose * stand(0, 0, 0, 2 * std::numbers::pi * i / 5 + 0.3);
    m.blob(leg * turned(0.16, 0, 0.10, 0, 0.12, 0), {0.16, 0.025, 0.02}, plain(kBlack), 4, 10);
    m.blob(leg * shift(0.30, 0, 0.035), {0.035, 0.02, 0.035}, plain(kDark), 3, 10);
  }
  for (const double x : {-0.28, 0.28}) {
    m.blob(pose * shift(x, 0.02, 0.68), {0.035, 0.14, 0.018}, plain(kBlack), 4, 10);
    m.tube(pose, {{x, 0.08, 0.66}, {x, 0.09, 0.55}, {0.8 * x, 0.06, 0.46}}, 0.014, plain(kBlack));
  }
}

void kitchen_chair(MeshBuilder& m, const SE3& pose) {
  const Paint paint = wood({206, 166, 112}, {176, 130, 80}, 41);
  m.blob(pose * shift(0, 0, 0.45), {0.21, 0.21, 0.02}, paint, 5);
  for (const double x : {-0.17, 0.17}) {
    m.cylinder(pose * shift(x, -0.17, 0), 0.02, 0.44, paint);
    m.cylinder(pose * shift(x, 0.17, 0), 0.02, 0.92, paint);
    m.cylinder(pose * turned(x, -0.17, 0.2, -std::numbers::pi / 2, 0, 0), 0.012, 0.34, paint, 12);
  }
  for (const double z : {0.66, 0.86}) m.blob(pose * shift(0, 0.17, z), {0.17, 0.012, 0.045}, paint, 5, 12);
}

void sofa(MeshBuilder& m, const SE3& pose, double width, Rgb cloth) {
  const Paint fabric = mottled(cloth, blend(cloth, kWhite, 0.22), {0.05, 0.05, 0.05}, 51);
  const double w = width / 2;
  m.blob(pose * shift(0, 0, 0.20), {w, 0.42, 0.17}, fabric, 8);
  m.blob(pose * turned(0, 0.34, 0.58, 0.12, 0, 0), {w, 0.12, 0.32}, fabric, 6);
  for (const double side : {-1.0, 1.0}) {
    m.blob(pose * shift(side * (w - 0.02), 0, 0.38), {0.11, 0.43, 0.25}, fabric, 5);
    m.blob(pose * shift(side * (w / 2 - 0.05), -0.06, 0.42), {w / 2 - 0.07, 0.34, 0.09}, fabric, 5);
  }
  m.blob(pose * turned(-w + 0.35, 0.12, 0.66, 0.5, 0.2, 0.3), {0.21, 0.08, 0.20},
         checkered({196, 88, 60}, {226, 196, 150}, 0.07), 3);
  m.blob(pose * turned(w - 0.40, 0.14, 0.64, 0.4, -0.4, -0.2), {0.20, 0.08, 0.20},
         mottled({70, 104, 132}, {170, 196, 206}, {0.06, 0.06, 0.06}, 53), 3);
}

void bookcase(MeshBuilder& m, const SE3& pose, double width, double height, int shelves, std::uint64_t key) {
  const Paint board = wood({210, 184, 146}, {184, 152, 110}, key);
  constexpr double kDepth = 0.15;
  Random random(stream(key, 61));
  for (const double side : {-1.0, 1.0})
    m.box(pose * shift(side * (width / 2 - 0.01), -kDepth, height / 2), {0.01, kDepth, height / 2}, board);
  m.box(pose * shift(0, -0.005, height / 2), {width / 2, 0.005, height / 2}, board);
  for (int i = 0; i <= shelves; ++i) {
    const double z = 0.05 + (height - 0.06) * i / shelves;
    m.box(pose * shift(0, -kDepth, z), {width / 2 - 0.02, kDepth, 0.01}, board);
    if (i == shelves) break;
    const double share = random.uniform(0.35, 0.75) * (width - 0.1);
    const SE3 left = pose * shift(-width / 2 + 0.04, -0.14, z + 0.01);
    const double used = book_row(m, left, share, stream(key, 100 + static_cast<std::uint64_t>(i)));
    for (double x = used + 0.12; x < width - 0.14; x += random.uniform(0.15, 0.24)) {
      const double y = random.uniform(-0.04, 0.02), yaw = random.uniform(-1, 1);
      trinket(m, left * stand(x, y, 0, yaw), random);
    }
  }
}

void wall_shelf(MeshBuilder& m, const SE3& pose, double width, std::uint64_t key) {
  m.box(pose * shift(0, -0.12, 0), {width / 2, 0.12, 0.012}, wood({190, 150, 104}, {160, 118, 74}, key));
  for (const double x : {-0.4 * width, 0.4 * width}) {
    m.box(pose * shift(x, -0.01, -0.07), {0.015, 0.01, 0.07}, plain(kDark));
    m.box(pose * turned(x, -0.07, -0.07, 0.75, 0, 0), {0.008, 0.09, 0.008}, plain(kDark));
  }
  Random random(stream(key, 71));
  const SE3 left = pose * shift(-width / 2 + 0.03, -0.12, 0.012);
  const double used = book_row(m, left, 0.5 * width, stream(key, 72));
  for (double x = used + 0.1; x < width - 0.1; x += random.uniform(0.14, 0.2))
    trinket(m, left * stand(x, 0, 0), random);
}

void cabinet(MeshBuilder& m, const SE3& pose, const Vector3d& half, int drawers, Rgb front) {
  m.box(pose * shift(0, 0, half.z()), half, plain(blend(front, kBlack, 0.2)));
  const double step = (2 * half.z() - 0.06) / drawers;
  for (int i = 0; i < drawers; ++i) {
    const double z = 0.05 + (i + 0.5) * step;
    m.box(pose * shift(0, -half.y() - 0.008, z), {half.x() - 0.015, 0.008, step / 2 - 0.008}, plain(front));
    m.cylinder(pose * turned(-0.3 * half.x(), -half.y() - 0.04, z + 0.2 * step, 0, std::numbers::pi / 2, 0), 0.007,
               0.6 * half.x(), plain(kSteel), 12);
  }
}

void rug(MeshBuilder& m, const SE3& pose, const Vector2d& half, Rgb a, Rgb b) {
  const auto pile = [](double x, double y) { return 0.012 + 0.004 * lattice_noise({x / 0.05, y / 0.05, 0}, 81); };
  const auto paint = [=](const Vector3d& p) {
    const double x = std::abs(p.x()) / half.x(), y = std::abs(p.y()) / half.y();
    const double ring = std::max(x, y) * 6 + 0.5 * std::sin(12 * x) * std::sin(9 * y);
    return std::fmod(ring, 2.0) < 1 ? a : b;
  };
  m.sheet(pose, half, pile, paint);
}

// ---- things

void monitor(MeshBuilder& m, const SE3& pose) {
  const auto screen = [](const Vector3d& p) {
    if (p.z() > 0.12) return Rgb{60, 96, 150};
    const double line = std::fmod(p.z() + 1, 0.03) / 0.03;
    const bool text = line < 0.5 && lattice_noise({p.x() / 0.02, std::floor(p.z() / 0.03) * 5, 0}, 91) > -0.1;
    return text ? Rgb{60, 62, 70} : Rgb{226, 230, 234};
  };
  const SE3 panel = pose * turned(0, 0, 0.33, -0.08, 0, 0);
  m.cell = 0.01;
  m.box(panel * shift(0, -0.022, 0), {0.255, 0.002, 0.155}, screen);
  m.cell = 0.03;
  m.box(panel, {0.275, 0.02, 0.175}, plain(kBlack));
  m.blob(panel * shift(0, 0.025, 0), {0.16, 0.03, 0.12}, plain(kDark), 5);
  m.box(pose * shift(0, 0.05, 0.13), {0.035, 0.012, 0.13}, plain(kDark));
  m.blob(pose * shift(0, 0.02, 0.008), {0.13, 0.09, 0.008}, plain(kBlack), 4);
}

void laptop(MeshBuilder& m, const SE3& pose) {
  m.box(pose * shift(0, 0, 0.009), {0.17, 0.12, 0.009}, plain(kSteel));
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 13; ++column)
      m.box(pose * shift(-0.144 + 0.024 * column, -0.02 + 0.024 * row, 0.019), {0.010, 0.010, 0.002}, plain(kBlack));
  m.box(pose * shift(0, -0.08, 0.0185), {0.05, 0.03, 0.0008}, plain(kGrey));
  const SE3 lid = pose * turned(0, 0.15, 0.12, -0.28, 0, 0);
  m.box(lid, {0.17, 0.005, 0.115}, plain(kSteel));
  m.box(lid * shift(0, -0.006, 0), {0.16, 0.001, 0.105},
        mottled({44, 70, 120}, {150, 180, 214}, {0.08, 0.08, 0.08}, 92));
}

void keyboard(MeshBuilder& m, const SE3& pose) {
  m.box(pose * turned(0, 0, 0.012, 0.04, 0, 0), {0.225, 0.075, 0.009}, plain(kDark));
  for (int row = 0; row < 5; ++row) {
    for (int column = 0; column < 18; ++column) {
      const bool space = row == 0 && column > 4 && column < 11;
      if (space && column != 7) continue;
      const double y = -0.05 + 0.025 * row;
      m.box(pose * turned(-0.204 + 0.024 * column, y, 0.024 + 0.04 * y, 0.04, 0, 0),
            {space ? 0.08 : 0.0095, 0.0095, 0.005}, plain(column < 14 ? Rgb{206, 206, 200} : Rgb{160, 162, 164}));
    }
  }
}

void mouse(MeshBuilder& m, const SE3& pose) {
  m.blob(pose * shift(0, 0, 0.008), {0.03, 0.05, 0.026}, plain(kDark), 2.5, 14);
  m.tube(pose, {{0, 0.045, 0.01}, {0.02, 0.12, 0.006}, {-0.03, 0.2, 0.006}, {0.02, 0.3, 0.006}}, 0.004, plain(kBlack));
}

void telephone(MeshBuilder& m, const SE3& pose) {
  m.box(pose * turned(0, 0, 0.035, 0.2, 0, 0), {0.09, 0.1, 0.02}, plain(kDark));
  for (int i = 0; i < 12; ++i)
    m.box(pose * turned(0.01 + 0.025 * (i % 3), -0.06 + 0.025 * (i / 3), 0.05 + 0.005 * (i / 3), 0.2, 0, 0),
          {0.009, 0.008, 0.005}, plain(kWhite));
  m.blob(pose * turned(-0.06, 0, 0.075, 0.2, 0, 0), {0.022, 0.1, 0.018}, plain(kBlack), 4, 12);
  for (const double y : {-0.08, 0.08})
    m.blob(pose * turned(-0.06, y, 0.06 + 0.2 * y, 0, 0, 0), {0.028, 0.028, 0.02}, plain(kBlack));
}

void desk_lamp(MeshBuilder& m, const SE3& pose, Rgb color) {
  m.lathe(pose, {{0, 0}, {0.09, 0}, {0.088, 0.015}, {0.03, 0.025}, {0.012, 0.04}, {0, 0.04}}, plain(color));
  m.tube(pose, {{0, 0, 0.03}, {0, 0.06, 0.2}, {0, 0.09, 0.33}, {0, 0.02, 0.42}, {0, -0.1, 0.46}, {0, -0.14, 0.45}},
         0.008, plain(kSteel));
  m.lathe(pose * turned(0, -0.20, 0.36, -0.5, 0, 0),
          vessel({{0.085, 0}, {0.08, 0.03}, {0.06, 0.07}, {0.03, 0.10}, {0.02, 0.12}}, 0.003), plain(color));
}

void cup(MeshBuilder& m, const SE3& pose, Rgb color) {
  m.lathe(pose, vessel({{0.032, 0}, {0.036, 0.02}, {0.039, 0.05}, {0.041, 0.095}}, 0.004),
          [color](const Vector3d& p) { return p.z() > 0.06 && p.z() < 0.075 ? kWhite : color; });
  m.tube(pose, {{0.036, 0, 0.075}, {0.058, 0, 0.078}, {0.068, 0, 0.055}, {0.058, 0, 0.03}, {0.036, 0, 0.025}}, 0.006,
         plain(color));
}

void bottle(MeshBuilder& m, const SE3& pose, Rgb color) {
  m.lathe(pose,
          {{0, 0},
           {0.034, 0},
           {0.037, 0.01},
           {0.037, 0.09},
           {0.037, 0.16},
           {0.030, 0.20},
           {0.015, 0.235},
           {0.013, 0.28},
           {0.016, 0.285},
           {0.016, 0.30},
           {0, 0.30}},
          [color](const Vector3d& p) {
            if (p.z() > 0.28) return Rgb{200, 60, 50};
            return p.z() > 0.06 && p.z() < 0.15 ? Rgb{230, 224, 204} : color;
          });
}

void vase(MeshBuilder& m, const SE3& pose, Rgb color) {
  std::vector<Vector2d> outside;
  for (int i = 0; i <= 12; ++i) {
    const double s = i / 12.0;
    outside.emplace_back(0.035 + 0.035 * std::sin(std::numbers::pi * std::pow(s, 0.7)) - 0.012 * s, 0.22 * s);
  }
  m.lathe(pose, vessel(outside, 0.005), mottled(color, blend(color, kWhite, 0.5), {0.03, 0.03, 0.05}, 95));
}

void bowl_of_fruit(MeshBuilder& m, const SE3& pose, std::uint64_t key) {
  m.lathe(pose, vessel({{0.06, 0}, {0.09, 0.02}, {0.12, 0.05}, {0.14, 0.09}}, 0.006), plain({90, 130, 150}));
  constexpr std::array<Rgb, 4> kFruit = {{{200, 52, 40}, {232, 150, 40}, {150, 180, 60}, {226, 200, 70}}};
  Random random(stream(key, 97));
  for (int i = 0; i < 7; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / 6, r = i == 6 ? 0 : 0.075, size = random.uniform(0.034, 0.042);
    const Rgb c = kFruit[static_cast<std::size_t>(random.below(4))];
    m.blob(pose * shift(r * std::cos(azimuth), r * std::sin(azimuth), i == 6 ? 0.12 : 0.085), {size, size, 0.9 * size},
           mottled(c, blend(c, {120, 60, 30}, 0.4), {0.03, 0.03, 0.03}, key), 2, 14);
  }
}

void plate(MeshBuilder& m, const SE3& pose, double radius) {
  m.lathe(pose, vessel({{0.6 * radius, 0}, {0.7 * radius, 0.006}, {radius, 0.022}}, 0.004), plain(kWhite));
}

void pen_holder(MeshBuilder& m, const SE3& pose, std::uint64_t key) {
  m.lathe(pose, vessel({{0.04, 0}, {0.04, 0.05}, {0.04, 0.10}}, 0.003), plain(kDark));
  Random random(stream(key, 98));
  for (int i = 0; i < 7; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / 7;
    const double lean_x = random.uniform(-0.25, 0.25), lean_y = random.uniform(-0.25, 0.25);
    const double length = random.uniform(0.13, 0.17);
    const Rgb color = cover_color(random);
    m.cylinder(pose * turned(0.02 * std::cos(azimuth), 0.02 * std::sin(azimuth), 0.01, lean_x, lean_y, 0), 0.004,
               length, plain(color), 8);
  }
}

void book(MeshBuilder& m, const SE3& pose, const Vector3d& half, Rgb cover) {
  m.box(pose * shift(0.004, 0, half.z()), {half.x() - 0.006, half.y() - 0.004, half.z() - 0.003},
        plain({232, 226, 206}));
  const auto title = [=](const Vector3d& p) {
    const bool label = std::abs(p.x()) < 0.6 * half.x() && p.y() > 0.2 * half.y() && p.y() < 0.6 * half.y();
    return label ? blend(cover, kWhite, 0.7) : cover;
  };
  m.cell = 0.015;
  for (const double z : {0.0015, 2 * half.z() - 0.0015})
    m.box(pose * shift(0, 0, z), {half.x(), half.y(), 0.0015}, title);
  m.cell = 0.03;
  m.box(pose * shift(-half.x() + 0.001, 0, half.z()), {0.002, half.y(), half.z()}, plain(cover));
}

void book_stack(MeshBuilder& m, const SE3& pose, int count, std::uint64_t key) {
  Random random(stream(key, 101));
  double z = 0;
  for (int i = 0; i < count; ++i) {
    const double half_x = random.uniform(0.07, 0.11), half_y = random.uniform(0.10, 0.145);
    const Vector3d half(half_x, half_y, random.uniform(0.008, 0.024));
    const double x = random.uniform(-0.02, 0.02), y = random.uniform(-0.02, 0.02), yaw = random.uniform(-0.3, 0.3);
    book(m, pose * stand(x, y, z, yaw), half, cover_color(random));
    z += 2 * half.z();
  }
}

double book_row(MeshBuilder& m, const SE3& pose, double length, std::uint64_t key) {
  Random random(stream(key, 102));
  double x = 0;
  while (x < length) {
    const double thickness = random.uniform(0.009, 0.024), height = random.uniform(0.085, 0.125);
    const double lean = random.uniform() < 0.12 ? random.uniform(0.06, 0.16) : 0;
    x += thickness + height * std::sin(lean);
    // On its short edge, the spine to the front.
    const SE3 upright =
        turned(x, random.uniform(-0.015, 0.01), height + 0.003, 0, -std::numbers::pi / 2 + lean, std::numbers::pi / 2) *
        turned(0, 0, 0, 0, 0, 0);
    const SE3 place = pose * upright * turned(0, 0, -thickness, 0, 0, 0);
    const Rgb cover = cover_color(random);
    const double depth = random.uniform(0.065, 0.09);
    m.box(place * shift(0, 0, thickness), {height, thickness, depth},
          mottled(cover, blend(cover, kWhite, 0.4), {0.05, 0.2, 0.2}, stream(key, 5)));
    x += thickness + 0.001;
  }
  return x;
}

void open_book(MeshBuilder& m, const SE3& pose) {
  const auto page = [](double x, double) {
    return 0.006 + 0.022 * std::exp(-std::abs(x) / 0.07) - 0.02 * std::exp(-std::abs(x) / 0.012);
  };
  const auto text = [](const Vector3d& p) {
    const bool margin = std::abs(p.y()) > 0.11 || std::abs(p.x()) < 0.015 || std::abs(p.x()) > 0.145;
    const bool ink =
        std::fmod(p.y() + 1, 0.016) < 0.007 && lattice_noise({p.x() / 0.012, p.y() / 0.016, 0}, 103) > -0.2;
    return !margin && ink ? Rgb{96, 94, 90} : Rgb{238, 233, 216};
  };
  m.cell = 0.006;
  m.sheet(pose, {0.16, 0.125}, page, text, true);
  m.cell = 0.03;
}

void papers(MeshBuilder& m, const SE3& pose, std::uint64_t key) {
  Random random(stream(key, 104));
  m.cell = 0.012;
  for (int i = 0; i < 4; ++i) {
    const std::uint64_t k = stream(key, static_cast<std::uint64_t>(200 + i));
    const auto curl = [k](double x, double y) {
      return 0.004 + 0.12 * (x * x * y + 0.5 * y * y * x) * 4 + 0.003 * lattice_noise({x / 0.06, y / 0.06, 0}, k);
    };
    const auto ink = [k](const Vector3d& p) {
      const bool line = std::fmod(p.y() + 1, 0.02) < 0.009 && std::abs(p.x()) < 0.085;
      return line && lattice_noise({p.x() / 0.015, p.y() / 0.02, 0}, k) > -0.2 ? Rgb{110, 112, 118}
                                                                               : Rgb{242, 241, 236};
    };
    const double x = random.uniform(-0.06, 0.06), y = random.uniform(-0.05, 0.05), yaw = random.uniform(-0.6, 0.6);
    m.sheet(pose * stand(x, y, 0.003 + 0.004 * i, yaw), {0.105, 0.148}, curl, ink, true);
  }
  m.cell = 0.03;
}

void box_carton(MeshBuilder& m, const SE3& pose, const Vector3d& half) {
  const auto paint = [half](const Vector3d& p) {
    return std::abs(p.x()) < 0.025 && std::abs(p.z()) > 0.6 * half.z() ? Rgb{206, 188, 150} : Rgb{178, 138, 92};
  };
  m.box(pose * shift(0, 0, half.z()), half, paint);
  for (const double side : {-1.0, 1.0})
    m.sheet(
        pose * turned(side * (half.x() + 0.06), 0, 2 * half.z() + 0.01, 0, side * 0.5, 0), {0.07, half.y()},
        [](double x, double) { return 0.3 * x * x; }, plain({186, 148, 102}), true);
}

void globe(MeshBuilder& m, const SE3& pose) {
  m.lathe(pose, {{0, 0}, {0.08, 0}, {0.07, 0.015}, {0.015, 0.03}, {0.012, 0.07}, {0, 0.07}},
          wood({150, 100, 60}, {110, 70, 40}));
  const auto land = [](const Vector3d& p) {
    const double n = lattice_noise(p / 0.07, 111) + 0.5 * lattice_noise(p / 0.03, 112);
    return n > 0.1 ? blend({104, 142, 74}, {196, 176, 110}, 2 * n) : Rgb{62, 110, 168};
  };
  m.blob(pose * turned(0, 0, 0.20, 0.4, 0, 0), {0.12, 0.12, 0.12}, land, 2, 40);
  m.tube(pose, {{0.013, 0, 0.06}, {0.1, 0, 0.09}, {0.14, 0, 0.2}, {0.1, 0, 0.31}, {0, 0, 0.335}}, 0.006, plain(kSteel));
}

void plant(MeshBuilder& m, const SE3& pose, double height, std::uint64_t key) {
  const double rim = 0.16 * height + 0.03;
  m.lathe(pose,
          vessel({{0.7 * rim, 0},
                  {0.85 * rim, 0.5 * rim},
                  {rim, 1.3 * rim},
                  {1.06 * rim, 1.35 * rim},
                  {1.06 * rim, 1.55 * rim}},
                 0.008),
          plain({176, 96, 66}));
  m.cylinder(pose * shift(0, 0, 1.2 * rim), 0.92 * rim, 0.15 * rim,
             mottled({70, 52, 38}, {102, 78, 56}, {0.02, 0.02, 0.02}, key));
  Random random(stream(key, 121));
  const int leaves = 26;
  for (int i = 0; i < leaves; ++i) {
    const double azimuth = 2.399963 * i, rise = random.uniform(0.35, 1.0) * (height - 1.4 * rim),
                 reach = (1.15 - rise / height) * 0.42 * height;
    const SE3 stem = pose * stand(0, 0, 1.3 * rim, azimuth);
    const Vector3d tip(reach, 0, rise);
    m.tube(stem, {{0.01, 0, 0}, {0.25 * reach, 0, 0.6 * rise}, tip}, 0.004, plain({92, 120, 60}));
    const double length = random.uniform(0.16, 0.24) * height, droop = random.uniform(0.2, 1.0);
    const Rgb green = blend({44, 92, 44}, {126, 160, 70}, random.uniform());
    const auto blade = [=](double x, double y) {
      return -droop * (x + length) * (x + length) / (2 * length) * 0.6 + 1.2 * y * y / length;
    };
    m.cell = 0.015;
    // A leaf is a sheet that narrows: two halves of an ellipse, laid out by a flat blob bent through its paint-free
    // form.
    m.blob(
        stem * turned(tip.x(), 0, tip.z(), random.uniform(-0.3, 0.3), droop - 0.5, 0) * shift(length, 0, blade(0, 0)),
        {length, 0.28 * length, 0.006},
        [=](const Vector3d& p) {
          return std::abs(p.y()) < 0.004 ? blend(green, kWhite, 0.3)
                                         : blend(green, kBlack, 0.15 + 0.15 * std::sin(60 * p.x()));
        },
        2, 10);
    m.cell = 0.03;
  }
}

void teddy(MeshBuilder& m, const SE3& pose, double height, Rgb fur) {
  const double h = height;
  const auto coat = [=](double size, std::uint64_t key) {
    return mottled(fur, blend(fur, kBlack, 0.35), {size, size, size}, key);
  };
  const Paint body = coat(0.04 * h, 131), pale = plain(blend(fur, kWhite, 0.5));
  m.blob(pose * shift(0, 0, 0.32 * h), {0.21 * h, 0.19 * h, 0.28 * h}, body, 2.2, 32);
  m.blob(pose * shift(0, -0.05 * h, 0.72 * h), {0.19 * h, 0.17 * h, 0.18 * h}, body, 2.1, 32);
  m.blob(pose * shift(0, -0.11 * h, 0.32 * h), {0.14 * h, 0.105 * h, 0.18 * h}, pale, 2.2, 24);
  m.blob(pose * shift(0, -0.20 * h, 0.68 * h), {0.085 * h, 0.07 * h, 0.065 * h}, pale);
  m.blob(pose * shift(0, -0.265 * h, 0.70 * h), {0.03 * h, 0.02 * h, 0.02 * h}, plain(kBlack), 2, 12);
  for (const double side : {-1.0, 1.0}) {
    m.blob(pose * shift(side * 0.16 * h, 0, 0.88 * h), {0.075 * h, 0.035 * h, 0.075 * h}, body, 2, 16);
    m.blob(pose * shift(side * 0.16 * h, -0.025 * h, 0.88 * h), {0.05 * h, 0.02 * h, 0.05 * h}, pale, 2, 16);
    m.blob(pose * shift(side * 0.075 * h, -0.205 * h, 0.77 * h), {0.018 * h, 0.012 * h, 0.018 * h}, plain(kBlack), 2,
           10);
    m.blob(pose * turned(side * 0.26 * h, -0.08 * h, 0.42 * h, 0.5, side * 0.6, 0), {0.075 * h, 0.075 * h, 0.19 * h},
           body, 2.2);
    m.blob(pose * turned(side * 0.17 * h, -0.24 * h, 0.09 * h, std::numbers::pi / 2 - 0.1, 0, side * 0.3),
           {0.095 * h, 0.09 * h, 0.21 * h}, body, 2.2);
    m.blob(pose * turned(side * 0.225 * h, -0.425 * h, 0.11 * h, 0, 0, side * 0.3), {0.075 * h, 0.03 * h, 0.085 * h},
           pale, 2, 16);
  }
  m.blob(pose * shift(0, -0.16 * h, 0.555 * h), {0.03 * h, 0.025 * h, 0.03 * h}, plain({176, 40, 44}), 2, 12);
  for (const double side : {-1.0, 1.0})
    m.blob(pose * turned(side * 0.08 * h, -0.165 * h, 0.555 * h, 0, side * 0.3, 0), {0.065 * h, 0.022 * h, 0.045 * h},
           plain({196, 52, 52}), 1.5, 14);
}

void waste_bin(MeshBuilder& m, const SE3& pose) {
  m.lathe(pose, vessel({{0.11, 0}, {0.12, 0.1}, {0.13, 0.2}, {0.14, 0.3}}, 0.005), plain({70, 84, 96}));
  m.blob(pose * shift(0.02, 0, 0.22), {0.08, 0.07, 0.07}, mottled(kWhite, kGrey, {0.03, 0.03, 0.03}, 141), 1.5);
}

void computer_tower(MeshBuilder& m, const SE3& pose) {
  m.box(pose * shift(0, 0, 0.22), {0.09, 0.21, 0.21}, plain(kDark));
  m.box(pose * shift(0, -0.215, 0.22), {0.08, 0.006, 0.2}, plain(kBlack));
  for (int i = 0; i < 3; ++i) m.box(pose * shift(0, -0.223, 0.38 - 0.05 * i), {0.07, 0.004, 0.018}, plain(kGrey));
  m.cylinder(pose * turned(0, -0.22, 0.18, std::numbers::pi / 2, 0, 0), 0.015, 0.01, plain({80, 160, 210}), 16);
}

void ball(MeshBuilder& m, const SE3& pose, double radius, Rgb a, Rgb b) {
  const auto paint = [=](const Vector3d& p) {
    return std::sin(6 * std::atan2(p.y(), p.x())) * (p.z() > 0 ? 1 : -1) > 0 ? a : b;
  };
  m.blob(pose * turned(0, 0, radius, 0.5, 0.3, 0), {radius, radius, radius}, paint, 2, 28);
}

void pot(MeshBuilder& m, const SE3& pose, double radius, double height, Rgb color) {
  m.lathe(pose, vessel({{radius, 0}, {radius, 0.5 * height}, {radius, height}, {1.05 * radius, 1.02 * height}}, 0.003),
          plain(color), 40);
  for (const double side : {-1.0, 1.0})
    m.tube(pose,
           {{side * radius, -0.04, 0.8 * height},
            {side * (radius + 0.04), -0.035, 0.82 * height},
            {side * (radius + 0.04), 0.035, 0.82 * height},
            {side * radius, 0.04, 0.8 * height}},
           0.007, plain(kBlack));
}

void kettle(MeshBuilder& m, const SE3& pose) {
  m.lathe(pose,
          {{0, 0},
           {0.09, 0},
           {0.095, 0.03},
           {0.085, 0.10},
           {0.06, 0.17},
           {0.055, 0.18},
           {0.02, 0.19},
           {0.015, 0.21},
           {0, 0.215}},
          plain(kSteel), 40);
  m.tube(pose, {{0.07, 0, 0.16}, {0.12, 0, 0.17}, {0.13, 0, 0.10}, {0.09, 0, 0.05}}, 0.012, plain(kBlack));
  m.tube(pose, {{-0.08, 0, 0.08}, {-0.12, 0, 0.13}, {-0.14, 0, 0.17}}, 0.016, plain(kSteel));
}

void tap(MeshBuilder& m, const SE3& pose) {
  m.cylinder(pose, 0.025, 0.05, plain(kSteel));
  m.tube(pose, {{0, 0, 0.04}, {0, 0, 0.2}, {0, -0.03, 0.28}, {0, -0.12, 0.29}, {0, -0.16, 0.22}}, 0.012, plain(kSteel));
  m.tube(pose, {{0.02, 0, 0.05}, {0.06, 0, 0.08}, {0.11, 0, 0.12}}, 0.008, plain(kSteel));
}

void trinket(MeshBuilder& m, const SE3& pose, Random& random) {
  const std::uint64_t key = static_cast<std::uint64_t>(random.below(1 << 20));
  const Rgb color = cover_color(random);
  switch (random.below(7)) {
    case 0:
      return vase(m, pose, color);
    case 1:
      return cup(m, pose, color);
    case 2:
      return ball(m, pose, 0.06, color, kWhite);
    case 3:
      return plant(m, pose, 0.22, key);
    case 4:
      return teddy(m, pose, 0.2, blend(color, {170, 120, 70}, 0.6));
    case 5:
      return pen_holder(m, pose, key);
    default:
      return m.box(pose * shift(0, 0, 0.06), {0.05, 0.05, 0.06}, checkered(color, blend(color, kWhite, 0.6), 0.04));
  }
}

}  // namespace plumbline::sim::props
