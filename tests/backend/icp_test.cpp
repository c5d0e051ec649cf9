// One pass of registration against the same association in double, its Jacobian against numerical derivatives, and
// each gate in a case made for it.
#include <tbb/global_control.h>

#include <cstring>
#include <numeric>

#include "plumbline/angles.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "support/lane_types.h"
#include "support/scenes.h"

namespace plumbline {
namespace {

using kernels::PixelUse;

struct Gates {
  double distance = 0.1, cos_normal = std::cos(20 * kRadiansPerDegree);
  double band_low = 0, band_high = 1e9;
  int bins = 1000;
  double range = 0.5;  // metres, of the histogram
};

/// A live and a model view, and the estimate of the motion between them.
struct Problem {
  Pinhole live_camera, model_camera;
  test::View live, model;
  SE3 model_from_live;
  Gates gates;
};

/// The desk from two poses 2 cm and 1° apart; the estimate is half way, so that residuals are neither zero nor huge.
Problem desk_problem() {
  static const sim::AnalyticScene scene = sim::desk_corner();
  const Pinhole camera = test::pinhole(160, 120);
  const SE3 world_from_model = sim::orbit().front().world_from_camera;
  const SE3 truth = test::Random(5).motion(1 * kRadiansPerDegree, 0.02);
  Problem problem{camera,
                  camera,
                  test::view_of(scene, camera, world_from_model * truth),
                  test::view_of(scene, camera, world_from_model),
                  SE3::exp(0.5 * truth.log()),
                  {}};
  test::Random random(6);
  for (float& z : problem.live.depth.pixels) z = random.uniform(0, 1) < 0.05 ? 0 : z;
  for (float& z : problem.model.depth.pixels) z = random.uniform(0, 1) < 0.05 ? 0 : z;
  return problem;
}

/// What one live pixel contributes, in double.
struct Pair {
  PixelUse use = PixelUse::used;
  // Live point, model point and normal, in the model's camera.
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), q = Eigen::Vector3d::Zero(), n = Eigen::Vector3d::Zero();
  double distance() const { return (q - p).norm(); }
  double residual() const { return n.dot(q - p); }
};

Pair associate(const Problem& problem, int u, int v) {
  Pair pair;
  const auto with = [&](PixelUse use) {
    pair.use = use;
    return pair;
  };
  const double z = double{problem.live.depth.at(u, v)};
  if (z == 0) return with(PixelUse::no_depth);
  if (problem.live.normal(u, v).norm() < 0.5) return with(PixelUse::no_normal);
  pair.p = problem.model_from_live * (test::pixel_ray(problem.live_camera, u, v) * z);
  const Pinhole& k = problem.model_camera;
  if (pair.p.z() <= 0) return with(PixelUse::out_of_view);
  const double mu = std::floor(pair.p.x() / pair.p.z() * double{k.fx} + double{k.cx} + 0.5);
  const double mv = std::floor(pair.p.y() / pair.p.z() * double{k.fy} + double{k.cy} + 0.5);
  if (mu < 0 || mv < 0 || mu >= k.width || mv >= k.height) return with(PixelUse::out_of_view);
  const int x = static_cast<int>(mu), y = static_cast<int>(mv);
  const double model_z = double{problem.model.depth.at(x, y)};
  if (model_z == 0) return with(PixelUse::no_model);
  pair.q = test::pixel_ray(k, x, y) * model_z;
  pair.n = problem.model.normal(x, y);
  const Gates& gates = problem.gates;
  if (pair.distance() > gates.distance) return with(PixelUse::distance);
  if (pair.n.dot(problem.model_from_live.rotation() * problem.live.normal(u, v)) < gates.cos_normal)
    return with(PixelUse::angle);
  if (pair.distance() < gates.band_low || pair.distance() > gates.band_high) return with(PixelUse::filtered);
  return pair;
}

bool in_distribution(PixelUse use) {
  return use == PixelUse::used || use == PixelUse::filtered || use == PixelUse::angle || use == PixelUse::distance;
}

std::vector<Pair> all_pairs(const Problem& problem) {
  std::vector<Pair> pairs;
  for (int v = 0; v < problem.live_camera.height; ++v) {
    for (int u = 0; u < problem.live_camera.width; ++u) pairs.push_back(associate(problem, u, v));
  }
  return pairs;
}

/// The problem's images in a backend's memory, and the kernel's input that refers to them.
struct Uploaded {
  DepthLevel live, model;
  kernels::IcpInput in;

