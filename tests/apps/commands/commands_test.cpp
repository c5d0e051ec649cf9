// The commands beside `run`.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "io/images/image_file.h"
#include "io/mesh.h"
#include "io/trajectory.h"
#include "plumbline/config.h"
#include "plumbline/image.h"
#include "plumbline/se3.h"
#include "plumbline/trajectory.h"
#include "report/report.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using Commands = SmallSequence;

TEST_F(Commands, HelpAndVersionAreNotErrors) {
  const Outcome help = plumbline({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"run", "info", "eval", "render", "plot", "view", "demo", "backends"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    const Outcome own = plumbline({command, "--help"});
    EXPECT_EQ(own.exit_code, 0);
    EXPECT_THAT(own.out, HasSubstr(std::string("plumbline ") + command));
  }
  const Outcome version = plumbline({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, testing::MatchesRegex("plumbline [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(Commands, BackendsListsTheCpu) {
  const Outcome outcome = plumbline({"backends"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("cpu    available"), HasSubstr("cuda")));
}

TEST_F(Commands, PrintConfigIsAConfigurationFile) {
  const Outcome outcome = plumbline({"run", "--print-config", "--set", "volume.side=5.5"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  Parameters printed, expected = preset("plumbline");
  parse_parameters(outcome.out, "printed", &printed);
  expected.volume.side = 5.5;
  EXPECT_EQ(to_toml(printed), to_toml(expected));
}

TEST_F(Commands, InfoTellsWhatWasFound) {
  const Outcome outcome = plumbline({"info", sequence()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("TUM RGB-D"), HasSubstr("10 in 0.3 s, 30.0 a second, 10 with colour"),
                    HasSubstr("160x120, fx 131 fy 131 cx 79.5 cy 59.5"), HasSubstr("camera-intrinsics.txt"),
                    HasSubstr("5000"), HasSubstr("groundtruth.txt"), HasSubstr("33.3 ms (median)")));
}

TEST_F(Commands, InfoTakesTheSameOptionsAsRun) {
  const Outcome outcome = plumbline({"info", sequence(), "--intrinsics", "120,-121,80,60", "--depth-scale", "1000",
                                     "--distortion", "-0.1,0,0,0,0", "--no-color"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("fx 120 fy -121"), HasSubstr("1000"), HasSubstr("distortion -0.1"),
                                 HasSubstr("no colour")));
}

TEST_F(Commands, EvalComparesTrajectories) {
  const std::string truth = sequence() + "/groundtruth.txt";
  Trajectory moved = read_tum_trajectory(truth);
  Vector6d xi;
  xi << 0.3, -0.2, 1, 5, 6, 7;
  for (StampedPose& pose : moved) pose.world_from_camera = SE3::exp(xi) * pose.world_from_camera;
  write_tum_trajectory(path("moved.txt"), moved);

  const Outcome ate = plumbline({"eval", "ate", truth, path("moved.txt"), "--json"});
  ASSERT_EQ(ate.exit_code, 0) << ate.err;
  const auto json = nlohmann::json::parse(ate.out)["estimates"][0];
  EXPECT_EQ(json["pairs"], kSmallFrames);
  EXPECT_LT(json["translation_m"]["rmse"].get<double>(), 1e-6);

  const Outcome rpe =
      plumbline({"eval", "rpe", truth, path("moved.txt"), "--delta", "2", "--unit", "frames", "--json"});
  ASSERT_EQ(rpe.exit_code, 0) << rpe.err;
  EXPECT_LT(nlohmann::json::parse(rpe.out)["estimates"][0]["translation_m"]["rmse"].get<double>(), 1e-6);
  EXPECT_LT(nlohmann::json::parse(rpe.out)["estimates"][0]["rotation_deg"]["max"].get<double>(), 1e-4);

  EXPECT_THAT(plumbline({"eval", "ate", truth, path("moved.txt")}).out, HasSubstr("10   0.00000"));
  EXPECT_THAT(plumbline({"eval", "rpe", truth, path("moved.txt"), "--all-pairs"}).out, HasSubstr("rotation"));
}

TEST_F(Commands, EvalRefusesTrajectoriesOfDifferentClocks) {
  const std::string truth = sequence() + "/groundtruth.txt";
  Trajectory later = read_tum_trajectory(truth);
  for (StampedPose& pose : later) pose.time += 100 * kNanosecondsPerSecond;
  write_tum_trajectory(path("later.txt"), later);
  const Outcome apart = plumbline({"eval", "ate", truth, path("later.txt")});
  EXPECT_EQ(apart.exit_code, 1);
  EXPECT_THAT(apart.err, HasSubstr("plumbline: error: "));
  const Outcome shifted = plumbline({"eval", "ate", truth, path("later.txt"), "--offset", "-100"});
  EXPECT_EQ(shifted.exit_code, 0) << shifted.err;
  EXPECT_THAT(shifted.out, HasSubstr("-100 s"));
  EXPECT_EQ(plumbline({"eval", "ate", truth, path("none.txt")}).exit_code, 1);
  EXPECT_EQ(plumbline({"eval", "rpe", truth, truth, "--unit", "miles"}).exit_code, 2);
  EXPECT_EQ(plumbline({"eval"}).exit_code, 2);
}

TEST_F(Commands, RenderMakesAPicture) {
  good_mesh();
  const std::string picture = path("mesh.png");
  const Outcome outcome = plumbline({"render", output() + "/mesh.ply", "-o", picture, "--size", "200x150",
                                     "--trajectory", output() + "/trajectory.txt", "--pose", "0 0 -1 0 0 0 1"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const ColorImage image = read_color_image(picture);
  EXPECT_EQ(image.width, 200);
  EXPECT_EQ(image.height, 150);
  EXPECT_NE(image.at(100, 75, 0), image.at(0, 0, 0));  // the desk before the background
  EXPECT_EQ(plumbline({"render", output() + "/mesh.ply", "-o", picture, "--size", "200"}).exit_code, 2);
  EXPECT_EQ(plumbline({"render", output() + "/mesh.ply", "-o", picture, "--up", "0,0,0"}).exit_code, 2);
  EXPECT_EQ(plumbline({"render", path("none.ply"), "-o", picture}).exit_code, 1);
}

TEST_F(Commands, DemoScansADeskAndReports) {
  const std::string folder = path("demo");
  const Outcome outcome = plumbline({"demo", "-o", folder, "--frames", "8"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("It works: all 8 frames"),
                                 HasSubstr(app::can_report() ? folder + "/report.html" : "built without it")));
  EXPECT_EQ(read_color_image(folder + "/mesh.png").width, 1280);
  if (app::can_report()) {
    const std::string report = read_text(folder + "/report.html");
    EXPECT_THAT(report, AllOf(HasSubstr("It works: all 8 frames"), HasSubstr("8 of 8"), HasSubstr("Surface error"),
                              HasSubstr("id=\"mesh-errors\"")));
  }
  const Outcome info = plumbline({"info", folder + "/sequence"});
  EXPECT_THAT(info.out, AllOf(HasSubstr("8 in 0.2 s"), HasSubstr("8 with colour")));
  EXPECT_TRUE(std::filesystem::exists(folder + "/run/mesh.ply"));
}

}  // namespace
}  // namespace plumbline::test
