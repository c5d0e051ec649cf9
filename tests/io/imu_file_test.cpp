#include "io/imu_file.h"

#include <gmock/gmock.h>
#include <zlib.h>

#include <numbers>

#include "io/orientation_file.h"
#include "io/temp_folder.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;
using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::HasSubstr;

class ImuFile : public testing::Test {
 protected:
  ImuRecording read(std::string_view text) {
    write_text(path_, text);
    notes_.clear();
    return read_imu(path_, &notes_);
  }
  TempFolder folder_;
  std::string path_ = folder_ / "imu.csv";
  std::vector<std::string> notes_;
};

TEST_F(ImuFile, NamedColumns) {
  const ImuRecording r = read(
      "timestamp,gyro_x,gyro_y,gyro_z,accelerometer_x,accelerometer_y,accelerometer_z,magnetometer_x,magnetometer_y,"
      "magnetometer_z\n0.5,1,2,3,4,5,6,7,8,9\n0.75,1,2,3,4,5,6,7,8,9\n");
  ASSERT_EQ(r.readings.size(), 2U);
  EXPECT_TRUE(r.has_gyroscope && r.has_magnetometer);
  EXPECT_EQ(r.readings[0].time, 500'000'000);
  EXPECT_EQ(r.readings[0].angular_rate, Vector3d(1, 2, 3));
  EXPECT_EQ(r.readings[0].specific_force, Vector3d(4, 5, 6));
  EXPECT_EQ(r.readings[1].magnetic_field, Vector3d(7, 8, 9));
  EXPECT_TRUE(is_imu_file(path_));
}

TEST_F(ImuFile, Euroc) {
  const ImuRecording r = read(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m "
      "s^-2],a_RS_S_z [m s^-2]\n1403636579758555392,-0.09,0.13,0.07,8.1,-0.3,-3.1\n");
  ASSERT_EQ(r.readings.size(), 1U);
  EXPECT_EQ(r.readings[0].time, 1403636579758555392);
  EXPECT_EQ(r.readings[0].angular_rate, Vector3d(-0.09, 0.13, 0.07));
  EXPECT_FALSE(r.has_magnetometer);
}

TEST_F(ImuFile, TumAccelerometer) {
  const ImuRecording r = read("# accelerometer data\n# timestamp ax ay az\n1305031098.38 -0.4 8.0 -4.1\n");
  EXPECT_FALSE(r.has_gyroscope);
  EXPECT_TRUE(r.kinect_axes);
  EXPECT_EQ(r.readings[0].specific_force, Vector3d(-0.4, 8.0, -4.1));
}

TEST_F(ImuFile, BroadWithItsReferenceWhereItCounts) {
  const ImuRecording r = read(
      "# BROAD, CC BY 4.0. t[s], gyr[rad/s] xyz, acc[m/s^2] xyz, mag[uT] xyz, reference quaternion w x y z (sensor to "
      "ENU), movement(0/1)\n0,1,2,3,4,5,6,7,8,9,1,0,0,0,0\n1,1,2,3,4,5,6,7,8,9,0.6,0,0,0.8,1\n"
      "2,1,2,3,4,5,6,7,8,9,nan,nan,nan,nan,1\n");
  EXPECT_EQ(r.readings.size(), 3U);
  ASSERT_EQ(r.reference.size(), 1U);
  EXPECT_EQ(r.reference[0].time, 1'000'000'000);
  EXPECT_NEAR(so3::log(r.reference[0].earth_from_body).z(), 2 * std::atan2(0.8, 0.6), 1e-9);
  EXPECT_EQ(r.readings[2].magnetic_field, Vector3d(7, 8, 9));
}

TEST_F(ImuFile, UnitsByName) {
  const ImuRecording r =
      read("t,gyr_x [deg/s],gyr_y [deg/s],gyr_z [deg/s],acc_x [g],acc_y [g],acc_z [g]\n0,180,0,0,0,0,1\n");
  EXPECT_NEAR(r.readings[0].angular_rate.x(), std::numbers::pi, 1e-12);
  EXPECT_NEAR(r.readings[0].specific_force.z(), 9.80665, 1e-12);
}

TEST_F(ImuFile, Compressed) {
  const std::string packed = folder_ / "imu.csv.gz";
  gzFile file = gzopen(packed.c_str(), "wb");
  gzputs(file, "0 1 2 3\n1 4 5 6\n");
  gzclose(file);
  EXPECT_EQ(read_imu(packed).readings[1].specific_force, Vector3d(4, 5, 6));
  std::filesystem::resize_file(packed, 20);
  EXPECT_THAT(error_of([&] { read_imu(packed); }), HasSubstr("damaged gzip"));
}

TEST_F(ImuFile, RepairsAndRefuses) {
  EXPECT_EQ(read("1 0 0 9\n0 0 0 9\n2 nan 0 9\n3 0 0").readings.size(), 2U);
  EXPECT_EQ(notes_.size(), 3U);
  EXPECT_THAT(error_of([&] { read("0 1 2 3 4\n"); }), HasSubstr("imu.csv:1"));
  EXPECT_THAT(error_of([&] { read("0 1 2 3\n1 1 2\n2 1 2 3\n"); }), HasSubstr("imu.csv:2"));
  EXPECT_THAT(error_of([&] { read("0 1 2 x\n1 1 2 3\n"); }), HasSubstr("not a number"));
  EXPECT_THAT(error_of([&] { read("# nothing\n"); }), HasSubstr("no readings"));
}

TEST_F(ImuFile, OrientationsAreNone) {
  write_text(path_, "# timestamp qx qy qz qw\n0 0 0 0 1\n");
  EXPECT_FALSE(is_imu_file(path_));
}

TEST_F(ImuFile, TiltOnlyIsKeptInTheFile) {
  const std::vector<OrientationSample> samples = {{0, so3::exp({0.1, 0.2, 0.3})}, {1'000'000, so3::exp({0.2, 0, 0})}};
  for (const bool has_heading : {true, false}) {
    write_orientations(path_, samples, has_heading);
    OrientationConvention used;
    const auto back = read_orientations(path_, {}, nullptr, &used);
    EXPECT_EQ(used.has_heading, has_heading);
    ASSERT_EQ(back.size(), 2U);
    EXPECT_TRUE(back[0].earth_from_body.isApprox(samples[0].earth_from_body, 1e-8));
  }
}

}  // namespace
}  // namespace plumbline