  Uploaded(const Backend& backend, const Problem& problem)
      : live(test::to_level(backend, problem.live_camera, problem.live)),
        model(test::to_level(backend, problem.model_camera, problem.model)),
        in(icp_input(live, model)) {
    in.model_from_live = to_kernel(problem.model_from_live);
    in.distance_gate = static_cast<float>(problem.gates.distance);
    in.cos_normal_gate = static_cast<float>(problem.gates.cos_normal);
    in.band_low = static_cast<float>(problem.gates.band_low);
    in.band_high = static_cast<float>(problem.gates.band_high);
    in.bins = problem.gates.bins;
    in.bins_per_metre = static_cast<float>(problem.gates.bins / problem.gates.range);
  }
};

IcpSums reduce(const Backend& backend, const Problem& problem) {
  const Uploaded uploaded(backend, problem);
  return backend.reduce(kernels::IcpReduce{uploaded.in});
}

Image<std::uint8_t> explain(const Backend& backend, const Problem& problem) {
  const Uploaded uploaded(backend, problem);
  const auto use = test::make_plane<std::uint8_t>(backend, problem.live_camera.width, problem.live_camera.height);
  backend.run(kernels::ExplainPixels{uploaded.in, use.view()});
  EXPECT_EQ(test::dirty_padding(backend, use), 0);
  return download(backend, use);
}

int count(const Image<std::uint8_t>& use, PixelUse code) {
  return static_cast<int>(std::count(use.pixels.begin(), use.pixels.end(), static_cast<std::uint8_t>(code)));
}

class Icp : public test::LaneTest {};

// Single precision rounds a few projections to the neighbouring pixel; they are 1e-4 of the sums and less.
constexpr double kSumTolerance = 1e-3;

TEST_P(Icp, SumsMatchBruteForce) {
  const Problem problem = desk_problem();
  Matrix6d h = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double squares = 0;
  int used = 0, with_depth = 0, pairs = 0;
  for (const Pair& pair : all_pairs(problem)) {
    with_depth += pair.use != PixelUse::no_depth;
    pairs += in_distribution(pair.use);
    if (pair.use != PixelUse::used) continue;
    Vector6d a;
    a << pair.p.cross(pair.n), pair.n;
    h += a * a.transpose();
    b += a * pair.residual();
    squares += pair.residual() * pair.residual();
    ++used;
  }
  ASSERT_GT(used, 8000);
  const IcpSums sums = reduce(backend(), problem);
  EXPECT_EQ(sums.with_depth(), with_depth);
  EXPECT_NEAR(sums.pairs(), pairs, 1e-3 * pairs);
  EXPECT_NEAR(sums.inliers(), used, 1e-3 * used);
  EXPECT_LT((sums.hessian() - h).norm(), kSumTolerance * h.norm());
  EXPECT_LT((sums.hessian() - sums.hessian().transpose()).norm(), 1e-300);
  EXPECT_LT((sums.gradient() - b).norm(), kSumTolerance * b.norm() + 1e-3);
  EXPECT_NEAR(sums.squares(), squares, 0.01 * squares);
}

// σ(z) = 1.2 + 1.9 (z − 0.4)² mm, in units of 5 mm.
constexpr kernels::NoiseModel kNoise = {0.24f, 0.38f, 0.4f};
constexpr double kHuber = 0.004;

TEST_P(Icp, WeightsAreThoseOfDepthNoiseAndHuber) {
  const Problem problem = desk_problem();
  Matrix6d h = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  int beyond = 0;
  for (int v = 0; v < problem.live_camera.height; ++v) {
    for (int u = 0; u < problem.live_camera.width; ++u) {
      const Pair pair = associate(problem, u, v);
      if (pair.use != PixelUse::used) continue;
      const double z = double{problem.live.depth.at(u, v)}, r = pair.residual();
      const double sigma = 0.24 + 0.38 * (z - 0.4) * (z - 0.4);
      const double weight = 1 / (sigma * sigma) * (std::abs(r) > kHuber ? kHuber / std::abs(r) : 1);
      beyond += std::abs(r) > kHuber;
      Vector6d a;
      a << pair.p.cross(pair.n), pair.n;
      h += weight * a * a.transpose();
      b += weight * a * r;
    }
  }
  ASSERT_GT(beyond, 1000);
  Uploaded uploaded(backend(), problem);
  uploaded.in.noise = kNoise;
  uploaded.in.huber = static_cast<float>(kHuber);
  const IcpSums sums = backend().reduce(kernels::IcpReduce{uploaded.in});
  EXPECT_LT((sums.hessian() - h).norm(), kSumTolerance * h.norm());
  EXPECT_LT((sums.gradient() - b).norm(), kSumTolerance * b.norm() + 1e-3);
  const IcpSums plain = reduce(backend(), problem);
  EXPECT_GT((sums.hessian() - plain.hessian()).norm(), 0.1 * h.norm());
  EXPECT_EQ(sums.inliers(), plain.inliers());
  EXPECT_EQ(sums.squares(), plain.squares()) << "the residual that is reported has no weights";
}

TEST_P(Icp, ACorrectedPassIsThePassWithTheBandItself) {
  const Problem problem = desk_problem();
  Uploaded uploaded(backend(), problem);
  uploaded.in.noise = kNoise;
  uploaded.in.huber = static_cast<float>(kHuber);
  const auto distances = test::make_plane<float>(backend(), problem.live_camera.width, problem.live_camera.height);
  const struct { float low, high; } bands[] = {{0, 0.02f}, {0.01f, 0.05f}, {0.2f, 0.3f}, {0, 1}, {0.004f, 0.006f}};
  for (const auto& from : bands) {
    for (const auto& to : bands) {
      uploaded.in.band_low = from.low;
      uploaded.in.band_high = from.high;
      IcpSums corrected = backend().reduce(kernels::IcpReduce{uploaded.in, distances.view()});
      EXPECT_EQ(test::dirty_padding(backend(), distances), 0);
      uploaded.in.band_low = to.low;
      uploaded.in.band_high = to.high;
      backend().correct(kernels::IcpCorrection{uploaded.in, from.low, from.high, read_only(distances)}, &corrected);
      const IcpSums direct = backend().reduce(kernels::IcpReduce{uploaded.in});
      EXPECT_EQ(corrected.inliers(), direct.inliers());
      EXPECT_EQ(corrected.histogram, direct.histogram);
      // What is added and taken away again leaves its rounding.
      EXPECT_LT((corrected.hessian() - direct.hessian()).norm(), 1e-6 * reduce(backend(), problem).hessian().norm());
      EXPECT_LT((corrected.gradient() - direct.gradient()).norm(), 1e-5 * (1 + direct.gradient().norm()));
    }
  }
}

/// Σ ½ r² of the used pairs after the left perturbation p ← exp(ξ) p, the association kept.
double cost(const std::vector<Pair>& pairs, const Vector6d& xi) {
  const SE3 step = SE3::exp(xi);
  double sum = 0;
  for (const Pair& pair : pairs) {
    if (pair.use != PixelUse::used) continue;
    const double r = pair.n.dot(pair.q - step * pair.p);
    sum += 0.5 * r * r;
  }
  return sum;
}

TEST_P(Icp, JacobianIsTheDerivativeByTheLeftPerturbation) {
  const Problem problem = desk_problem();
  const std::vector<Pair> pairs = all_pairs(problem);
  const IcpSums sums = reduce(backend(), problem);
  constexpr double kStep = 1e-5;
  Vector6d numeric;
  Matrix6d gauss_newton = Matrix6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6d xi = Vector6d::Unit(i) * kStep;
    numeric[i] = (cost(pairs, xi) - cost(pairs, -xi)) / (2 * kStep);
  }
  EXPECT_LT((sums.gradient() + numeric).norm(), kSumTolerance * numeric.norm() + 1e-3);

