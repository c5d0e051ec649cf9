#include "io/trajectory.h"

#include <gmock/gmock.h>

#include <random>

#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::read_text;
using test::TempFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Trajectory read_from_text(std::string_view text, std::vector<std::string>* notes = nullptr) {
  const TempFolder folder;
  write_text(folder / "t.txt", text);
  return read_tum_trajectory(folder / "t.txt", notes);
}

TEST(Trajectory, ReadsCommentsCommasAndCrLf) {
  std::vector<std::string> notes;
  const Trajectory t = read_from_text(
      "\xEF\xBB\xBF# timestamp tx ty tz qx qy qz qw\r\n\r\n"
      "1305031102.160407 1 -2 3.5 0 0 0 1\r\n"
      "1305031102.5,1,2,3,0,0,1,0\r\n"
      "  1305031103\t1e-1 , +2.5 ,3 0.6 0 0 0.8",
      &notes);
  ASSERT_EQ(t.size(), 3u);
  EXPECT_THAT(notes, IsEmpty());
  EXPECT_EQ(t[0].time, 1305031102160407000);
  EXPECT_EQ(t[0].world_from_camera.translation(), Eigen::Vector3d(1, -2, 3.5));
  EXPECT_TRUE(t[0].world_from_camera.rotation().isIdentity(1e-15));
  EXPECT_TRUE(
      t[1].world_from_camera.rotation().isApprox(Eigen::Vector3d(-1, -1, 1).asDiagonal().toDenseMatrix(), 1e-12));
  EXPECT_EQ(t[2].world_from_camera.translation(), Eigen::Vector3d(0.1, 2.5, 3));
  // 2·atan2(0.6, 0.8) about x
  EXPECT_NEAR(so3::log(t[2].world_from_camera.rotation()).x(), 2 * std::atan2(0.6, 0.8), 1e-12);
}

TEST(Trajectory, NormalisesAQuaternionThatIsNearlyUnit) {
  const Trajectory t = read_from_text("1 0 0 0 0 0 0 1.009\n");
  EXPECT_TRUE(t[0].world_from_camera.rotation().isIdentity(1e-15));
}

TEST(Trajectory, SortsAndThins) {
  std::vector<std::string> notes;
  const Trajectory t = read_from_text("3 3 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n3 4 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n", &notes);
  ASSERT_EQ(t.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(t[i].world_from_camera.translation().x(), i + 1);
  EXPECT_THAT(notes, ElementsAre(HasSubstr("sorted"), HasSubstr("1 poses")));
}

TEST(Trajectory, HalfWrittenLastLineIsLeftOut) {
  for (const char* end : {"2 0 0 0 0 0", "2 0 0 0 0 0\n", "2 0 0 0 0 0 0 0.", "2 0 0 0 0 0 0 -"}) {
    std::vector<std::string> notes;
    EXPECT_EQ(read_from_text(std::string("1 0 0 0 0 0 0 1\n") + end, &notes).size(), 1u) << end;
    EXPECT_THAT(notes, ElementsAre(HasSubstr("half-written"))) << end;
  }
}

TEST(Trajectory, MalformedLinesAreErrorsWithTheirNumber) {
  const std::string good = "1 0 0 0 0 0 0 1\n", after = "\n9 0 0 0 0 0 0 1\n";
  const auto error = [&](const std::string& line) {
    return error_of([&] { read_from_text("# head\n" + good + line + after); });
  };
  EXPECT_THAT(error("2 0 0 0 0 0 0"), testing::AllOf(HasSubstr("t.txt:3"), HasSubstr("7 fields")));
  EXPECT_THAT(error("2 0 0 0 0 0 0 1 5"), HasSubstr("9 fields"));
  EXPECT_THAT(error("2 0 nan 0 0 0 0 1"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(error("2 0 inf 0 0 0 0 1"), HasSubstr("not a finite"));
  EXPECT_THAT(error("2 0 0 0 0 0 0 nan"), HasSubstr("not a finite"));
  EXPECT_THAT(error("2 0 0 0 0 0 0 1.02"), HasSubstr("quaternion"));
  EXPECT_THAT(error("2 0 0 0 0 0 0 0"), HasSubstr("quaternion"));
  EXPECT_THAT(error("x 0 0 0 0 0 0 1"), HasSubstr("'x' is not a time"));
  EXPECT_THAT(error("2 0 1,5x 0 0 0 1"), HasSubstr("'5x'"));
  EXPECT_THAT(error_of([&] { read_from_text(good + "2 0 0 0 0 0 0 0\n"); }), HasSubstr("quaternion"));
  EXPECT_THAT(error_of([] { read_from_text("# nothing\n"); }), HasSubstr("no poses"));
  EXPECT_THAT(error_of([] { read_tum_trajectory("/no/such/file"); }), HasSubstr("No such file"));
}

TEST(Trajectory, WrittenPosesReadBack) {
  const TempFolder folder;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  Trajectory written;
  for (int i = 0; i < 500; ++i) {
    Vector6d xi;
    for (int k = 0; k < 6; ++k) xi[k] = 3 * normal(random);
    written.push_back({1305031102160407000 + i * 33333000LL, SE3::exp(xi)});
  }
  write_tum_trajectory(folder / "t.txt", written);
  const Trajectory read = read_tum_trajectory(folder / "t.txt");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].time, written[i].time);
    const SE3 error = read[i].world_from_camera * written[i].world_from_camera.inverse();
    EXPECT_LT(error.log().norm(), 1e-7);
  }
}

