#include "calibration/convention_check.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "io/trajectory.h"
#include "plumbline/angles.h"
#include "plumbline/files.h"
#include "plumbline/orientation.h"
#include "plumbline/orientation_stream.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sensor/error_model.h"
#include "support/data.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;

Vector3d random_vector(Random& random, double size) {
  return size * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
}

/// A hand-held walk: earth_from_camera of 200 frames, a few degrees from one to the next, about the axes given (1 = all
/// three), looking horizontally to begin with.
std::vector<Matrix3d> walk(std::uint64_t seed, const Vector3d& axes = Vector3d::Ones()) {
  Random random(seed);
  std::vector<Matrix3d> cameras = {so3::exp(Vector3d(0, 0, random.uniform(-3, 3))) *
                                   so3::exp(Vector3d(-std::numbers::pi / 2, 0, 0))};
  for (int i = 1; i < 200; ++i)
    cameras.push_back(cameras.back() * so3::exp(axes.cwiseProduct(random_vector(random, 6 * kRadiansPerDegree))));
  return cameras;
}

/// What the tracker says of frames five apart, erring by 0.2°, beside what the stream says.
std::vector<TurnPair> pairs_of(const std::vector<Matrix3d>& cameras, const std::vector<Matrix3d>& stream) {
  Random random(17);
  std::vector<TurnPair> pairs;
  for (std::size_t i = 0; i + 5 < cameras.size(); i += 5)
    pairs.push_back({cameras[i].transpose() * cameras[i + 5] * so3::exp(random_vector(random, 0.2 * kRadiansPerDegree)),
                     stream[i], stream[i + 5]});
  return pairs;
}

/// The stream of a sensor that writes with `written` and is read with `declared`.
std::vector<Matrix3d> stream_of(const std::vector<Matrix3d>& cameras, const Matrix3d& body_from_camera,
                                const OrientationConvention& written, const OrientationConvention& declared) {
  std::vector<Matrix3d> stream;
  for (const Matrix3d& camera : cameras)
    stream.push_back(decode_orientation(encode_orientation(camera * body_from_camera.transpose(), written), declared));
  return stream;
}

std::vector<Matrix3d> erring(const std::vector<Matrix3d>& exact, std::uint64_t seed) {
  std::vector<OrientationSample> samples;
  for (std::size_t i = 0; i < exact.size(); ++i) samples.push_back({static_cast<Nanoseconds>(i), exact[i]});
  OrientationErrorModel model = error_model("bno055");
  model.seed = seed;
  std::vector<Matrix3d> out;
  for (const OrientationSample& sample : with_error(model, samples)) out.push_back(sample.earth_from_body);
  return out;
}

constexpr QuaternionOrder kXyzw = QuaternionOrder::xyzw, kWxyz = QuaternionOrder::wxyz;
constexpr OrientationOf kToWorld = OrientationOf::body_to_world, kToBody = OrientationOf::world_to_body;
const Matrix3d kMounting = so3::exp(Vector3d(0.9, -0.4, 1.2));

TEST(ConventionCheck, NamesEveryWrongConvention) {
  for (const EarthAxes earth : {EarthAxes::enu, EarthAxes::ned, EarthAxes::y_up})
    for (int written = 0; written < 4; ++written)
      for (int declared = 0; declared < 4; ++declared) {
        const auto make = [&](int bits) {
          return OrientationConvention{(bits & 1) != 0 ? kWxyz : kXyzw, (bits & 2) != 0 ? kToBody : kToWorld, earth};
        };
        const auto cameras = walk(static_cast<std::uint64_t>(1 + written));
        const auto stream = stream_of(cameras, kMounting, make(written), make(declared));
        const ConventionCheck check = check_convention(pairs_of(cameras, stream), make(declared), kMounting);
        ASSERT_TRUE(check.two_axes);
        ASSERT_EQ(check.fits.size(), 8u);
        const bool right = written == declared;
        EXPECT_EQ(check.verdict, right ? ConventionVerdict::fits : ConventionVerdict::another_fits) << check.message;
        const ConventionFit& best = check.fits[check.best];
        EXPECT_FALSE(best.mounting_fitted) << check.message;
        EXPECT_EQ(best.convention.quaternion, make(written).quaternion) << check.message;
        EXPECT_EQ(best.convention.orientation_of, make(written).orientation_of) << check.message;
        EXPECT_LT(best.residual, 0.3 * kRadiansPerDegree);
        const bool order = ((written ^ declared) & 1) != 0, inverse = ((written ^ declared) & 2) != 0;
        EXPECT_EQ(check.message.find("--quaternion") != std::string::npos, order) << check.message;
        EXPECT_EQ(check.message.find("--orientation-of") != std::string::npos, inverse) << check.message;
        EXPECT_EQ(check.message.find("--mounting"), std::string::npos) << check.message;
      }
}

