// The mesh of `plumbline run`: fused finally or the volume's, and in which formats.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "io/images/png.h"
#include "io/mesh.h"
#include "plumbline/image.h"
#include "plumbline/mesh.h"
#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using testing::HasSubstr;

class FinalMesh : public SmallSequence {
 protected:
  Outcome run(const std::vector<std::string>& more) const { return plumbline(small_run(sequence(), output(), more)); }
  nlohmann::json fusion() const { return nlohmann::json::parse(read_text(output() + "/summary.json"))["final_fusion"]; }
  Mesh mesh() const { return read_ply(output() + "/mesh.ply"); }
};

TEST_F(FinalMesh, IsFusedUnlessItIsNotWanted) {
  ASSERT_EQ(run({"--detail", "off"}).exit_code, 0);
  EXPECT_TRUE(fusion().is_null());
  const std::size_t coarse = mesh().triangles.size();
  const Outcome outcome = run({"--detail", "12mm"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(fusion()["frames"], kSmallFrames);
  EXPECT_EQ(fusion()["detail_m"], 0.012);
  EXPECT_GT(mesh().triangles.size(), 4 * coarse);  // voxels of 42 mm before
  EXPECT_EQ(mesh().colors.size(), mesh().positions.size());
  ASSERT_EQ(run({}).exit_code, 0);
  EXPECT_EQ(fusion()["frames"], kSmallFrames);
}

TEST_F(FinalMesh, PublishedPresetsKeepTheirVolumes) {
  ASSERT_EQ(run({"--preset", "kinectfusion"}).exit_code, 0);
  EXPECT_TRUE(fusion().is_null());
  ASSERT_EQ(run({"--preset", "kinectfusion", "--detail", "12 mm"}).exit_code, 0);
  EXPECT_EQ(fusion()["frames"], kSmallFrames);
}

TEST_F(FinalMesh, LostFramesAreNotFused) {
  write_depth_png(depth_images()[4], DepthImage(kSmallCamera.width, kSmallCamera.height));
  ASSERT_EQ(run({"--detail", "12mm"}).exit_code, 0);
  const auto summary = nlohmann::json::parse(read_text(output() + "/summary.json"));
  ASSERT_EQ(summary["lost"], 1);
  EXPECT_EQ(fusion()["frames"], kSmallFrames - 1);
}

TEST_F(FinalMesh, TooLittleMemoryLeavesTheVolumesMesh) {
  const Outcome outcome = run({"--memory", "0.001MB"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("the mesh is that of the volume: there is not enough memory"));
  EXPECT_THAT(fusion()["note"].get<std::string>(), HasSubstr("memory"));
  EXPECT_GT(mesh().triangles.size(), 1000u);
}

TEST_F(FinalMesh, HasTheFormatOfItsName) {
  const Outcome outcome =
      run({"--detail", "20mm", "--mesh", "a.obj", "--mesh", "b.glb", "--mesh", "c.stl", "--max-triangles", "5000"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_LE(mesh().triangles.size(), 5000u);
  EXPECT_EQ(read_obj(output() + "/a.obj").triangles.size(), mesh().triangles.size());
  EXPECT_EQ(read_text(output() + "/b.glb").substr(0, 4), "glTF");
  EXPECT_EQ(read_text(output() + "/c.stl").size(), 84 + 50 * mesh().triangles.size());
}

TEST_F(FinalMesh, WhatIsNotUnderstoodIsAnError) {
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--detail", "3parsecs"},
                                               {"--detail", "-4mm"},
                                               {"--detail", "mm"},
                                               {"--memory", "2"},
                                               {"--mesh", "a.xyz"},
                                               {"--mesh", "x/a.ply"}}) {
    const Outcome outcome = run(more);
    EXPECT_EQ(outcome.exit_code, 2) << more[1];
    EXPECT_THAT(outcome.err, HasSubstr(more[0]));
  }
  EXPECT_EQ(run({"--detail", "10m"}).exit_code, 0);  // out of range: told, and the volume's mesh is there
}

}  // namespace
}  // namespace plumbline::test
