// `simulate`, and `eval surface` on what comes out.
#include <gmock/gmock.h>
#include <sched.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/images/image_file.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/mesh.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Simulate : public SmallSequence {
 protected:
  Outcome simulate(const std::string& folder, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"simulate", "-o", path(folder), "--size", "160x120", "--frames", "8"};
    words.insert(words.end(), more.begin(), more.end());
    return plumbline(words);
  }
};

TEST_F(Simulate, RunReadsTheFolderAndTheSurfaceIsMet) {
  const Outcome made = simulate("sim", {"--scene", "teddy", "--trajectory", "orbit"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_THAT(plumbline({"info", path("sim")}).out, AllOf(HasSubstr("TUM RGB-D"), HasSubstr("8 with colour"),
                                                          HasSubstr("fx 131.25"), HasSubstr("groundtruth.txt")));
  EXPECT_THAT(read_text(path("sim") + "/scene.toml"),
              AllOf(HasSubstr("scene = \"teddy\""), HasSubstr("[depth_noise]")));
  EXPECT_THAT(read_text(path("sim") + "/imu.csv"), HasSubstr("timestamp,gyro_x"));
  EXPECT_THAT(read_text(path("sim") + "/orientation.txt"), HasSubstr("\n1.000000000 "));
  EXPECT_EQ(read_tum_trajectory(path("sim") + "/groundtruth.txt").size(), 8U);

  const Outcome run =
      plumbline({"run", path("sim"), "-o", output(), "--quiet", "--set", "volume.resolution=128", "--set",
                 "volume.side=4", "--set", "volume.truncation=0.1", "--set", "mesh.min_weight=1", "--detail",
                 "off"});  // what lies beyond the volume is far and noisy
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Outcome surface = plumbline({"eval", "surface", output() + "/mesh.ply", path("sim") + "/scene.ply",
                                     "--trajectory", output() + "/trajectory.txt", "--thresholds", "0.02,0.1",
                                     "--error-mesh", path("error.ply"), "--json"});
  ASSERT_EQ(surface.exit_code, 0) << surface.err;
  const auto json = nlohmann::json::parse(surface.out);
  EXPECT_LT(json["accuracy_m"]["median"].get<double>(), 0.03);
  EXPECT_GT(json["scores"][1]["precision"].get<double>(), 0.9);
  EXPECT_GT(json["scores"][1]["recall"].get<double>(), json["scores"][0]["recall"].get<double>());
  EXPECT_LT(json["completeness_m"]["points"].get<int>(), 200000) << "only what was seen counts";
  const Mesh painted = read_mesh(path("error.ply"));
  EXPECT_EQ(painted.colors.size(), painted.positions.size());
  // Without the alignment the mesh lies in the first camera's frame, far from the scene's.
  const Outcome apart = plumbline({"eval", "surface", output() + "/mesh.ply", path("sim") + "/scene.ply", "--json"});
  ASSERT_EQ(apart.exit_code, 0) << apart.err;
  EXPECT_GT(nlohmann::json::parse(apart.out)["accuracy_m"]["median"].get<double>(), 0.05);
}

TEST_F(Simulate, SameSeedSameBytesForAnyNumberOfThreads) {
  const std::vector<std::string> options = {"--scene", "teddy",      "--trajectory", "handheld",
                                            "--quiet", "--exposure", "0.01"};
  std::vector<std::string> one = options, many = options, other = options;
  one.insert(one.end(), {"--threads", "1"});
  many.insert(many.end(), {"--threads", "2"});
  other.insert(other.end(), {"--seed", "2"});
  ASSERT_EQ(simulate("a", one).exit_code, 0);
  ASSERT_EQ(simulate("b", many).exit_code, 0);
  ASSERT_EQ(simulate("c", other).exit_code, 0);
  int files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path("a"))) {
    if (!entry.is_regular_file()) continue;
    const std::string name = std::filesystem::relative(entry.path(), path("a")).string();
    EXPECT_EQ(read_text(entry.path().string()), read_text(path("b") + "/" + name)) << name;
    ++files;
  }
  EXPECT_EQ(files, 8 + 8 + 8);
  const auto first_depth = [&](const std::string& folder) { return read_text(path(folder) + "/depth/1.000000.png"); };
  EXPECT_NE(first_depth("a"), first_depth("c"));
}