  for (const Pair& pair : pairs) {
    if (pair.use != PixelUse::used) continue;
    Vector6d derivative;
    for (int i = 0; i < 6; ++i) {
      const Vector6d xi = Vector6d::Unit(i) * kStep;
      derivative[i] = pair.n.dot(SE3::exp(-xi) * pair.p - SE3::exp(xi) * pair.p) / (2 * kStep);
    }
    gauss_newton += derivative * derivative.transpose();
  }
  EXPECT_LT((sums.hessian() - gauss_newton).norm(), kSumTolerance * gauss_newton.norm());
}

TEST_P(Icp, AStepAlongTheGradientReducesTheCost) {
  const Problem problem = desk_problem();
  const IcpSums sums = reduce(backend(), problem);
  const Vector6d step = sums.hessian().ldlt().solve(sums.gradient());
  const std::vector<Pair> pairs = all_pairs(problem);
  EXPECT_LT(cost(pairs, step), 0.3 * cost(pairs, Vector6d::Zero()));
}

TEST_P(Icp, HistogramHoldsEveryPair) {
  Problem problem = desk_problem();
  problem.gates.range = 0.05;
  problem.gates.bins = 100;
  std::vector<double> distances;
  for (const Pair& pair : all_pairs(problem)) {
    if (in_distribution(pair.use)) distances.push_back(pair.distance());
  }
  const IcpSums sums = reduce(backend(), problem);
  ASSERT_EQ(sums.histogram.size(), 101u) << "the last bin counts what lies beyond";
  EXPECT_NEAR(sums.bin_width, 0.0005, 1e-9);
  EXPECT_EQ(std::accumulate(sums.histogram.begin(), sums.histogram.end(), 0), sums.pairs());

  std::vector<int> expected(101, 0);
  for (const double d : distances) ++expected[static_cast<std::size_t>(std::min(100.0, d / 0.0005))];
  int moved = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) moved += std::abs(expected[i] - sums.histogram[i]);
  EXPECT_LT(moved, 0.01 * static_cast<double>(distances.size())) << "pairs in another bin";
  EXPECT_GT(expected.back(), 10) << "the case has pairs beyond the range";

  std::sort(distances.begin(), distances.end());
  const double median = distances[(distances.size() - 1) / 2];
  EXPECT_NEAR(sums.median_bin(), std::floor(median / 0.0005), 1);
  EXPECT_NEAR(sums.median_distance(), median, 0.0006);
}

