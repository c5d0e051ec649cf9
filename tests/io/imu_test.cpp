#include "io/imu_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <zlib.h>

#include <cmath>
#include <numbers>

#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;
using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

ImuRecording read_from_text(std::string_view text, std::vector<std::string>* notes = nullptr) {
  const TempFolder folder;
  write_text(folder / "imu.csv", text);
  return read_imu(folder / "imu.csv", notes);
}

// Every file below says these two samples, the second 5 ms later.
constexpr Nanoseconds kFirst = 1403636579758555392, kSecond = kFirst + 5'000'000;
const Vector3d kRate(-0.1, 0.2, 0.3), kForce(8, -0.4, -5.6), kField(1, 20, -44);

void expect_samples(const ImuRecording& r, Nanoseconds first = kFirst, bool gyroscope = true,
                    bool magnetometer = false) {
  ASSERT_EQ(r.samples.size(), 2U);
  EXPECT_EQ(r.samples[0].time, first);
  EXPECT_EQ(r.samples[1].time, first + 5'000'000);
  EXPECT_EQ(r.has_gyroscope, gyroscope);
  EXPECT_EQ(r.has_magnetometer, magnetometer);
  for (const ImuSample& sample : r.samples) {
    EXPECT_TRUE(sample.angular_rate.isApprox(gyroscope ? kRate : Vector3d::Zero(), 1e-9)) << sample.angular_rate;
    EXPECT_TRUE(sample.specific_force.isApprox(kForce, 1e-9)) << sample.specific_force;
    ASSERT_EQ(sample.magnetic_field.has_value(), magnetometer);
    EXPECT_TRUE(!magnetometer || sample.magnetic_field->isApprox(kField, 1e-9));
  }
}

std::string rows(const char* first, const char* second, const std::string& rest) {
  return first + rest + "\n" + second + rest + "\n";
}

TEST(Imu, ReadsEuRoC) {
  std::vector<std::string> notes;
  const std::string body = rows("1403636579758555392", "1403636579763555392", ",-0.1,0.2,0.3,8,-0.4,-5.6");
  const std::string head =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  expect_samples(read_from_text(head + body, &notes));
  expect_samples(read_from_text(body, &notes));  // without a heading: by the number of fields and the interval
  EXPECT_THAT(notes, IsEmpty());
}

TEST(Imu, ReadsTumAccelerometer) {
  expect_samples(read_from_text("# accelerometer data\n# file: 'x.bag'\n# timestamp ax ay az\n"
                                "1305031098.382263 8 -0.4 -5.6\n1305031098.387263 8 -0.4 -5.6\n"),
                 1305031098382263000, false);
}

