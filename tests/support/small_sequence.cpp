#include "support/small_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "io/images/png.h"
#include "io/trajectory.h"
#include "plumbline/frame.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sim/analytic_scene.h"
#include "support/program.h"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;

void render_sequence(const fs::path& folder) {
  sim::OrbitOptions orbit;
  orbit.frames = kSmallFrames;
  const Trajectory poses = sim::orbit(orbit);
  const sim::AnalyticScene scene = sim::desk_corner();
  fs::create_directories(folder / "depth");
  fs::create_directories(folder / "rgb");
  std::string depth_list = "# timestamp filename\n", color_list = depth_list;
  for (const StampedPose& pose : poses) {
    const std::string stamp = format_seconds(pose.time, 6);
    const Frame frame = sim::render(scene, kSmallCamera, pose.world_from_camera, pose.time);
    write_depth_png((folder / "depth" / (stamp + ".png")).string(), frame.depth);
    write_color_png((folder / "rgb" / (stamp + ".png")).string(), frame.color);
    depth_list += fmt::format("{0} depth/{0}.png\n", stamp);
    color_list += fmt::format("{0} rgb/{0}.png\n", stamp);
  }
  write_text((folder / "depth.txt").string(), depth_list);
  write_text((folder / "rgb.txt").string(), color_list);
  write_tum_trajectory((folder / "groundtruth.txt").string(), poses);
  write_text((folder / "camera-intrinsics.txt").string(), "131 0 79.5\n0 131 59.5\n0 0 1\n");
}

/// Lives as long as the test program.
struct Original {
  TempFolder folder;
  Original() { render_sequence(folder.path() / "desk"); }
};

}  // namespace

std::vector<std::string> small_run(const std::string& sequence, const std::string& output,
                                   const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {"run",   sequence,
                                        "-o",    output,
                                        "--set", "volume.resolution=96",
                                        "--set", "volume.side=4",
                                        "--set", "volume.offset=0",
                                        "--set", "volume.truncation=0.1"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

SmallSequence::SmallSequence() {
  static const Original original;
  fs::copy(original.folder.path() / "desk", folder_ / "desk", fs::copy_options::recursive);
}

std::vector<std::string> SmallSequence::depth_images() const {
  std::vector<std::string> images;
  for (const auto& entry : fs::directory_iterator(fs::path(sequence()) / "depth"))
    images.push_back(entry.path().string());
  std::sort(images.begin(), images.end());
  return images;
}

std::string SmallSequence::good_mesh() const {
  const Outcome outcome = plumbline(small_run(sequence(), output()));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return read_text(output() + "/mesh.ply");
}

}  // namespace plumbline::test
