#include "plumbline/depth_distortion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/random.h"
#include "plumbline/error.h"
#include "plumbline/image.h"

namespace plumbline {
namespace {

/// A parabola along each axis, which cubic convolution must reproduce everywhere, up to the edges.
double parabola(double x, double y) { return 0.002 + 1e-5 * x - 2e-5 * y + 3e-8 * x * y + 4e-8 * x * x - 5e-8 * y * y; }

DepthDistortion filled(int width, int height) {
  DepthDistortion d(width, height);
  const double step = (width - 1) / (DepthDistortion::kColumns - 1.0);
  for (int row = 0; row < d.rows(); ++row)
    for (int column = 0; column < DepthDistortion::kColumns; ++column)
      d.values()[static_cast<std::size_t>(row * DepthDistortion::kColumns + column)] =
          parabola(column * step, row * step);
  return d;
}

TEST(DepthDistortion, FollowsAParabolaUpToTheEdges) {
  const DepthDistortion d = filled(640, 480);
  EXPECT_EQ(d.rows(), 9);
  for (const double x : {0.0, 0.3, 63.9, 64.0, 320.2, 639.0})
    for (const double y : {0.0, 17.0, 240.5, 479.0}) {
      EXPECT_NEAR(d.at(x, y), parabola(x, y), 1e-9) << x << " " << y;
      const DepthDistortion::Nodes nodes = d.nodes(x, y);
      EXPECT_NEAR(std::accumulate(nodes.share.begin(), nodes.share.end(), 0.0), 1, 1e-12);
      EXPECT_LT(nodes.row(3) + 3, d.values().size());
    }
}

TEST(DepthDistortion, ItsSlopeDoesNotJumpAtANode) {
  DepthDistortion d(641, 481);
  Random random(1);
  for (double& value : d.values()) value = 0.01 * random.normal();
  constexpr double kStep = 1e-3;
  for (const double node : {64.0, 320.0, 576.0}) {
    const double before = d.at(node, 100) - d.at(node - kStep, 100), after = d.at(node + kStep, 100) - d.at(node, 100);
    EXPECT_NEAR(before / kStep, after / kStep, 1e-7);
    EXPECT_GT(std::abs(d.at(node + 32, 100) - d.at(node, 100)), 1e-4) << "there is something to follow";
  }
}

TEST(DepthDistortion, AFlatImageHasFourRowsOfNodesAllTheSame) {
  const DepthDistortion d = filled(640, 16);
  EXPECT_EQ(d.rows(), 4);
  EXPECT_NEAR(d.at(200, 15), parabola(200, 15), 1e-9);
}

TEST(DepthDistortion, TakesOutWhatASensorPutIn) {
  const DepthDistortion d = filled(64, 48);
  constexpr double kScale = 5000, kDepth = 2;
  DepthImage image(64, 48);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      image.at(x, y) = static_cast<std::uint16_t>(std::lround(kScale / (1 / kDepth + parabola(x, y))));
  image.at(5, 5) = 0;
  d.correct(kScale, &image);
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x) {
      if (x == 5 && y == 5)
        EXPECT_EQ(image.at(x, y), 0) << "no reading stays none";
      else
        EXPECT_NEAR(image.at(x, y), kScale * kDepth, 1.1) << x << " " << y;
    }
}

TEST(DepthDistortion, WhatWouldLieBehindInfinityIsNoReading) {
  DepthDistortion d(64, 48);
  for (double& value : d.values()) value = 0.2;
  DepthImage image(64, 48);
  image.at(1, 1) = 30000;  // 6 m: 0.167/m
  image.at(2, 2) = 24000;  // 4.8 m: 0.208/m, which would be 120 m
  image.at(3, 3) = 5000;
  d.correct(5000, &image);
  EXPECT_EQ(image.at(1, 1), 0);
  EXPECT_EQ(image.at(2, 2), 0);
  EXPECT_EQ(image.at(3, 3), 6250);
}

TEST(DepthDistortion, NoneLeavesImagesAloneAndOtherSizesAreRefused) {
  DepthImage image(32, 24);
  image.at(3, 3) = 1234;
  DepthDistortion().correct(5000, &image);
  EXPECT_EQ(image.at(3, 3), 1234);
  EXPECT_THROW(filled(64, 48).correct(5000, &image), Error);
  EXPECT_EQ(DepthDistortion().rms(), 0);
}

}  // namespace
}  // namespace plumbline