TEST(ConventionCheck, SaysWhichOptionToGive) {
  const auto cameras = walk(3);
  const OrientationConvention declared{kXyzw, kToWorld, EarthAxes::enu};
  const auto inverse = stream_of(cameras, Matrix3d::Identity(), {kXyzw, kToBody, EarthAxes::enu}, declared);
  EXPECT_THAT(
      check_convention(pairs_of(cameras, inverse), declared, Matrix3d::Identity()).message,
      testing::ContainsRegex("fits with --orientation-of world-to-body: 0\\.[0-9]° instead of [1-9][0-9]*\\.[0-9]° "
                             "as declared"));
  const auto order = stream_of(cameras, Matrix3d::Identity(), {kWxyz, kToWorld, EarthAxes::enu}, declared);
  EXPECT_THAT(check_convention(pairs_of(cameras, order), declared, Matrix3d::Identity()).message,
              HasSubstr("fits with --quaternion wxyz: "));
  // Without a declared order the format's is xyzw.
  EXPECT_THAT(check_convention(pairs_of(cameras, order), {}, Matrix3d::Identity()).message,
              HasSubstr("fits with --quaternion wxyz: "));
}

TEST(ConventionCheck, FindsTheMounting) {
  for (const double wrong : {20 * kRadiansPerDegree, 90 * kRadiansPerDegree, 170 * kRadiansPerDegree}) {
    const auto cameras = walk(4);
    const Matrix3d body_from_camera = so3::exp(wrong * Vector3d(0.6, 0, 0.8)) * kMounting;
    const auto stream = stream_of(cameras, body_from_camera, {}, {});
    const ConventionCheck check = check_convention(pairs_of(cameras, stream), {}, kMounting);
    ASSERT_EQ(check.verdict, ConventionVerdict::another_fits) << check.message;
    EXPECT_EQ(check.best, 4u);
    EXPECT_LT(so3::angle(check.fits[4].body_from_camera.transpose() * body_from_camera), 0.5 * kRadiansPerDegree);
    EXPECT_THAT(check.message, HasSubstr("fits with --mounting \""));
    // The inverse in the other order is the same but for the earth's axes: see the header.
    EXPECT_NEAR(check.fits[7].residual, check.fits[4].residual, 1e-9);
    EXPECT_NEAR(check.fits[6].residual, check.fits[5].residual, 1e-9);
  }
}

TEST(ConventionCheck, FindsMountingAndInverseTogether) {
  const auto cameras = walk(5);
  const auto stream = stream_of(cameras, kMounting, {kXyzw, kToBody, EarthAxes::enu}, {});
  const ConventionCheck check = check_convention(pairs_of(cameras, stream), {}, Matrix3d::Identity());
  ASSERT_EQ(check.verdict, ConventionVerdict::another_fits) << check.message;
  EXPECT_THAT(check.message, HasSubstr("--orientation-of world-to-body --mounting \""));
  EXPECT_LT(so3::angle(check.fits[check.best].body_from_camera.transpose() * kMounting), 0.5 * kRadiansPerDegree);
}

TEST(ConventionCheck, LetsTheErrorModelPass) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed)
    for (const Vector3d& axes :
         {Vector3d(1, 1, 1), Vector3d(0.1, 1, 0.1), Vector3d(1, 0.3, 0.1), Vector3d(0.5, 1, 0.5), Vector3d(0, 1, 0)}) {
      const auto cameras = walk(100 + seed, axes);
      const auto stream = erring(stream_of(cameras, kMounting, {}, {}), seed);
      const ConventionCheck check = check_convention(pairs_of(cameras, stream), {}, kMounting);
      EXPECT_EQ(check.verdict, ConventionVerdict::fits) << seed << ": " << axes.transpose() << ": " << check.message;
    }
}

