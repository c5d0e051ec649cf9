// From readings to metres, smoothed depth, the pyramid and normals, against brute force in double and closed forms.
#include <cmath>
#include <limits>

#include "plumbline/angles.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using test::dirty_padding;
using test::make_plane;
using test::to_plane;

// Odd in both directions, so that rows end within a lane and the last row and column have no partner.
constexpr int kWidth = 161, kHeight = 121;

class Preprocess : public test::LaneTest {
 protected:
  Image<float> metres(const Image<std::uint16_t>& readings, float metres_per_reading, float low, float high) const {
    const auto raw = to_plane(backend(), readings);
    const auto depth = make_plane<float>(backend(), readings.width, readings.height);
    backend().run(kernels::ToMetres{read_only(raw), depth.view(), metres_per_reading, low, high});
    EXPECT_EQ(dirty_padding(backend(), depth), 0);
    return download(backend(), depth);
  }

  Image<float> bilateral(const Image<float>& depth, int radius, double sigma_space, double sigma_range) const {
    const auto in = to_plane(backend(), depth);
    const auto out = make_plane<float>(backend(), depth.width, depth.height);
    backend().run(kernels::BilateralFilter{read_only(in), out.view(), radius,
                                           static_cast<float>(0.5 / (sigma_space * sigma_space)),
                                           static_cast<float>(0.5 / (sigma_range * sigma_range))});
    EXPECT_EQ(dirty_padding(backend(), out), 0);
    return download(backend(), out);
  }

  Image<float> decimate(const Image<float>& depth, float range) const {
    const auto fine = to_plane(backend(), depth);
    const auto coarse = make_plane<float>(backend(), depth.width / 2, depth.height / 2);
    backend().run(kernels::DecimateDepth{read_only(fine), coarse.view(), range});
    EXPECT_EQ(dirty_padding(backend(), coarse), 0);
    return download(backend(), coarse);
  }

  test::View plane_normals(const Image<float>& depth, const Pinhole& camera, int radius = 3, float gate = 0.03f) const {
    DepthLevel level(camera, backend());
    upload(backend(), depth, level.depth);
    estimate_plane_normals(backend(), level, radius, gate);
    EXPECT_EQ(dirty_padding(backend(), level), 0);
    return test::to_view(backend(), level);
  }
};

/// The desk with a centimetre of noise and a tenth of the readings missing.
Image<float> noisy_desk(int width, int height) {
  static const sim::AnalyticScene scene = sim::desk_corner();
  const SE3 pose = sim::orbit().front().world_from_camera;
  Image<float> depth = test::view_of(scene, test::pinhole(width, height), pose).depth;
  test::Random random(7);
  for (float& z : depth.pixels) {
    z += static_cast<float>(random.uniform(-0.01, 0.01));
    if (random.uniform(0, 1) < 0.1) z = 0;
  }
  return depth;
}

Image<float> constant(int width, int height, float z) {
  Image<float> image(width, height);
  std::fill(image.pixels.begin(), image.pixels.end(), z);
  return image;
}

/// Columns before `first_far` at `near`, the others at `far`.
Image<float> step_edge(int width, int height, int first_far, float near, float far) {
  Image<float> image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.at(x, y) = x < first_far ? near : far;
  }
  return image;
}

// ---- metres ---------------------------------------------------------------------------------------------------------

TEST_P(Preprocess, MetresKeepTheLimitsAndDropWhatLiesBeyond) {
  // 1/1024 m a reading makes the limits exact.
  const std::uint16_t readings[] = {0, 1, 511, 512, 513, 8191, 8192, 8193, 65535};
  Image<std::uint16_t> raw(9, 2);
  for (int x = 0; x < 9; ++x) raw.at(x, 0) = raw.at(8 - x, 1) = readings[x];
  const Image<float> depth = metres(raw, 1.0f / 1024, 0.5f, 8.0f);
  const float expected[] = {0, 0, 0, 0.5f, 513.0f / 1024, 8191.0f / 1024, 8, 0, 0};
  for (int x = 0; x < 9; ++x) {
    EXPECT_EQ(depth.at(x, 0), expected[x]) << "reading " << readings[x];
    EXPECT_EQ(depth.at(8 - x, 1), expected[x]) << "reading " << readings[x];
  }
}