TEST(Imu, ReadsFmDataset) {
  // Stamp, gyroscope, accelerometer, in milliseconds; a heading, whatever its words.
  std::vector<std::string> notes;
  const std::string body = rows("60123.25", "60128.25", ",-0.1,0.2,0.3,8,-0.4,-5.6");
  expect_samples(read_from_text("timestamp,rx,ry,rz,tx,ty,tz\n" + body, &notes), 60'123'250'000);
  EXPECT_THAT(notes,
              ElementsAre(HasSubstr("(timestamp, rx, ry, rz, tx, ty, tz) were taken for a stamp, the gyroscope")));
}

TEST(Imu, ReadsWhatSimulateAndWriteImuWrite) {
  const TempFolder folder;
  ImuRecording r{.samples = {{kFirst, kRate, kForce, kField}, {kSecond, kRate, kForce, kField}},
                 .has_magnetometer = true};
  write_imu(folder / "a.csv", r);
  EXPECT_THAT(test::read_text(folder / "a.csv"), HasSubstr("timestamp,gyro_x,gyro_y,gyro_z,accelerometer_x,"
                                                           "accelerometer_y,accelerometer_z,magnetometer_x,"));
  std::vector<std::string> notes;
  expect_samples(read_imu(folder / "a.csv", &notes), kFirst, true, true);
  EXPECT_THAT(notes, IsEmpty());

  r.samples[0].magnetic_field.reset();  // three empty fields
  write_imu(folder / "b.csv", r);
  const ImuRecording b = read_imu(folder / "b.csv");
  EXPECT_FALSE(b.samples[0].magnetic_field);
  EXPECT_TRUE(b.samples[1].magnetic_field);

  r.has_gyroscope = r.has_magnetometer = false;
  write_imu(folder / "c.csv", r);
  expect_samples(read_imu(folder / "c.csv"), kFirst, false);
}

TEST(Imu, GoesByNamesAndUnits) {
  const std::string turned =
      fmt::format(",{},{},{}", kForce.x() / 9.80665, kForce.y() / 9.80665, kForce.z() / 9.80665) +
      fmt::format(",{},{},{}", kRate.x() * 180 / std::numbers::pi, kRate.y() * 180 / std::numbers::pi,
                  kRate.z() * 180 / std::numbers::pi);
  const std::string head = "time [us],acc_x [g],acc_y [g],acc_z [g],gyr_x [deg/s],gyr_y [deg/s],gyr_z [deg/s],";
  expect_samples(
      read_from_text(head + "mag_x [G],mag_y [G],mag_z [G]\n" + rows("1000000", "1005000", turned + ",0.01,0.2,-0.44")),
      1'000'000'000, true, true);
  // rostopic echo -p: the message's stamp, not the time of its arrival.
  expect_samples(
      read_from_text("%time,field.header.seq,field.header.stamp,field.angular_velocity.x,"
                     "field.angular_velocity.y,field.angular_velocity.z,field.linear_acceleration.x,"
                     "field.linear_acceleration.y,field.linear_acceleration.z\n" +
                     rows("1403636579759000000,1,1403636579758555392", "1403636579764000000,2,1403636579763555392",
                          ",-0.1,0.2,0.3,8,-0.4,-5.6")));
}

TEST(Imu, FindsTheUnitOfTheStamps) {
  const std::string rest = ",-0.1,0.2,0.3,8,-0.4,-5.6";
  expect_samples(read_from_text(rows("12.5", "12.505", rest)), 12'500'000'000);
  expect_samples(read_from_text(rows("12500", "12505", rest)), 12'500'000'000);
  expect_samples(read_from_text(rows("12500000", "12505000", rest)), 12'500'000'000);
  expect_samples(read_from_text(rows("12500000000", "12505000000", rest)), 12'500'000'000);
  expect_samples(read_from_text(rows("0.25", "5.25", rest)), 250'000);
}

TEST(Imu, TellsOfWhatItLeavesOut) {
  std::vector<std::string> notes;
  const ImuRecording r = read_from_text(
      "timestamp,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z,mag_x,mag_y,mag_z\n"
      "3,0,0,0,0,0,9.8,nan,nan,nan\n2.99,0,0,0,0,0,9.8,1,2,3\n2.99,0,0,0,0,0,1,,,\n2.98,nan,0,0,0,0,9.8,1,2,3\n"
      "3.01,0,0,0,0,0,9.8,1,2,3\n3.02,0,0,0,0,0",
      &notes);
  ASSERT_EQ(r.samples.size(), 3U);
  EXPECT_EQ(r.samples[0].specific_force.z(), 9.8);
  EXPECT_TRUE(r.samples[0].magnetic_field);
  EXPECT_FALSE(r.samples[1].magnetic_field);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("half-written"), HasSubstr("1 of 6 samples are not finite"),
                                 HasSubstr("not in order"), HasSubstr("1 samples with the stamp of an earlier")));
}

TEST(Imu, FindsTheForcesUnit) {
  const auto force = [](const std::string& z, std::vector<std::string>* notes, const char* head = "") {
    return read_from_text(head + rows("0", "0.01", ",0,0," + z), notes).samples[0].specific_force.z();
  };
  for (const auto& [counts, words] :
       {std::pair("1.01", "taken for g"), {"998", "taken for mg"}, {"16300", "16384 a g"}}) {
    std::vector<std::string> notes;
    EXPECT_NEAR(force(counts, &notes), 9.8, 0.15);
    EXPECT_THAT(notes, ElementsAre(HasSubstr(words)));
  }
  std::vector<std::string> notes;
  EXPECT_THAT(error_of([&] { force("0.1", &notes); }), HasSubstr("no accelerometer's gravity"));
  EXPECT_NEAR(force("0.1", &notes, "t,acc_x,acc_y,acc_z\n"), 0.1, 1e-9);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("gravity seems to be taken out")));
}

TEST(Imu, FindsDegreesASecond) {
  // A turn about x, with the gravity that such a turn shows.
  const auto turning = [](double rate, double factor, const char* head = "") {
    std::string text = head;
    for (int i = 0; i < 1000; ++i) {
      const double t = 0.01 * i, angle = rate * t;
      text += fmt::format("{},{},0,0,0,{},{}\n", t, factor * rate, 9.81 * std::sin(angle), 9.81 * std::cos(angle));
    }
    return text;
  };
  const auto rate_of = [](const std::string& text, std::vector<std::string>* notes) {
    return read_from_text(text, notes).samples[9].angular_rate.x();
  };
  for (const double rate : {radians(40), radians(9)}) {  // told by size, and by gravity alone
    std::vector<std::string> notes;
    EXPECT_NEAR(rate_of(turning(rate, degrees(1), "t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n"), &notes), rate, 1e-6);
    EXPECT_THAT(notes, ElementsAre(HasSubstr("deg/s")));
  }
  std::vector<std::string> notes;
  EXPECT_NEAR(rate_of(turning(0.7, 1), &notes), 0.7, 1e-6);
  EXPECT_THAT(notes, IsEmpty());
  rate_of(turning(0.7, -1), &notes);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("contradict each other")));
  notes.clear();  // the heading is believed, and doubted
  EXPECT_NEAR(rate_of(turning(0.7, 1, "t,gyro_x_dps,gyro_y_dps,gyro_z_dps,ax,ay,az\n"), &notes), radians(0.7), 1e-9);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("check its unit")));
}

