#include "plumbline/calibration.h"

#include <gmock/gmock.h>

#include "core/random.h"
#include "io/images/png.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::HasSubstr;

DepthDistortion some(int width, int height) {
  DepthDistortion d(width, height);
  Random random(1);
  for (double& value : d.values()) value = 0.01 * random.normal();
  return d;
}

TEST(DepthCalibrationFile, GivesBackWhatWasWritten) {
  const TempFolder folder;
  const DepthDistortion written = some(320, 240);
  write_depth_calibration(folder / "d.toml", written, {"a comment"});
  const DepthDistortion read = read_depth_calibration(folder / "d.toml");
  EXPECT_EQ(read.width(), 320);
  EXPECT_EQ(read.height(), 240);
  ASSERT_EQ(read.values().size(), written.values().size());
  for (std::size_t i = 0; i < read.values().size(); ++i) EXPECT_NEAR(read.values()[i], written.values()[i], 1e-6);
}

TEST(DepthCalibrationFile, NamesTheLineOfWhatIsWrong) {
  const TempFolder folder;
  const auto error = [&](const std::string& text) {
    write_text(folder / "d.toml", text);
    return error_of([&] { read_depth_calibration(folder / "d.toml"); });
  };
  const std::string image = "[image]\nwidth = 320\nheight = 240\n[depth]\n";
  EXPECT_THAT(error("[image"), HasSubstr("d.toml:1"));
  EXPECT_THAT(error("[image]\nwidth = 320\n"), HasSubstr("there is no image.height"));
  EXPECT_THAT(error("[image]\nwidth = 3\nheight = 240\n"), HasSubstr("image.width is too small"));
  EXPECT_THAT(error(image), HasSubstr("there is no depth.inverse_error"));
  EXPECT_THAT(error(image + "inverse_error = [0, 0]\n"), AllOf(HasSubstr("d.toml:5"), HasSubstr("list of numbers")));
  EXPECT_THAT(error(image + "inverse_error = \"x\"\n"), HasSubstr("d.toml:5"));
  EXPECT_THAT(error_of([&] { read_depth_calibration(folder / "none.toml"); }), HasSubstr("none.toml"));
}

TEST(DepthCalibrationFile, ASequenceIsReadStraightened) {
  const TempFolder folder;
  DepthImage flat(64, 48);
  for (std::uint16_t& reading : flat.pixels) reading = 10000;
  write_depth_png(folder / "1.png", flat);
  SequenceOptions options;
  options.intrinsics = Pinhole{50, 50, 31.5f, 23.5f, 64, 48};
  options.depth_scale = 5000;
  options.depth_distortion = DepthDistortion(64, 48);
  for (double& value : options.depth_distortion.values()) value = -0.125;
  const auto sequence = open_sequence(folder.path(), options);
  EXPECT_EQ(sequence->read(0).depth.at(10, 10), 8000) << "1/2 + 1/8 = 1/1.6 per metre";
  EXPECT_THAT(sequence->info().notes.back(), HasSubstr("50.0 cm rms at 2 m is taken out"));
  options.depth_distortion = DepthDistortion(32, 24);
  EXPECT_THAT(error_of([&] { open_sequence(folder.path(), options); }), HasSubstr("it is of images of 32x24"));
}

}  // namespace
}  // namespace plumbline