TEST(ConventionCheck, NamesAWrongConventionOfAnErringSensor) {
  const OrientationConvention written{kXyzw, kToBody, EarthAxes::enu};
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto cameras = walk(200 + seed);
    const auto exact = stream_of(cameras, kMounting, {}, {});
    std::vector<Matrix3d> stream;
    for (const Matrix3d& body : erring(exact, seed))
      stream.push_back(decode_orientation(encode_orientation(body, written), {}));
    const ConventionCheck check = check_convention(pairs_of(cameras, stream), {}, kMounting);
    EXPECT_EQ(check.verdict, ConventionVerdict::another_fits) << check.message;
    EXPECT_EQ(check.best, 1u) << check.message;
  }
}

TEST(ConventionCheck, AConstantStreamFitsNothing) {
  const auto cameras = walk(6);
  const std::vector<Matrix3d> stream(cameras.size(), kMounting);
  const ConventionCheck check = check_convention(pairs_of(cameras, stream), {}, Matrix3d::Identity());
  EXPECT_EQ(check.verdict, ConventionVerdict::none_fits) << check.message;
  EXPECT_THAT(check.message, HasSubstr("stands still (0.0° rms)"));
}

TEST(ConventionCheck, AStreamOfAnotherMotionFitsNothing) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto cameras = walk(seed);
    const ConventionCheck check = check_convention(pairs_of(cameras, walk(seed + 1000)), {}, Matrix3d::Identity());
    EXPECT_EQ(check.verdict, ConventionVerdict::none_fits) << check.message;
    EXPECT_FALSE(check.mirrored_fits);
    EXPECT_THAT(check.message, HasSubstr("check that the file belongs to this sequence"));
  }
}

TEST(ConventionCheck, SwappedAxesOfTheBodyAreAMounting) {
  // Body axes x y z given out as y z x.
  Matrix3d swapped;
  swapped << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  const auto cameras = walk(7);
  const ConventionCheck check =
      check_convention(pairs_of(cameras, stream_of(cameras, swapped, {}, {})), {}, Matrix3d::Identity());
  ASSERT_EQ(check.verdict, ConventionVerdict::another_fits) << check.message;
  EXPECT_THAT(check.message, HasSubstr("fits with --mounting \""));
  EXPECT_LT(so3::angle(check.fits[check.best].body_from_camera.transpose() * swapped), 0.5 * kRadiansPerDegree);
}

TEST(ConventionCheck, SwappedColumnsAreAnInverse) {
  // With x and y of the quaternion exchanged, R is S Rᵀ S, S the (improper) exchange of two axes: the inverse of a body
  // mounted by the rotation −S.
  const auto cameras = walk(8);
  std::vector<Matrix3d> stream;
  for (const Matrix3d& camera : cameras) {
    const Eigen::Quaterniond q(camera);
    stream.push_back(Eigen::Quaterniond(q.w(), q.y(), q.x(), q.z()).toRotationMatrix());
  }
  const ConventionCheck check = check_convention(pairs_of(cameras, stream), {}, Matrix3d::Identity());
  ASSERT_EQ(check.verdict, ConventionVerdict::another_fits) << check.message;
  EXPECT_THAT(check.message, HasSubstr("--orientation-of world-to-body --mounting"));
  Matrix3d minus_s;
  minus_s << 0, -1, 0, -1, 0, 0, 0, 0, -1;
  EXPECT_LT(so3::angle(check.fits[check.best].body_from_camera.transpose() * minus_s), 0.5 * kRadiansPerDegree);
}

TEST(ConventionCheck, SaysMirroredWhereOnlyAReflectionFits) {
  // The turns of a body whose axes are left-handed.
  const Matrix3d mirror = Vector3d(1, 1, -1).asDiagonal();
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto cameras = walk(seed);
    std::vector<TurnPair> pairs = pairs_of(cameras, cameras);
    for (TurnPair& pair : pairs) {
      const Vector3d turn = so3::log(pair.earth_from_body_first.transpose() * pair.earth_from_body_second);
      pair.earth_from_body_second = pair.earth_from_body_first * so3::exp(mirror * turn);
    }
    const ConventionCheck check = check_convention(pairs, {}, Matrix3d::Identity());
    EXPECT_EQ(check.verdict, ConventionVerdict::none_fits) << check.message;
    EXPECT_TRUE(check.mirrored_fits) << check.message;
    EXPECT_THAT(check.message, HasSubstr("mirrored"));
  }
}