TEST_P(Preprocess, MetresUseAllSixteenBitsAndZeroStaysNone) {
  Image<std::uint16_t> raw(kWidth, kHeight);
  for (std::size_t i = 0; i < raw.pixels.size(); ++i) raw.pixels[i] = static_cast<std::uint16_t>(i * 977);
  const Image<float> depth = metres(raw, 1.0f / 5000, 0.0f, 100.0f);
  for (std::size_t i = 0; i < raw.pixels.size(); ++i)
    ASSERT_EQ(depth.pixels[i], static_cast<float>(raw.pixels[i]) * (1.0f / 5000));
}

// ---- bilateral filter -----------------------------------------------------------------------------------------------

double bilateral_at(const Image<float>& in, int x, int y, int radius, double sigma_space, double sigma_range) {
  const double centre = double{in.at(x, y)};
  if (centre == 0) return 0;
  double sum = 0, weights = 0;
  for (int yy = std::max(0, y - radius); yy <= std::min(in.height - 1, y + radius); ++yy) {
    for (int xx = std::max(0, x - radius); xx <= std::min(in.width - 1, x + radius); ++xx) {
      const double z = double{in.at(xx, yy)};
      if (z == 0) continue;
      const double space = (xx - x) * (xx - x) + (yy - y) * (yy - y), range = (z - centre) * (z - centre);
      const double w = std::exp(-space / (2 * sigma_space * sigma_space) - range / (2 * sigma_range * sigma_range));
      sum += w * z;
      weights += w;
    }
  }
  return sum / weights;
}

TEST_P(Preprocess, BilateralMatchesBruteForce) {
  const Image<float> in = noisy_desk(kWidth, kHeight);
  for (const int radius : {1, 6}) {
    const Image<float> out = bilateral(in, radius, 4.5, 0.03);
    double worst = 0, largest_change = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double expected = bilateral_at(in, x, y, radius, 4.5, 0.03);
        if (expected == 0) {
          ASSERT_EQ(out.at(x, y), 0) << "no reading must stay none, at " << x << ", " << y;
          continue;
        }
        worst = std::max(worst, std::abs(double{out.at(x, y)} - expected) / expected);
        largest_change = std::max(largest_change, std::abs(double{out.at(x, y)} - double{in.at(x, y)}));
      }
    }
    EXPECT_LT(worst, 1e-4);
    EXPECT_GT(largest_change, 3e-3) << "the filter did nothing";
  }
}

TEST_P(Preprocess, BilateralKeepsAConstantImage) {
  for (const float z : bilateral(constant(kWidth, kHeight, 1.7f), 6, 4.5, 0.03).pixels) ASSERT_NEAR(z, 1.7f, 1e-6f);
}

TEST_P(Preprocess, BilateralKeepsAStep) {
  const Image<float> out = bilateral(step_edge(kWidth, 33, 80, 1.0f, 1.5f), 6, 4.5, 0.03);
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < kWidth; ++x) ASSERT_NEAR(out.at(x, y), x < 80 ? 1.0f : 1.5f, 1e-5f);
  }
}

TEST_P(Preprocess, BilateralOfNothingIsNothing) {
  for (const float z : bilateral(constant(kWidth, 9, 0.0f), 6, 4.5, 0.03).pixels) ASSERT_EQ(z, 0);
}

// ---- decimation -----------------------------------------------------------------------------------------------------

double decimated_at(const Image<float>& fine, int x, int y, double range) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) {
    const double z = double{fine.at(2 * x + k % 2, 2 * y + k / 2)};
    if (z > 0) nearest = std::min(nearest, z);
  }
  double sum = 0;
  int count = 0;
  for (int k = 0; k < 4; ++k) {
    const double z = double{fine.at(2 * x + k % 2, 2 * y + k / 2)};
    if (z == 0 || z - nearest > range) continue;
    sum += z;
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

TEST_P(Preprocess, DecimationMatchesBruteForce) {
  const Image<float> fine = noisy_desk(kWidth, kHeight);
  const Image<float> coarse = decimate(fine, 0.09f);
  ASSERT_EQ(coarse.width, kWidth / 2);
  ASSERT_EQ(coarse.height, kHeight / 2);
  int missing = 0;
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      const double expected = decimated_at(fine, x, y, 0.09);
      missing += expected == 0;
      ASSERT_NEAR(double{coarse.at(x, y)}, expected, 1e-6) << x << ", " << y;
    }
  }
  EXPECT_LT(missing, coarse.width * coarse.height / 100) << "one reading of four is enough";
}

