#include "plumbline/files.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "io/trajectory.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<OrientationSample> read_from_text(std::string_view text, const OrientationConvention& convention = {},
                                              std::vector<std::string>* notes = nullptr,
                                              OrientationConvention* used = nullptr) {
  const TempFolder folder;
  write_text(folder / "o.txt", text);
  return read_orientations(folder / "o.txt", convention, notes, used);
}

// Every file below says this one: 2·atan2(0.6, 0.8) about x.
const Matrix3d kTurn = so3::exp(Vector3d(2 * std::atan2(0.6, 0.8), 0, 0));

void expect_turn(const std::vector<OrientationSample>& samples, std::size_t count = 1) {
  ASSERT_EQ(samples.size(), count);
  EXPECT_TRUE(samples.front().earth_from_body.isApprox(kTurn, 1e-12)) << samples.front().earth_from_body;
}

TEST(Orientations, ReadsFiveColumns) {
  std::vector<std::string> notes;
  OrientationConvention used;
  const auto s = read_from_text(
      "\xEF\xBB\xBF# earth_from_body, earth axes east north up\r\n# timestamp qx qy qz qw\r\n"
      "1305031102.160407123 0.6 0 0 0.8\r\n1305031103,0,0,1,0\r\n 1305031104\t0 , 0 ,0 1",
      {}, &notes, &used);
  expect_turn(s, 3);
  EXPECT_EQ(s[0].time, 1305031102160407123);
  EXPECT_TRUE(s[1].earth_from_body.isApprox(Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix(), 1e-12));
  EXPECT_THAT(notes, IsEmpty());
  EXPECT_EQ(used.quaternion, QuaternionOrder::xyzw);
  expect_turn(read_from_text("12 0.6 0 0 0.8\n"));
  expect_turn(read_from_text("12 0.8 0.6 0 0\n", {QuaternionOrder::wxyz}));
}

TEST(Orientations, WrittenAreReadBackWithOrWithoutHeading) {
  const TempFolder folder;
  const std::vector<OrientationSample> samples = {{0, so3::exp({0.1, 0.2, 0.3})}, {1'000'000, so3::exp({0.2, 0, 0})}};
  for (const bool has_heading : {true, false}) {
    write_orientations(folder / "o.txt", samples, has_heading);
    OrientationConvention used;
    const auto back = read_orientations(folder / "o.txt", {}, nullptr, &used);
    EXPECT_EQ(used.has_heading, has_heading);
    ASSERT_EQ(back.size(), 2U);
    EXPECT_EQ(back[1].time, 1'000'000);
    EXPECT_TRUE(back[0].earth_from_body.isApprox(samples[0].earth_from_body, 1e-8));
  }
}

TEST(Orientations, ReadsATrajectory) {
  expect_turn(read_from_text("12.5 1 2 3 0.6 0 0 0.8\n"));
  expect_turn(read_from_text("# timestamp tx ty tz qx qy qz qw\n12.5 1 2 3 0.6 0 0 0.8\n"));
  expect_turn(read_from_text("12.5 nan nan nan 0.6 0 0 0.8\n"));  // the position is not asked for
  expect_turn(read_from_text("12.5 1 2 3 0.8 0.6 0 0\n", {QuaternionOrder::wxyz}));
}

TEST(Orientations, ReadsEuRoC) {
  OrientationConvention used;
  const std::string head =
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
      "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], "
      "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";
  const std::string row =
      "1403636580838555648,4.6,-1.7,0.7,0.8,0.6,0,0,-0.02,0.03,0.8,-0.003,0.02,0.08,-0.02,0.1,0.2\n";
  const auto s = read_from_text(head + row, {}, nullptr, &used);
  expect_turn(s);
  EXPECT_EQ(s[0].time, 1403636580838555648);
  EXPECT_EQ(used.quaternion, QuaternionOrder::wxyz);
  expect_turn(read_from_text(row));  // without a heading
  const std::string vicon =
      "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z []\n";
  expect_turn(read_from_text(vicon + "1403636580838555648,4.6,-1.7,0.7,0.8,0.6,0,0\n"));
  expect_turn(read_from_text("1403636580838555648,0.8,0.6,0,0\n"));
  // Stamps that could be seconds are nanoseconds by their heading, or by a later line.
  const auto from_zero = read_from_text("#timestamp [ns],q_w,q_x,q_y,q_z\n0,0.8,0.6,0,0\n5000000,1,0,0,0\n");
  expect_turn(from_zero, 2);
  EXPECT_EQ(from_zero[1].time, 5000000);
  EXPECT_EQ(read_from_text("0,1,0,0,0\n20000000000,0.8,0.6,0,0\n")[1].time, 20000000000);
  expect_turn(read_from_text("1403636580838555648,0.6,0,0,0.8\n", {QuaternionOrder::xyzw}));
}