TEST(Imu, ReadsStrayScanner) {
  std::vector<std::string> notes;
  const TempFolder folder;
  write_text(folder / "imu.csv", "timestamp, a_x, a_y, a_z, alpha_x, alpha_y, alpha_z\n" +
                                     rows("51234.5", "51234.51", ", -0.02, -0.71, -0.70, 0.01, 0.2, -0.03"));
  const ImuRecording r = read_imu(folder / "imu.csv", &notes);
  EXPECT_TRUE(r.has_gyroscope);
  EXPECT_NEAR(r.samples[0].angular_rate.y(), 0.2, 1e-12);
  EXPECT_NEAR(r.samples[0].specific_force.y(), 0.71 * 9.80665, 1e-9);  // up
  EXPECT_THAT(notes, ElementsAre(HasSubstr("StrayScanner")));
  const auto mounting = mounting_by_format(folder / "imu.csv");
  ASSERT_TRUE(mounting);
  EXPECT_TRUE((*mounting * Vector3d(1, 2, 3)).isApprox(Vector3d(-2, -1, -3)));
}

TEST(Imu, KnowsGravityFromATurnRate) {
  std::vector<std::string> notes;
  const std::string exchanged = rows("0", "0.01", ",0.1,-9.7,0.3,0.6,0.2,0.1");
  for (const std::string head : {"", "t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n"}) {
    notes.clear();
    const ImuRecording r = read_from_text(head + exchanged, &notes);
    EXPECT_NEAR(r.samples[0].specific_force.y(), -9.7, 1e-12);
    EXPECT_NEAR(r.samples[0].angular_rate.x(), 0.6, 1e-12);
    EXPECT_THAT(notes, ElementsAre(HasSubstr("which is gravity")));
  }
}

/// A turn about x at 0.7 rad/s, and the gravity that it shows, at these moments.
Vector3d turning_force(double t) { return {0, 9.81 * std::sin(0.7 * t), 9.81 * std::cos(0.7 * t)}; }

void expect_turn(const ImuRecording& r, std::size_t samples) {
  ASSERT_EQ(r.samples.size(), samples);
  EXPECT_TRUE(r.has_gyroscope);
  for (const ImuSample& sample : r.samples) {
    EXPECT_NEAR(sample.angular_rate.x(), 0.7, 1e-9);
    EXPECT_LT((sample.specific_force - turning_force(to_seconds(sample.time))).norm(), 1e-3) << "of that moment";
  }
}

TEST(Imu, JoinsRowsThatNameTheirSensor) {
  for (const char* form : {"{0:.3f},{1},{2},{3},{4}\n", "{1} {0:.3f} {2} {3} {4} 3\n"}) {
    std::string text;
    for (int i = 0; i < 200; ++i) {
      const double t = 0.005 * i;
      const Vector3d f = turning_force(t);
      text += i % 2 == 0 ? fmt::format(fmt::runtime(form), t, "GYRO", 0.7, 0, 0)
                         : fmt::format(fmt::runtime(form), t, "ACC", f.x(), f.y(), f.z());
      if (i % 10 == 0) text += fmt::format(fmt::runtime(form), t, "MAG", 20, 0, -40);
    }
    std::vector<std::string> notes;
    const TempFolder folder;
    write_text(folder / "imu.csv", text);
    EXPECT_TRUE(is_imu_file(folder / "imu.csv"));
    expect_turn(read_imu(folder / "imu.csv", &notes), 99);  // the first turn has no force before it
    EXPECT_THAT(notes, ElementsAre(AllOf(HasSubstr("100 of the gyroscope and 100 of the accelerometer were joined"),
                                         HasSubstr("20 rows of other sensors are not used"))));
  }
}