TEST_F(Simulate, MoreThreadsThanTheProcessMayHaveAreQuietAndChangeNothing) {
  const auto words = [&](const std::string& folder, const std::string& threads) {
    return std::vector<std::string>{"simulate", "-o",       path(folder), "--size",  "160x120",   "--frames", "3",
                                    "--scene",  "corridor", "--no-color", "--quiet", "--threads", threads};
  };
  Launch on_one_core;
  on_one_core.in_child = [] {
    cpu_set_t one;
    CPU_ZERO(&one);
    sched_getaffinity(0, sizeof(one), &one);
    int core = 0;
    while (!CPU_ISSET(core, &one)) ++core;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    sched_setaffinity(0, sizeof(one), &one);
  };
  const Outcome many = plumbline(words("many", "8"), on_one_core);
  ASSERT_EQ(many.exit_code, 0) << many.err;
  EXPECT_EQ(many.err + many.out, "") << "no warning of oneTBB";
  ASSERT_EQ(plumbline(words("one", "1")).exit_code, 0);
  for (const char* name : {"depth/1.000000.png", "depth/1.066667.png", "imu.csv", "groundtruth.txt"})
    EXPECT_EQ(read_text(path("many") + "/" + name), read_text(path("one") + "/" + name)) << name;
}

TEST_F(Simulate, TurnsOnTheSpotAndPlaysFaster) {
  ASSERT_EQ(simulate("turn", {"--scene", "corridor", "--turn", "20", "--exact", "--no-color", "--imu-ideal"}).exit_code,
            0);
  const Trajectory poses = read_tum_trajectory(path("turn") + "/groundtruth.txt");
  ASSERT_EQ(poses.size(), 8U);
  for (std::size_t i = 0; i < poses.size(); i += 2) {
    const SE3 step = poses[i].world_from_camera.inverse() * poses[i + 1].world_from_camera;
    EXPECT_LT(step.translation().norm(), 1e-6);
    EXPECT_NEAR(so3::angle(step.rotation()), 20 * 3.14159265358979 / 180, 1e-6);
  }
  EXPECT_FALSE(std::filesystem::exists(path("turn") + "/rgb.txt"));

  ASSERT_EQ(simulate("slow", {"--scene", "corridor", "--no-color", "--trajectory", "sweep", "--shake", "0"}).exit_code,
            0);
  ASSERT_EQ(
      simulate("fast", {"--scene", "corridor", "--no-color", "--trajectory", "sweep", "--shake", "0", "--speed", "2"})
          .exit_code,
      0);
  const Trajectory slow = read_tum_trajectory(path("slow") + "/groundtruth.txt");
  const Trajectory fast = read_tum_trajectory(path("fast") + "/groundtruth.txt");
  EXPECT_LT((slow[6].world_from_camera.translation() - fast[3].world_from_camera.translation()).norm(), 1e-6);
}

TEST_F(Simulate, ARecordedPathIsPlacedInTheScene) {
  Trajectory recorded;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.05 * i;
    recorded.push_back(
        {50'000'000LL * i, SE3(so3::exp(Eigen::Vector3d(-2, 0, 0)) * so3::exp(Eigen::Vector3d(0, 0.3 * std::sin(t), 0)),
                               Eigen::Vector3d(20 + 0.2 * std::sin(t), 30, 1.4))});
  }
  write_tum_trajectory(path("path.txt"), recorded);
  const Outcome made = simulate("placed", {"--scene", "kitchen", "--trajectory", path("path.txt"), "--no-color"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Trajectory poses = read_tum_trajectory(path("placed") + "/groundtruth.txt");
  EXPECT_LT(poses.front().world_from_camera.translation().head<2>().norm(), 3) << "inside the kitchen";
  EXPECT_THAT(read_text(path("placed") + "/scene.toml"), AllOf(HasSubstr("placement = ["), HasSubstr("smoothing_rms")));
  EXPECT_EQ(simulate("x", {"--scene", path("path.txt")}).exit_code, 1) << "no mesh";
}

TEST_F(Simulate, MistakesOnTheCommandLine) {
  EXPECT_THAT(simulate("x", {"--scene", "attic"}).err, HasSubstr("desk, room, kitchen, teddy, corridor"));
  EXPECT_EQ(simulate("x", {"--scene", "attic"}).exit_code, 2);
  EXPECT_EQ(simulate("x", {"--trajectory", "spiral"}).exit_code, 2);
  EXPECT_EQ(simulate("x", {"--scene", "corridor", "--imu-mounting", "1 1 1 1"}).exit_code, 2);
  EXPECT_EQ(simulate("x", {"--speed", "0"}).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(path("x") + "/depth.txt"));
  EXPECT_EQ(plumbline({"eval", "surface", path("none.ply"), path("none.ply")}).exit_code, 1);
}

}  // namespace
}  // namespace plumbline::test