TEST_P(Icp, AMedianBeyondTheRangeIsTheRangesEnd) {
  Problem problem = desk_problem();
  problem.gates.range = 0.001;
  problem.gates.bins = 10;
  const IcpSums sums = reduce(backend(), problem);
  EXPECT_EQ(sums.median_bin(), 10);
  EXPECT_NEAR(sums.median_distance(), 0.001, 1e-8);
}

TEST_P(Icp, WithoutBinsTheSumsAreTheSame) {
  Problem problem = desk_problem();
  const IcpSums counted = reduce(backend(), problem);
  problem.gates.bins = 0;
  const IcpSums sums = reduce(backend(), problem);
  for (int slot = 0; slot < kernels::icp_sum::kCount; ++slot) EXPECT_EQ(sums.slots[slot], counted.slots[slot]) << slot;
  EXPECT_EQ(sums.median_bin(), -1);
  EXPECT_EQ(sums.median_distance(), 0);
  EXPECT_EQ(sums.bin_width, 0);
}

TEST_P(Icp, NothingToPairGivesZeros) {
  Problem problem = desk_problem();
  std::fill(problem.model.depth.pixels.begin(), problem.model.depth.pixels.end(), 0.0f);
  const IcpSums sums = reduce(backend(), problem);
  EXPECT_GT(sums.with_depth(), 10000);
  EXPECT_EQ(sums.pairs(), 0);
  EXPECT_EQ(sums.inliers(), 0);
  EXPECT_EQ(sums.hessian().norm(), 0);
  EXPECT_EQ(sums.gradient().norm(), 0);
  EXPECT_EQ(sums.median_bin(), -1);
  EXPECT_EQ(sums.median_distance(), 0);
}

// ---- gates ----------------------------------------------------------------------------------------------------------