TEST(Trajectory, StampsKeepTheirDigits) {
  const TempFolder folder;
  write_tum_trajectory(folder / "t.txt", {{1305031102160407000, SE3()}});
  EXPECT_THAT(read_text(folder / "t.txt"), HasSubstr("\n1305031102.160407 0.000000000 "));
  write_tum_trajectory(folder / "t.txt", {{33333333, SE3()}});
  EXPECT_THAT(read_text(folder / "t.txt"), HasSubstr("\n0.033333333 "));
}

TEST(Trajectory, WhatCannotBeWrittenLeavesTheOldFile) {
  const TempFolder folder;
  write_tum_trajectory(folder / "t.txt", {{1, SE3()}});
  const std::string old = read_text(folder / "t.txt");
  const SE3 bad(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, std::nan(""), 0));
  EXPECT_THAT(error_of([&] {
                write_tum_trajectory(folder / "t.txt", {{1, SE3()}, {2, bad}});
              }),
              HasSubstr("not finite"));
  EXPECT_EQ(read_text(folder / "t.txt"), old);
}

TEST(SevenScenesPoses, ReadsMatrices) {
  const TempFolder folder;
  write_text(folder / "frame-000003.pose.txt", "0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n");
  write_text(folder / "frame-000000.pose.txt", "1\t0\t0\t4\r\n0\t1\t0\t5\r\n0\t0\t1\t6\r\n0\t0\t0\t1\r\n");
  write_text(folder / "frame-000006.pose.txt", "-inf -inf -inf -inf\n0 1 0 5\n0 0 1 6\n0 0 0 1\n");
  std::vector<std::string> notes;
  const Trajectory t = read_trajectory(folder.path().string(), &notes);
  ASSERT_EQ(t.size(), 2u);
  EXPECT_EQ(t[0].time, 0);
  EXPECT_EQ(t[1].time, 100000000);
  EXPECT_EQ(t[0].world_from_camera.translation(), Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE((t[1].world_from_camera * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(1, 3, 3), 1e-12));
  EXPECT_THAT(notes, ElementsAre(HasSubstr("1 poses")));
}

TEST(SevenScenesPoses, RefusesWhatIsNoRigidMotion) {
  for (const char* matrix : {"2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "-1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
                             "1 0 0 0\n0 1 0 0\n0 0 1 0\n", "1 0 0 x\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"}) {
    const TempFolder folder;
    write_text(folder / "frame-000000.pose.txt", matrix);
    EXPECT_THAT(error_of([&] { read_seven_scenes_poses(folder.path().string()); }), HasSubstr("frame-000000.pose.txt"));
  }
  const TempFolder empty;
  EXPECT_THAT(error_of([&] { read_seven_scenes_poses(empty.path().string()); }), HasSubstr("no poses"));
}

TEST(Trajectory, ReadsThePublishedOnes) {
  PLUMBLINE_DATA_OR_SKIP(folder, "trajectories");
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".txt") continue;
    ++files;
    const Trajectory t = read_trajectory(entry.path().string());
    EXPECT_GT(t.size(), 500u) << entry.path();
    EXPECT_LT(t.front().time, t.back().time);
  }
  EXPECT_EQ(files, 19);
}

