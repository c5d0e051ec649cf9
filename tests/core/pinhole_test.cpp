#include "plumbline/pinhole.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr Pinhole kCamera{517.3f, 516.5f, 318.6f, 255.3f, 640, 480};

/// Where a pinhole sees the direction (x, y, 1).
double project_u(const Pinhole& k, double x) { return k.fx * x + k.cx; }
double project_v(const Pinhole& k, double y) { return k.fy * y + k.cy; }

TEST(Pinhole, ACoarsePixelsCentreIsTheJointCornerOfItsFourFinePixels) {
  const Pinhole coarse = kCamera.level(1);
  EXPECT_EQ(coarse.width, 320);
  EXPECT_EQ(coarse.height, 240);
  for (const int u : {0, 7, 159, 319}) {
    for (const int v : {0, 7, 120, 239}) {
      // Fine pixels 2u and 2u+1 meet at 2u + ½: centres have whole coordinates.
      const Vec3<double> ray = kCamera.back_project(2.0 * u + 0.5, 2.0 * v + 0.5, 1.0);
      EXPECT_NEAR(project_u(coarse, ray.x), u, 1e-4);
      EXPECT_NEAR(project_v(coarse, ray.y), v, 1e-4);
    }
  }
}

TEST(Pinhole, ImageBordersStayBordersAtEveryLevel) {
  for (int level = 0; level <= 3; ++level) {
    const Pinhole coarse = kCamera.level(level);
    const Vec3<double> left = kCamera.back_project(-0.5, -0.5, 1.0);
    const Vec3<double> right = kCamera.back_project(639.5, 479.5, 1.0);
    EXPECT_NEAR(project_u(coarse, left.x), -0.5, 1e-4);
    EXPECT_NEAR(project_v(coarse, left.y), -0.5, 1e-4);
    EXPECT_NEAR(project_u(coarse, right.x), coarse.width - 0.5, 1e-4);
    EXPECT_NEAR(project_v(coarse, right.y), coarse.height - 0.5, 1e-4);
  }
}

TEST(Pinhole, OddLastRowsAndColumnsFallAway) {
  const Pinhole odd{100, 100, 10, 10, 21, 15};
  EXPECT_EQ(odd.level(1).width, 10);
  EXPECT_EQ(odd.level(1).height, 7);
  EXPECT_EQ(odd.level(2).width, 5);
}

TEST(Pinhole, LevelsCompose) { EXPECT_EQ(kCamera.level(1).level(2), kCamera.level(3)); }

TEST(Pinhole, NegativeFyTurnsTheImageOver) {
  const Pinhole up{481.2f, -480.0f, 319.5f, 239.5f, 640, 480};
  EXPECT_TRUE(up.is_valid());
  EXPECT_GT(up.back_project(319.5, 0.0, 2.0).y, 0);
  EXPECT_NEAR(project_v(up, up.back_project(3.0, 77.0, 1.0).y), 77.0, 1e-4);
}

TEST(Pinhole, BadIntrinsicsAreNotValid) {
  EXPECT_TRUE(kCamera.is_valid());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE((Pinhole{nan, 1, 0, 0, 4, 4}.is_valid()));
  EXPECT_FALSE((Pinhole{1, nan, 0, 0, 4, 4}.is_valid()));
  EXPECT_FALSE((Pinhole{1, 1, nan, 0, 4, 4}.is_valid()));
  EXPECT_FALSE((Pinhole{1, 1, 0, INFINITY, 4, 4}.is_valid()));
  EXPECT_FALSE((Pinhole{0, 1, 0, 0, 4, 4}.is_valid()));
  EXPECT_FALSE((Pinhole{1, 0, 0, 0, 4, 4}.is_valid()));
  EXPECT_FALSE((Pinhole{1, 1, 0, 0, 0, 4}.is_valid()));
  EXPECT_FALSE(Pinhole().is_valid());
}

TEST(Distortion, NoneLeavesPointsWhereTheyAre) {
  const Distortion none;
  EXPECT_TRUE(none.is_zero());
  double x = 0, y = 0;
  none.apply(0.3, -0.2, &x, &y);
  EXPECT_DOUBLE_EQ(x, 0.3);
  EXPECT_DOUBLE_EQ(y, -0.2);
}

TEST(Distortion, RadialTermsScaleAlongTheRay) {
  const Distortion radial{0.2, -0.5, 0, 0, 1.1};
  EXPECT_FALSE(radial.is_zero());
  double x = 0, y = 0;
  radial.apply(0.3, 0.4, &x, &y);  // r² = 0.25
  const double factor = 1 + 0.2 * 0.25 - 0.5 * 0.0625 + 1.1 * 0.015625;
  EXPECT_NEAR(x, 0.3 * factor, 1e-15);
  EXPECT_NEAR(y, 0.4 * factor, 1e-15);
}

TEST(Distortion, TangentialTermsFollowOpenCvsOrder) {
  // By hand from the documentation of OpenCV's calib3d: x' = 2 p1 xy + p2 (r² + 2x²), y' = p1 (r² + 2y²) + 2 p2 xy.
  double x = 0, y = 0;
  Distortion{0, 0, 0.01, 0, 0}.apply(0.3, 0.4, &x, &y);
  EXPECT_NEAR(x, 0.3 + 0.0024, 1e-15);
  EXPECT_NEAR(y, 0.4 + 0.0057, 1e-15);
  Distortion{0, 0, 0, 0.01, 0}.apply(0.3, 0.4, &x, &y);
  EXPECT_NEAR(x, 0.3 + 0.0043, 1e-15);
  EXPECT_NEAR(y, 0.4 + 0.0024, 1e-15);
}

}  // namespace
}  // namespace plumbline