/// A wall one metre ahead, live and predicted alike, but for one pixel of each kind; the model's image is narrower.
struct GateCase {
  Problem problem;
  Image<std::uint8_t> expected;

  static constexpr int kWidth = 33, kHeight = 24, kModelWidth = 29;

  GateCase() : problem(wall()), expected(kWidth, kHeight) {
    for (int v = 0; v < kHeight; ++v) {
      for (int u = kModelWidth; u < kWidth; ++u) expect(u, v, PixelUse::out_of_view);
    }
    problem.live.depth.at(3, 2) = 0;
    expect(3, 2, PixelUse::no_depth);
    problem.live.normal_z.at(4, 2) = 0;
    expect(4, 2, PixelUse::no_normal);
    problem.model.depth.at(8, 5) = 0;
    expect(8, 5, PixelUse::no_model);
    problem.model.depth.at(9, 5) = 1.2f;
    expect(9, 5, PixelUse::distance);
    problem.model.depth.at(20, 13) = 1.05f;
    expect(20, 13, PixelUse::filtered);
    const auto tilt = [&](int u, int v, double degrees) {
      problem.model.normal_x.at(u, v) = static_cast<float>(std::sin(degrees * kRadiansPerDegree));
      problem.model.normal_z.at(u, v) = static_cast<float>(-std::cos(degrees * kRadiansPerDegree));
    };
    tilt(21, 13, 21);
    expect(21, 13, PixelUse::angle);
    tilt(22, 13, 19);
    expect(22, 13, PixelUse::used);
    // The first reason in the order of the codes is the one that is told.
    problem.model.depth.at(10, 20) = 1.2f;
    tilt(10, 20, 90);
    expect(10, 20, PixelUse::distance);
  }

 private:
  void expect(int u, int v, PixelUse use) { expected.at(u, v) = static_cast<std::uint8_t>(use); }

  static Problem wall() {
    const Pinhole live = test::pinhole(kWidth, kHeight);
    Pinhole model = live;
    model.width = kModelWidth;
    const sim::AnalyticScene scene{{sim::plane({0, 0, 1}, {0, 0, -1})}};
    Problem problem{live, model, test::view_of(scene, live, SE3()), test::view_of(scene, model, SE3()), SE3(), {}};
    problem.gates.band_high = 0.03;
    return problem;
  }
};

TEST_P(Icp, EachGateHasItsCode) {
  const GateCase gates;
  const Image<std::uint8_t> use = explain(backend(), gates.problem);
  for (int v = 0; v < use.height; ++v) {
    for (int u = 0; u < use.width; ++u) ASSERT_EQ(int{use.at(u, v)}, int{gates.expected.at(u, v)}) << u << ", " << v;
  }
  for (int code = 0; code <= static_cast<int>(PixelUse::filtered); ++code)
    EXPECT_GT(count(gates.expected, static_cast<PixelUse>(code)), 0) << "the case lacks code " << code;

  const IcpSums sums = reduce(backend(), gates.problem);
  const int pixels = GateCase::kWidth * GateCase::kHeight;
  EXPECT_EQ(sums.with_depth(), pixels - count(use, PixelUse::no_depth));
  EXPECT_EQ(sums.inliers(), count(use, PixelUse::used));
  EXPECT_EQ(sums.pairs(), count(use, PixelUse::used) + count(use, PixelUse::filtered) + count(use, PixelUse::angle) +
                              count(use, PixelUse::distance));
}

TEST_P(Icp, TheBandHasTwoEnds) {
  GateCase gates;
  gates.problem.gates.band_low = 0.01;
  gates.problem.gates.band_high = 0.06;
  const Image<std::uint8_t> use = explain(backend(), gates.problem);
  EXPECT_EQ(count(use, PixelUse::used), 1) << "only the pixel that is 5 cm off";
  EXPECT_EQ(int{use.at(20, 13)}, 0);
  EXPECT_EQ(reduce(backend(), gates.problem).inliers(), 1);
}