/// Every form below says this pose, at 2 s and at 3 s.
void expect_poses(const std::string& name, const std::string& text,
                  std::vector<Nanoseconds> times = {2'000'000'000, 3'000'000'000}, const char* note = nullptr) {
  const TempFolder folder;
  write_text(folder / name, text);
  std::vector<std::string> notes;
  const Trajectory t = read_trajectory(folder / name, &notes);
  ASSERT_EQ(t.size(), times.size()) << text;
  for (std::size_t i = 0; i < t.size(); ++i) {
    EXPECT_EQ(t[i].time, times[i]) << text;
    EXPECT_TRUE(t[i].world_from_camera.translation().isApprox(Eigen::Vector3d(1, 2, 3), 1e-9)) << text;
    EXPECT_NEAR(t[i].world_from_camera.rotation()(1, 0), 1, 1e-9) << text;  // a quarter turn about z
  }
  if (note != nullptr) {
    EXPECT_THAT(notes, testing::Contains(HasSubstr(note)));
  }
}

TEST(Trajectory, ReadsOtherProgramsForms) {
  constexpr const char* kHalf = "0.70710678118654752";
  const std::string pose = " 1 2 3 0 0 " + std::string(kHalf) + " " + kHalf;
  const std::string w_first = std::string(kHalf) + ",0,0," + kHalf;
  expect_poses("tum.txt", "# timestamp tx ty tz qx qy qz qw\n2" + pose + "\n3" + pose + "\n");
  expect_poses("heading.csv", "timestamp,x,y,z,qw,qx,qy,qz\n2,1,2,3," + w_first + "\n3,1,2,3," + w_first + "\n");
  const std::string euroc = ",1,2,3," + w_first + ",0,0,0\n";
  expect_poses("data.csv",
               "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
               "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1]\n2000000000" +
                   euroc + "3000000000" + euroc);
  const Nanoseconds stamp = 1403636579763555584;
  expect_poses("orb.txt", std::to_string(stamp) + pose + "\n", {stamp}, "nanoseconds");
  expect_poses("euroc.csv", std::to_string(stamp) + ",1,2,3," + w_first + "\n", {stamp}, "w first");
  expect_poses("rtabmap.txt", "#timestamp x y z qx qy qz qw id\n2" + pose + " 7\n3" + pose + " 9\n");
  expect_poses("ids.txt", "2" + pose + " 7\n3" + pose + " 9\n", {2'000'000'000, 3'000'000'000}, "id");
  expect_poses(
      "mm.csv",
      "time_ms,tx [mm],ty [mm],tz [mm],qx,qy,qz,qw\n2000,1000,2000,3000,0,0," + std::string(kHalf) + "," + kHalf + "\n",
      {2'000'000'000});
}

TEST(Trajectory, ReadsMatricesWithoutStamps) {
  const std::string top = "0 -1 0 1 1 0 0 2 0 0 1 3";
  const std::vector<Nanoseconds> at_10_hz = {0, 100'000'000}, at_30_hz = {0, 33'333'333};
  expect_poses("kitti.txt", top + "\n" + top + "\n", at_10_hz, "k/10 s");
  expect_poses("traj.txt", top + " 0 0 0 1\n" + top + " 0 0 0 1\n", at_30_hz, "k/30 s");
  const std::string log = "0 -1 0 1\n1 0 0 2\n0 0 1 3\n0 0 0 1\n";
  expect_poses("trajectory.log", "0 0 1\n" + log + "1 1 2\n" + log, at_30_hz, "k/30 s");
  const TempFolder folder;
  write_text(folder / "poses.txt", top + "\n" + top + "\n");
  write_text(folder / "times.txt", "0\n0.25\n");
  EXPECT_EQ(read_trajectory(folder / "poses.txt")[1].time, 250'000'000);
  write_text(folder / "scannet/pose/0.txt", log);
  write_text(folder / "scannet/pose/10.txt", log);
  write_text(folder / "scannet/pose/11.txt",
             "-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  std::vector<std::string> notes;
  const Trajectory scannet = read_trajectory(folder / "scannet", &notes);
  ASSERT_EQ(scannet.size(), 2U);
  EXPECT_EQ(scannet[1].time, 333'333'333);
  EXPECT_THAT(notes, testing::Contains(HasSubstr("1 poses that are not finite")));
  EXPECT_THAT(error_of([&] { read_trajectory(folder.path().string()); }), HasSubstr("no poses named"));
  write_text(folder / "bad.txt", "2 0 0 1 0 2 0 2 0 0 2 3\n");
  EXPECT_THAT(error_of([&] { read_trajectory(folder / "bad.txt"); }), HasSubstr("no rigid motion"));
}

}  // namespace
}  // namespace plumbline