TEST(Imu, JoinsRowsOfAndroidsNumbers) {
  std::string text = "timestamp [ns],sensor,x,y,z\n";
  for (int i = 0; i < 100; ++i) {
    const Vector3d f = turning_force(0.01 * i);
    text += fmt::format("{},1,{},{},{}\n{},4,0.7,0,0\n", 10'000'000 * i, f.x(), f.y(), f.z(), 10'000'000 * i);
  }
  std::vector<std::string> notes;
  expect_turn(read_from_text(text, &notes), 100);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("Android's")));
}

TEST(Imu, JoinsRowsWithEmptyCells) {
  std::string text = "timestamp,gyro_x,gyro_y,gyro_z,acc_x_g,acc_y_g,acc_z_g,mag_x,mag_y,mag_z\n";
  for (int i = 0; i < 200; ++i) {
    const Vector3d f = turning_force(0.005 * i) / 9.80665;
    text += i % 2 == 1 ? fmt::format("{},0.7,0,0,,,,,,\n", 0.005 * i)
                       : fmt::format("{},,,,{},{},{},,,\n", 0.005 * i, f.x(), f.y(), f.z());
  }
  std::vector<std::string> notes;
  expect_turn(read_from_text(text, &notes), 99);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("100 and 100 rows were joined")));
}

TEST(Imu, FindsCountsOfTurnRatesByGravity) {
  std::string text = "t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n";
  for (int i = 0; i < 1000; ++i) {
    const Vector3d f = turning_force(0.01 * i) / 9.81 * 16384;
    text += fmt::format("{},{:.0f},0,0,{:.0f},{:.0f},{:.0f}\n", 0.01 * i, degrees(0.7) * 131, f.x(), f.y(), f.z());
  }
  std::vector<std::string> notes;
  EXPECT_NEAR(read_from_text(text, &notes).samples[9].angular_rate.x(), 0.7, 1e-3);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("16384 a g"), HasSubstr("131 a deg/s")));
}

TEST(Imu, RefusesWhatIsNoImuFile) {
  EXPECT_THAT(error_of([] { read_from_text(""); }), HasSubstr("no readings"));
  EXPECT_THAT(error_of([] { read_from_text("timestamp,gyro_x\n"); }), HasSubstr("no readings"));
  EXPECT_THAT(error_of([] { read_from_text("1 2 3\n2 2 3\n"); }), HasSubstr("imu.csv:1: has 3 fields"));
  EXPECT_THAT(error_of([] { read_from_text("1,0,0,0,0,0,9.8\n1.01,0,0,x,0,0,9.8\n1.02,0,0,0,0,0,9.8\n"); }),
              AllOf(HasSubstr("imu.csv:2: 'x' is not a number"), HasSubstr("timestamp,gyro_x")));
  EXPECT_THAT(error_of([] { read_from_text("1,0,0,0,0,0,9.8\n1.01,0,0,0,0,0\n1.02,0,0,0,0,0,9.8\n"); }),
              HasSubstr("imu.csv:2: has 6 fields where the lines before have 7"));
  EXPECT_THAT(error_of([] { read_from_text("1,0,0,0,0,0,9.8\n1.01s,0,0,0,0,0,9\n1.02,0,0,0,0,0,9.8\n"); }),
              HasSubstr("'1.01s' is not a time"));
  EXPECT_THAT(error_of([] { read_from_text("t,mag_x,mag_y,mag_z\n1,0,0,0\n"); }),
              HasSubstr("neither a gyroscope nor an accelerometer"));
  EXPECT_THAT(error_of([] { read_from_text("t,acc_x [mm/h],acc_y [mm/h],acc_z [mm/h]\n1,0,0,0\n"); }),
              HasSubstr("the unit [mm/h] of the accelerometer is not known"));
  EXPECT_THAT(error_of([] { read_from_text("t [h],acc_x,acc_y,acc_z\n1,0,0,0\n"); }),
              HasSubstr("unit [h] of the stamps"));
  EXPECT_THAT(error_of([] { read_from_text("0,nan,0,0\n1,nan,0,0\n2,0,0,9.8\n"); }), HasSubstr("2 of 3 samples"));
}