TEST(Orientations, GoesByTheNamesOfTheColumns) {
  expect_turn(read_from_text("timestamp,qw,qx,qy,qz\n1.5,0.8,0.6,0,0\n"));
  expect_turn(read_from_text("t,gx,gy,orientation.x,orientation.y,orientation.z,orientation.w\n1.5,7,8,0.6,0,0,0.8\n"));
  expect_turn(read_from_text("# t qw qx qy qz temperature\n1.5 0.8 0.6 0 0 21\n"));
  EXPECT_THAT(error_of([] { read_from_text("timestamp,gyro_x,gyro_y,gyro_z,wait\n1.5,7,8,9,1\n"); }),
              AllOf(HasSubstr("no orientation among the columns timestamp, gyro_x"), HasSubstr("t qx qy qz qw")));
}

TEST(Orientations, ConvertsToEarthFromBodyEastNorthUp) {
  EXPECT_TRUE(read_from_text("1 0.6 0 0 0.8\n", {{}, OrientationOf::world_to_body})[0].earth_from_body.isApprox(
      kTurn.transpose(), 1e-12));
  // Level, the body's x to the north: in NED no rotation at all.
  const Matrix3d ned = read_from_text("1 0 0 0 1\n", {{}, {}, EarthAxes::ned})[0].earth_from_body;
  EXPECT_EQ(ned * Vector3d::UnitX(), Vector3d::UnitY());
  EXPECT_EQ(ned * Vector3d::UnitZ(), Vector3d(0, 0, -1));
  EXPECT_EQ(ned.determinant(), 1);
  const Matrix3d y_up = read_from_text("1 0 0 0 1\n", {{}, {}, EarthAxes::y_up})[0].earth_from_body;
  EXPECT_EQ(y_up * Vector3d::UnitX(), Vector3d::UnitX());
  EXPECT_EQ(y_up * Vector3d::UnitY(), Vector3d::UnitZ());
  EXPECT_EQ(y_up.determinant(), 1);
  // The fixed rotation is on the left of the inverse, too.
  const Matrix3d both =
      read_from_text("1 0.6 0 0 0.8\n", {{}, OrientationOf::world_to_body, EarthAxes::ned})[0].earth_from_body;
  EXPECT_TRUE(both.isApprox(ned * kTurn.transpose(), 1e-12));
}

TEST(Orientations, ConventionsRoundTrip) {
  const Matrix3d r = so3::exp(Vector3d(0.3, -2, 0.9));
  for (const auto order : {QuaternionOrder::xyzw, QuaternionOrder::wxyz})
    for (const auto of : {OrientationOf::body_to_world, OrientationOf::world_to_body})
      for (const auto earth : {EarthAxes::enu, EarthAxes::ned, EarthAxes::y_up}) {
        const OrientationConvention c{order, of, earth};
        EXPECT_TRUE(decode_orientation(encode_orientation(r, c), c).isApprox(r, 1e-12));
        EXPECT_TRUE(decode_orientation(-2 * encode_orientation(r, c), c).isApprox(r, 1e-12));
      }
}

TEST(Orientations, LeavesOutWhatIsNoUnitQuaternion) {
  std::vector<std::string> notes;
  const auto s = read_from_text(
      "# head\n1 0.603 0 0 0.804\n2 nan nan nan nan\n3 0 0 0 0\n4 0 0 0 1\n5 0 0 0 1\n6 0 0 0 1\n", {}, &notes);
  expect_turn(s, 4);
  EXPECT_TRUE((s[0].earth_from_body * s[0].earth_from_body.transpose()).isIdentity(1e-12));
  EXPECT_THAT(notes, ElementsAre(AllOf(HasSubstr("2 of 6 orientations"), HasSubstr("line 3"), HasSubstr("left out"))));
  EXPECT_THAT(error_of([] { read_from_text("1 0 0 0 1\n2 10 20 30 0\n3 11 20 30 0\n4 0 0 0 0\n5 0 0 0 1\n"); }),
              AllOf(HasSubstr("3 of 5"), HasSubstr("line 2")));
  EXPECT_EQ(read_from_text("1 0 0 0 1\n2 nan 0 0 1\n").size(), 1u);  // half of them is not more than half
}

TEST(Orientations, SortsAndThins) {
  std::vector<std::string> notes;
  const auto s = read_from_text("3 0 0 0 1\n1 0.6 0 0 0.8\n3 0 0 1 0\n", {}, &notes);
  expect_turn(s, 2);
  EXPECT_TRUE(s[1].earth_from_body.isIdentity(0));
  EXPECT_THAT(notes, ElementsAre(HasSubstr("the orientations were not in order"), HasSubstr("1 orientations")));
}

