#include "io/trajectory.h"

#include <gmock/gmock.h>

#include <random>

#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/data.h"
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

}  // namespace
}  // namespace plumbline