TEST(Imu, KeepsBroadsReferenceWhereItCounts) {
  const ImuRecording r = read_from_text(
      "# BROAD, CC BY 4.0. t[s], gyr[rad/s] xyz, acc[m/s^2] xyz, mag[uT] xyz, reference quaternion w x y z (sensor to "
      "ENU), movement(0/1)\n0,1,2,3,4,5,6,7,8,9,1,0,0,0,0\n0.01,1,2,3,4,5,6,7,8,9,0.6,0,0,0.8,1\n"
      "0.02,1,2,3,4,5,6,7,8,9,nan,nan,nan,nan,1\n");
  EXPECT_EQ(r.samples.size(), 3U);
  ASSERT_EQ(r.reference.size(), 1U);
  EXPECT_EQ(r.reference[0].time, 10'000'000);
  EXPECT_NEAR(so3::log(r.reference[0].earth_from_body).z(), 2 * std::atan2(0.8, 0.6), 1e-9);
}

TEST(Imu, KnowsItsFilesFromOrientations) {
  const TempFolder folder;
  const auto is_imu = [&](std::string_view text) {
    write_text(folder / "a.txt", text);
    return is_imu_file(folder / "a.txt");
  };
  EXPECT_TRUE(is_imu("# timestamp ax ay az\n0 0 0 9.8\n"));
  EXPECT_TRUE(is_imu("t,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z\n0,0,0,0,0,0,9.8\n"));
  EXPECT_TRUE(is_imu("t,gyro_x,gyro_y,gyro_z\n0,0,0,0\n"));
  EXPECT_TRUE(is_imu("0 0 0 9.8\n"));  // four, seven or ten numbers, where an orientation has five or eight
  EXPECT_FALSE(is_imu("# timestamp qx qy qz qw\n0 0 0 0 1\n"));
  EXPECT_FALSE(is_imu("t,qx,qy,qz,qw,acc_x,acc_y,acc_z\n0,0,0,0,1,0,0,9.8\n"));  // a chip's own fusion
  EXPECT_FALSE(is_imu("0 0 0 0 1\n"));
  EXPECT_FALSE(is_imu(""));
}

/// A gyroscope alone, in the spellings of apps and chips: every file says 0.1, 0.2, −0.3 rad/s about x, y, z.
TEST(Imu, ReadsAGyroscopeAlone) {
  const struct {
    const char *name, *text;
  } files[] = {
      {"gyro.csv", "timestamp,gyro_x,gyro_y,gyro_z\n1.00,0.1,0.2,-0.3\n1.01,0.1,0.2,-0.3\n"},
      {"phyphox.csv",
       "\"Time (s)\",\"Gyroscope x (rad/s)\",\"Gyroscope y (rad/s)\",\"Gyroscope z (rad/s)\",\"Absolute (rad/s)\"\n"
       "1.00,0.1,0.2,-0.3,0.37\n1.01,0.1,0.2,-0.3,0.37\n"},
      {"euroc.csv",
       "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1]\n"
       "1000000000,0.1,0.2,-0.3\n1010000000,0.1,0.2,-0.3\n"},
      {"dps.csv", "time_ms,wx_dps,wy_dps,wz_dps\n1000,5.72958,11.45916,-17.18873\n1010,5.72958,11.45916,-17.18873\n"},
      {"ros.csv",
       "%time,field.angular_velocity.x,field.angular_velocity.y,field.angular_velocity.z\n"
       "1.00,0.1,0.2,-0.3\n1.01,0.1,0.2,-0.3\n"},
      {"Gyroscope.csv", "time,seconds_elapsed,z,y,x\n1000000000,1.0,-0.3,0.2,0.1\n1010000000,1.01,-0.3,0.2,0.1\n"},
      {"rows.csv", "1.00,gyro,0.1,0.2,-0.3\n1.01,gyro,0.1,0.2,-0.3\n"},
      {"blanks.txt", "# timestamp wx wy wz\n1.00 0.1 0.2 -0.3\n1.01 0.1 0.2 -0.3\n"},
  };
  const TempFolder folder;
  for (const auto& [name, text] : files) {
    write_text(folder / name, text);
    EXPECT_TRUE(is_imu_file(folder / name)) << name;
    const ImuRecording r = read_imu(folder / name);
    EXPECT_TRUE(r.has_gyroscope) << name;
    EXPECT_FALSE(r.has_accelerometer) << name;
    ASSERT_EQ(r.samples.size(), 2U) << name;
    EXPECT_EQ(r.samples[1].time, 1'010'000'000) << name;
    EXPECT_TRUE(r.samples[0].angular_rate.isApprox(Vector3d(0.1, 0.2, -0.3), 1e-5)) << name;
    EXPECT_TRUE(r.samples[0].specific_force.isZero(0)) << name;
  }
}

TEST(Imu, TakesThreeNamelessColumnsThatMoveForAGyroscope) {
  std::string text;
  for (int i = 0; i < 200; ++i)
    text += fmt::format("{},{},{},0.01\n", 0.01 * i, std::sin(0.1 * i), 0.3 * std::cos(0.07 * i));
  std::vector<std::string> notes;
  const ImuRecording r = read_from_text(text, &notes);
  EXPECT_TRUE(r.has_gyroscope);
  EXPECT_FALSE(r.has_accelerometer);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("taken for a gyroscope, a guess")));
}