TEST_P(Icp, WhatLiesBehindTheModelsCameraIsOutOfView) {
  Problem problem = desk_problem();
  problem.model_from_live = SE3(so3::exp({0, std::numbers::pi, 0}), Eigen::Vector3d::Zero());
  const Image<std::uint8_t> use = explain(backend(), problem);
  EXPECT_EQ(count(use, PixelUse::out_of_view) + count(use, PixelUse::no_depth), 160 * 120);
  EXPECT_GT(count(use, PixelUse::out_of_view), 15000);
  EXPECT_EQ(reduce(backend(), problem).pairs(), 0);
}

TEST_P(Icp, ExplainedPixelsAreThoseOfTheSums) {
  Problem problem = desk_problem();
  problem.gates.band_high = 0.02;
  const Image<std::uint8_t> use = explain(backend(), problem);
  const IcpSums sums = reduce(backend(), problem);
  EXPECT_EQ(sums.inliers(), count(use, PixelUse::used));
  EXPECT_GT(count(use, PixelUse::filtered), 0);
  EXPECT_GT(count(use, PixelUse::angle), 0);
  EXPECT_GT(count(use, PixelUse::distance), 0);
  const std::vector<Pair> pairs = all_pairs(problem);
  int differing = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) differing += use.pixels[i] != static_cast<std::uint8_t>(pairs[i].use);
  EXPECT_LT(differing, 40) << "of 19200, at the borders of gates and pixels";
}

TEST_P(Icp, WorksForACameraWithYUp) {
  Problem problem = desk_problem();
  const sim::AnalyticScene scene = sim::desk_corner();
  problem.live_camera.fy = problem.model_camera.fy = -problem.live_camera.fy;
  const SE3 pose = sim::orbit().front().world_from_camera;
  problem.live = test::view_of(scene, problem.live_camera, pose * problem.model_from_live);
  problem.model = test::view_of(scene, problem.model_camera, pose);
  const IcpSums sums = reduce(backend(), problem);
  EXPECT_GT(sums.inliers(), 15000);
  EXPECT_LT(std::sqrt(sums.squares() / sums.inliers()), 2e-3) << "the estimate is the truth";
}

// ---- repeatability --------------------------------------------------------------------------------------------------

TEST_P(Icp, SameBitsForAnyNumberOfThreadsAndEachTime) {
  const tbb::global_control more_than_cores(tbb::global_control::max_allowed_parallelism, 7);
  const Problem problem = desk_problem();
  const IcpSums one = reduce(backend(), problem);
  for (const int threads : {1, 2, 7}) {
    const auto other_backend = test::make_lanes(GetParam(), threads);
    for (int repetition = 0; repetition < 3; ++repetition) {
      const IcpSums other = reduce(*other_backend, problem);
      EXPECT_EQ(std::memcmp(one.slots, other.slots, sizeof one.slots), 0) << threads << " threads";
      EXPECT_EQ(one.histogram, other.histogram);
    }
  }
}

TEST_P(Icp, AgreesWithPlainFloat) {
  const Problem problem = desk_problem();
  const IcpSums expected = reduce(*test::make_lanes("scalar"), problem), actual = reduce(backend(), problem);
  EXPECT_NEAR(actual.inliers(), expected.inliers(), 10);
  EXPECT_LT((actual.hessian() - expected.hessian()).norm(), kSumTolerance * expected.hessian().norm());
  EXPECT_LT((actual.gradient() - expected.gradient()).norm(), kSumTolerance * expected.gradient().norm() + 1e-3);
}

PLUMBLINE_ON_EVERY_LANE_TYPE(Icp);

TEST(IcpSums, MedianOfAHistogram) {
  IcpSums sums;
  sums.bin_width = 0.01;
  sums.histogram = {0, 0, 0, 0};
  EXPECT_EQ(sums.median_bin(), -1);
  sums.histogram = {3, 2, 1, 0};  // the third of six is the lower median
  EXPECT_EQ(sums.median_bin(), 0);
  sums.histogram = {2, 2, 1, 0};
  EXPECT_EQ(sums.median_bin(), 1);
  EXPECT_DOUBLE_EQ(sums.median_distance(), 0.015);
  sums.histogram = {1, 1, 1, 4};
  EXPECT_EQ(sums.median_bin(), 3);
  EXPECT_DOUBLE_EQ(sums.median_distance(), 0.03) << "beyond the range: its end";
}

}  // namespace
}  // namespace plumbline