TEST_P(Preprocess, DecimatedPlaneStaysWhereItIs) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.5, -0.4, -1).normalized(), point(0, 0, 1.5);
  const sim::AnalyticScene scene{{sim::plane(point, normal)}};
  for (const bool y_up : {false, true}) {
    Pinhole camera = test::pinhole(kWidth, kHeight);
    if (y_up) camera.fy = -camera.fy;
    Image<float> depth = test::view_of(scene, camera, SE3()).depth;
    for (int level = 1; level <= 3; ++level) {
      depth = decimate(depth, 0.5f);
      const Pinhole coarse = camera.level(level);
      ASSERT_EQ(depth.width, coarse.width);
      double worst = 0;
      for (int y = 0; y < coarse.height; ++y) {
        for (int x = 0; x < coarse.width; ++x) {
          ASSERT_GT(depth.at(x, y), 0);
          const Eigen::Vector3d p = test::pixel_ray(coarse, x, y) * double{depth.at(x, y)};
          worst = std::max(worst, std::abs(normal.dot(p - point)));
        }
      }
      // The mean of four depths differs from the depth of the mean pixel by the curvature of 1/z alone, a quarter of
      // a millimetre here; half a pixel of offset would be 5 mm and more.
      EXPECT_LT(worst, 1e-4 * std::pow(4, level)) << "level " << level;
    }
  }
}

TEST_P(Preprocess, DecimationNeverMixesTheSidesOfAnEdge) {
  // An odd column: the edge runs through the middle of blocks.
  const Image<float> coarse = decimate(step_edge(kWidth, 32, 81, 1.0f, 1.5f), 0.09f);
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) ASSERT_EQ(coarse.at(x, y), x <= 40 ? 1.0f : 1.5f) << x;
  }
  const Image<float> mirrored = decimate(step_edge(kWidth, 32, 81, 1.5f, 1.0f), 0.09f);
  for (int x = 0; x < mirrored.width; ++x) ASSERT_EQ(mirrored.at(x, 3), x < 40 ? 1.5f : 1.0f) << x;
}

// ---- normals --------------------------------------------------------------------------------------------------------

/// Angles to the true normals where there is an estimate, radians.
std::vector<double> normal_errors(const test::View& estimate, const test::View& truth) {
  std::vector<double> errors;
  for (int v = 0; v < estimate.depth.height; ++v) {
    for (int u = 0; u < estimate.depth.width; ++u) {
      if (estimate.normal(u, v).norm() < 0.5 || truth.normal(u, v).norm() < 0.5) continue;
      EXPECT_NEAR(estimate.normal(u, v).norm(), 1, 1e-5);
      errors.push_back(test::angle_between(estimate.normal(u, v), truth.normal(u, v)));
    }
  }
  return errors;
}

struct SlantedPlane {
  Pinhole camera;
  test::View view;
};

/// Planes tilted every way, seen by cameras with y down and y up, of odd and even sizes. At 35° the image's corner sees
/// the plane under 72°: beyond that neighbouring depths differ by more than a gate of 3 %.
std::vector<SlantedPlane> slanted_planes() {
  std::vector<SlantedPlane> result;
  for (int i = 0; i < 8; ++i) {
    const double tilt = i < 4 ? 20 : 35, around = 45 + 90 * i;
    const Eigen::Vector3d normal(std::sin(tilt * kRadiansPerDegree) * std::cos(around * kRadiansPerDegree),
                                 std::sin(tilt * kRadiansPerDegree) * std::sin(around * kRadiansPerDegree),
                                 -std::cos(tilt * kRadiansPerDegree));
    Pinhole camera = i % 3 == 0 ? test::pinhole(160, 120) : test::pinhole(kWidth, kHeight);
    if (i % 2 == 1) camera.fy = -camera.fy;
    const sim::AnalyticScene scene{{sim::plane({0, 0, 1.4}, normal)}};
    result.push_back({camera, test::view_of(scene, camera, SE3())});
  }
  return result;
}