TEST(Imu, WritesWhatASensorHas) {
  const TempFolder folder;
  ImuRecording r;
  r.has_accelerometer = false;
  r.samples.emplace_back().time = 1'000'000'000;
  r.samples.front().angular_rate = Vector3d(1, 2, 3);
  write_imu(folder / "gyro.csv", r);
  const ImuRecording read = read_imu(folder / "gyro.csv");
  EXPECT_FALSE(read.has_accelerometer);
  EXPECT_EQ(read.samples[0].angular_rate, Vector3d(1, 2, 3));
}

TEST(Imu, UnpacksGzip) {
  const TempFolder folder;
  const std::string text = "0 0 0 9.8\n0.01 0 0 9.8\n";
  const std::string path = folder / "a.gz";
  for (const char* mode : {"wb", "ab"}) {  // two members
    const gzFile file = gzopen(path.c_str(), mode);
    ASSERT_NE(file, nullptr);
    ASSERT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())), static_cast<int>(text.size()));
    ASSERT_EQ(gzclose(file), Z_OK);
  }
  std::vector<std::string> notes;
  EXPECT_EQ(read_imu(path, &notes).samples.size(), 2U);
  EXPECT_THAT(notes, Contains(HasSubstr("2 samples with the stamp")));
  std::string bytes = test::read_text(path);
  write_text(folder / "short.gz", bytes.substr(0, bytes.size() - 5));
  EXPECT_THAT(error_of([&] { read_imu(folder / "short.gz"); }), HasSubstr("ends early"));
  bytes[12] = static_cast<char>(~bytes[12]);
  write_text(folder / "bad.gz", bytes);
  EXPECT_THAT(error_of([&] { read_imu(folder / "bad.gz"); }), AnyOf(HasSubstr("is damaged"), HasSubstr("ends early")));
}

TEST(Imu, ReadsBroadTrials) {
  PLUMBLINE_DATA_OR_SKIP(folder, "imu/broad");
  std::vector<std::string> notes;
  const ImuRecording r = read_imu((folder / "03_undisturbed_slow_rotation_C.csv.gz").string(), &notes);
  EXPECT_THAT(notes, IsEmpty());
  EXPECT_TRUE(r.has_gyroscope && r.has_magnetometer);
  ASSERT_EQ(r.samples.size(), 58412U);
  // The first line, as it stands in the file.
  EXPECT_EQ(r.samples[0].time, 0);
  EXPECT_EQ(r.samples[0].angular_rate, Vector3d(0.0074578, -0.0042603, -0.0074578));
  EXPECT_EQ(r.samples[0].specific_force, Vector3d(0.019462, -0.097036, 9.7857));
  EXPECT_EQ(r.samples[0].magnetic_field, Vector3d(0.9771, 16.904, -41.017));
}

TEST(Imu, ReadsTumRecordings) {
  PLUMBLINE_DATA_OR_SKIP(folder, "tum/rgbd_dataset_freiburg1_xyz");
  std::vector<std::string> notes;
  const ImuRecording r = read_imu((folder / "accelerometer.txt").string(), &notes);
  EXPECT_FALSE(r.has_gyroscope);
  EXPECT_FALSE(r.has_magnetometer);
  EXPECT_TRUE(r.kinect_axes);
  EXPECT_EQ(r.samples[0].time, 1305031098382263000);
  EXPECT_EQ(r.samples[0].specific_force, Vector3d(-0.478957, 8.010560, -4.166928));
  EXPECT_GT(r.samples.size(), 10000U);
}

}  // namespace
}  // namespace plumbline