TEST(ConventionCheck, OneAxisGivesNoMounting) {
  const auto cameras = walk(10, Vector3d(0, 1, 0));
  const auto stream = stream_of(cameras, kMounting, {}, {});
  const ConventionCheck right = check_convention(pairs_of(cameras, stream), {}, kMounting);
  EXPECT_FALSE(right.two_axes);
  EXPECT_EQ(right.fits.size(), 4u);
  EXPECT_EQ(right.verdict, ConventionVerdict::fits) << right.message;
  const ConventionCheck wrong = check_convention(
      pairs_of(cameras, stream_of(cameras, so3::exp(Vector3d(1.5, 0, 0)), {}, {})), {}, Matrix3d::Identity());
  EXPECT_EQ(wrong.verdict, ConventionVerdict::none_fits) << wrong.message;
  EXPECT_THAT(wrong.message, HasSubstr("about one axis only"));
}

TEST(ConventionCheck, SaysNothingOfACameraThatHardlyTurns) {
  const std::vector<Matrix3d> still(200, Matrix3d::Identity());
  const ConventionCheck check = check_convention(pairs_of(still, walk(11)), {}, Matrix3d::Identity());
  EXPECT_EQ(check.verdict, ConventionVerdict::too_little_motion);
  const auto cameras = walk(12);
  auto few = pairs_of(cameras, cameras);
  few.resize(9);
  EXPECT_EQ(check_convention(few, {}, Matrix3d::Identity()).verdict, ConventionVerdict::too_little_motion);
  EXPECT_EQ(check_convention({}, {}, Matrix3d::Identity()).verdict, ConventionVerdict::too_little_motion);
}

/// The published motion capture of a hand-held camera, as camera and as sensor.
TEST(ConventionCheck, OnARealMotion) {
  PLUMBLINE_DATA_OR_SKIP(file, "tum/rgbd_dataset_freiburg1_xyz/groundtruth.txt");
  const Trajectory truth = read_trajectory(file.string());
  const OrientationConvention inverse{kXyzw, kToBody, EarthAxes::enu}, order{kWxyz, kToWorld, EarthAxes::enu};
  for (const OrientationConvention& declared : {OrientationConvention{}, inverse, order}) {
    OrientationStreamOptions options;
    const auto samples = read_orientations(file.string(), declared, nullptr, &options.convention);
    const OrientationStream stream(samples, options);
    std::vector<TurnPair> pairs;
    for (std::size_t i = 0; i + 50 < truth.size(); i += 50) {  // half a second
      const StampedPose &a = truth[i], &b = truth[i + 50];
      const OrientationReading first = stream.lookup(a.time), second = stream.lookup(b.time);
      ASSERT_EQ(first.status, OrientationStatus::ok);
      ASSERT_EQ(second.status, OrientationStatus::ok);
      pairs.push_back({a.world_from_camera.rotation().transpose() * b.world_from_camera.rotation(),
                       first.earth_from_body, second.earth_from_body});
    }
    const ConventionCheck check = check_convention(pairs, options.convention, options.body_from_camera);
    const bool right = declared.quaternion.value_or(kXyzw) == kXyzw && declared.orientation_of == kToWorld;
    EXPECT_EQ(check.verdict, right ? ConventionVerdict::fits : ConventionVerdict::another_fits) << check.message;
    EXPECT_EQ(check.fits[check.best].convention.quaternion, kXyzw) << check.message;
    EXPECT_EQ(check.fits[check.best].convention.orientation_of, kToWorld) << check.message;
    EXPECT_FALSE(check.fits[check.best].mounting_fitted) << check.message;
    EXPECT_LT(check.fits[check.best].residual, 0.01 * kRadiansPerDegree);
  }
}

}  // namespace
}  // namespace plumbline