TEST_P(Preprocess, PlaneNormalsOfSlantedPlanes) {
  for (const SlantedPlane& plane : slanted_planes()) {
    const test::View estimate = plane_normals(plane.view.depth, plane.camera);
    const std::vector<double> errors = normal_errors(estimate, plane.view);
    EXPECT_EQ(errors.size(), plane.view.depth.pixels.size()) << "every pixel has a normal, the border's too";
    EXPECT_LT(test::quantile(errors, 1), 0.1 * kRadiansPerDegree);
  }
}

TEST_P(Preprocess, NormalsOfASphere) {
  const sim::AnalyticScene scene{{sim::sphere({0.1, -0.05, 1.5}, 0.5)}};
  for (const float sign : {1.0f, -1.0f}) {
    Pinhole camera = test::pinhole(kWidth, kHeight);
    camera.fy *= sign;
    const test::View truth = test::view_of(scene, camera, SE3());
    const std::vector<double> errors = normal_errors(plane_normals(truth.depth, camera), truth);
    EXPECT_GT(errors.size(), 4000u);
    EXPECT_LT(test::quantile(errors, 0.5), 1 * kRadiansPerDegree);
  }
}

TEST_P(Preprocess, NoReadingHasNoNormal) {
  const Pinhole camera = test::pinhole(kWidth, kHeight);
  const Image<float> depth = noisy_desk(kWidth, kHeight);
  const test::View normals = plane_normals(depth, camera);
  int without = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (depth.at(u, v) > 0) continue;
      ++without;
      ASSERT_EQ(normals.normal(u, v).norm(), 0);
    }
  }
  EXPECT_GT(without, 1000);
}

TEST_P(Preprocess, ALonelyReadingHasNoNormal) {
  Image<float> depth = constant(40, 30, 0.0f);
  for (const auto& [x, y] : {std::pair{5, 5}, {20, 15}, {21, 15}, {39, 0}, {0, 29}}) depth.at(x, y) = 1.0f;
  // A straight line of readings does not span a plane either.
  for (int x = 8; x < 30; ++x) depth.at(x, 25) = 1.0f;
  const test::View view = plane_normals(depth, test::pinhole(40, 30));
  for (int v = 0; v < 30; ++v) {
    for (int u = 0; u < 40; ++u) ASSERT_EQ(view.normal(u, v).norm(), 0) << u << ", " << v;
  }
}

TEST_P(Preprocess, PlaneNormalsDoNotMixTheSidesOfAnEdge) {
  const Image<float> depth = step_edge(kWidth, 40, 80, 1.0f, 1.5f);
  const test::View view = plane_normals(depth, test::pinhole(kWidth, 40));
  for (int v = 0; v < 40; ++v) {
    for (int u = 0; u < kWidth; ++u)
      ASSERT_LT(test::angle_between(view.normal(u, v), {0, 0, -1}), 0.1 * kRadiansPerDegree) << u << ", " << v;
  }
}

// ---- all together ---------------------------------------------------------------------------------------------------

TEST_P(Preprocess, AgreesWithPlainFloat) {
  // Another rounding may put a reading on the other side of a gate; hardly any, and the rest agree closely.
  const auto scalar = test::make_lanes("scalar");
  const Pinhole camera = test::pinhole(kWidth, kHeight);
  const Image<float> depth = bilateral(noisy_desk(kWidth, kHeight), 6, 4.5, 0.03);
  DepthLevel level(camera, *scalar);
  upload(*scalar, depth, level.depth);
  estimate_plane_normals(*scalar, level, 3, 0.03f);
  const test::View expected = test::to_view(*scalar, level), actual = plane_normals(depth, camera);
  int differing = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) differing += (expected.normal(u, v) - actual.normal(u, v)).norm() > 2e-3;
  }
  EXPECT_LT(differing, kWidth * kHeight / 1000);
}

PLUMBLINE_ON_EVERY_LANE_TYPE(Preprocess);

}  // namespace
}  // namespace plumbline