TEST(Orientations, HalfWrittenLastLineIsLeftOut) {
  for (const char* end : {"2 0 0 0", "2 0 0\n", "2 0 0 0 0.", "2 0 0 0 -", "2"}) {
    std::vector<std::string> notes;
    EXPECT_EQ(read_from_text(std::string("1 0 0 0 1\n") + end, {}, &notes).size(), 1u) << end;
    EXPECT_THAT(notes, ElementsAre(HasSubstr("half-written"))) << end;
  }
}

TEST(Orientations, MalformedLinesAreErrorsWithTheirNumber) {
  const auto error = [&](const std::string& line) {
    return error_of([&] { read_from_text("# head\n1 0 0 0 1\n" + line + "\n9 0 0 0 1\n"); });
  };
  EXPECT_THAT(error("2 0 0 0"), AllOf(HasSubstr("o.txt:3"), HasSubstr("4 fields where the lines before have 5")));
  EXPECT_THAT(error("2 0 0 0 1 5"), HasSubstr("6 fields"));
  EXPECT_THAT(error("2 0 x 0 1"), HasSubstr("'x' is not a number"));
  EXPECT_THAT(error("a 0 0 0 1"), HasSubstr("'a' is not a time in seconds"));
  EXPECT_THAT(error_of([] { read_from_text("1403636580838555648,1,0,0,0\n1.5,1,0,0,0\n"); }),
              HasSubstr("'1.5' is not a time in whole nanoseconds"));
  EXPECT_THAT(error_of([] { read_from_text("1 2 3 4\n2 3 4 5\n"); }), HasSubstr("4 fields"));
  EXPECT_THAT(error_of([] { read_from_text("# nothing\n"); }), HasSubstr("no orientations"));
  EXPECT_THAT(error_of([] { read_from_text(""); }), HasSubstr("no orientations"));
  EXPECT_THAT(error_of([] { read_from_text("t,qx,qy,qz,qw\n"); }), HasSubstr("no orientations"));
  EXPECT_THAT(error_of([] { read_from_text("1 nan nan nan nan\n"); }), HasSubstr("1 of 1"));
  EXPECT_THAT(error_of([] { read_orientations("/no/such/file", {}); }), HasSubstr("No such file"));
}

TEST(Orientations, AGroundTruthServes) {
  PLUMBLINE_DATA_OR_SKIP(file, "tum/rgbd_dataset_freiburg1_xyz/groundtruth.txt");
  const auto samples = read_orientations(file.string(), {});
  const Trajectory truth = read_trajectory(file.string());
  ASSERT_EQ(samples.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ASSERT_EQ(samples[i].time, truth[i].time);
    ASSERT_TRUE(samples[i].earth_from_body.isApprox(truth[i].world_from_camera.rotation(), 1e-12));
  }
}

TEST(Orientations, ReadsCountsAndAnglesOfTheBno055) {
  std::vector<std::string> notes;
  expect_turn(read_from_text("t,qw,qx,qy,qz\n1,13107.2,9830.4,0,0\n", {}, &notes));
  EXPECT_THAT(notes, ElementsAre(HasSubstr("1/16384")));
  notes.clear();
  // A heading of 90° to the east turns the body clockwise as seen from above; a pitch turns about x.
  const auto s = read_from_text("timestamp,heading,roll,pitch\n1,90,0,0\n2,0,0,30\n", {}, &notes);
  ASSERT_EQ(s.size(), 2U);
  EXPECT_TRUE(s[0].earth_from_body.isApprox(so3::exp(Vector3d(0, 0, -std::numbers::pi / 2)), 1e-9));
  EXPECT_TRUE(s[1].earth_from_body.isApprox(so3::exp(Vector3d(std::numbers::pi / 6, 0, 0)), 1e-9));
  EXPECT_THAT(notes, ElementsAre(AllOf(HasSubstr("degrees"), HasSubstr("a guess"))));
  notes.clear();  // registers: 16 counts a degree
  const auto counts = read_from_text("timestamp,heading,roll,pitch\n1,1440,0,0\n2,0,0,480\n", {}, &notes);
  EXPECT_TRUE(counts[1].earth_from_body.isApprox(s[1].earth_from_body, 1e-9));
  EXPECT_THAT(notes, ElementsAre(HasSubstr("sixteenths of a degree")));
  EXPECT_TRUE(read_from_text("t,roll [rad],pitch [rad],yaw [rad]\n1,0,0,0.5\n")[0].earth_from_body.isApprox(
      so3::exp(Vector3d(0, 0, 0.5)), 1e-9));
}

}  // namespace
}  // namespace plumbline
