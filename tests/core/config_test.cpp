#include "plumbline/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "plumbline/error.h"
#include "support/error_of.h"

namespace plumbline {
namespace {

using test::error_of;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string parse_error(const std::string& toml) {
  return error_of([&] {
    Parameters parameters;
    parse_parameters(toml, "my.toml", &parameters);
  });
}

std::string setting_error(const std::string& assignment) {
  return error_of([&] {
    Parameters parameters;
    apply_setting(assignment, &parameters);
  });
}

TEST(Config, TheDefaultIsThePresetPlumbline) {
  EXPECT_EQ(to_toml(preset("plumbline")), to_toml(Parameters()));
  EXPECT_THAT(preset_names(), testing::ElementsAre("plumbline", "paper", "kinectfusion"));
  EXPECT_NO_THROW(validate(Parameters()));
}

TEST(Config, ThereAreFewEnoughKeysToRead) { EXPECT_LE(parameter_keys().size(), 47u); }

TEST(Config, EveryPresetRoundTripsOverEveryOther) {
  for (const std::string& name : preset_names()) {
    EXPECT_NO_THROW(validate(preset(name))) << name;
    for (const std::string& other : preset_names()) {
      Parameters read = preset(other);
      parse_parameters(to_toml(preset(name)), name, &read);
      EXPECT_EQ(to_toml(read), to_toml(preset(name))) << name << " over " << other;
    }
  }
}

TEST(Config, AnAngleIsReadInDegreesAndUsedInRadians) {
  Parameters p;
  apply_setting("tracking.normal_gate=90", &p);
  EXPECT_DOUBLE_EQ(p.tracking.normal_gate.radians(), std::acos(0.0));
  EXPECT_THAT(to_toml(p), HasSubstr("\nnormal_gate = 90.0\n"));
}

TEST(Config, FormerKeysSayWhatToDo) {
  EXPECT_THAT(parse_error("[tracking]\nresidual_sigma = 0.01\n"),
              AllOf(HasSubstr("my.toml:2"), HasSubstr("'tracking.residual_sigma' is no longer a parameter"),
                    HasSubstr("tracking.redundancy")));
  EXPECT_THAT(parse_error("[raycast]\nmax_distance = 20\n"), HasSubstr("preprocess.max_depth"));
  EXPECT_THAT(setting_error("tracking.steady_turn=true"), HasSubstr("tracking.speed_memory"));
  EXPECT_THAT(setting_error("orientation.covariance=[]"), HasSubstr("--sensor-model"));
  EXPECT_THAT(setting_error("orientation.heading_sigma=10000"), HasSubstr("0.001 to 360"));
}

TEST(Config, AnUnknownPresetNamesTheKnownOnes) {
  EXPECT_THAT(error_of([] { preset("kinfu"); }), AllOf(HasSubstr("'kinfu'"), HasSubstr("kinectfusion")));
}

TEST(Config, EveryQualityOfTheDefaultPresetIsValid) {
  EXPECT_THAT(quality_names(), testing::ElementsAre("fast", "balanced", "best"));
  for (const std::string& name : quality_names()) {
    Parameters parameters = preset("plumbline");
    apply_quality(name, &parameters);
    EXPECT_NO_THROW(validate(parameters)) << name;
    EXPECT_EQ(to_toml(parameters) == to_toml(preset("plumbline")), name == "balanced") << name;
  }
  EXPECT_THAT(error_of([] {
                Parameters p;
                apply_quality("finest", &p);
              }),
              AllOf(HasSubstr("'finest'"), HasSubstr("balanced")));
}

TEST(Config, PrintedParametersReadBackToTheBit) {
  Parameters p;
  p.preprocess.min_depth = 0.1 + 0.2;  // needs all 17 digits
  p.preprocess.max_depth = std::nextafter(7.0, 8.0);
  p.preprocess.bilateral = true;
  p.tracking.iterations = {2, 0, 3, 1};
  p.tracking.redundancy = 1e9;
  p.volume.placement = VolumePlacement::fit;
  p.volume.offset = -1.0 / 3;
  p.volume.resolution = 264;
  p.mesh.min_weight = 7;
  const std::string toml = to_toml(p);
  Parameters back;
  parse_parameters(toml, "printed", &back);
  EXPECT_EQ(to_toml(back), toml);
  EXPECT_EQ(back.preprocess.min_depth, p.preprocess.min_depth);
  EXPECT_EQ(back.preprocess.max_depth, p.preprocess.max_depth);
  EXPECT_EQ(back.preprocess.bilateral, true);
  EXPECT_EQ(back.tracking.iterations, p.tracking.iterations);
  EXPECT_EQ(back.tracking.redundancy, 1e9);
  EXPECT_EQ(back.volume.placement, VolumePlacement::fit);
  EXPECT_EQ(back.volume.offset, p.volume.offset);
  EXPECT_EQ(back.mesh.min_weight, 7);
}

/// Draws every field anew within its range, so that a field added later is covered without a line here.
struct Shuffler {
  std::mt19937 random{7};
  static void group(std::string_view) {}
  double draw(const Range& range) {
    return std::uniform_real_distribution<double>(std::max(range.low, -1e6), std::min(range.high, 1e6))(random);
  }
  void operator()(std::string_view, double& value, std::string_view, std::string_view, Range range) {
    value = draw(range);
  }
  void operator()(std::string_view, int& value, std::string_view, std::string_view, Range range) {
    value = static_cast<int>(std::ceil(draw(range)));
  }
  void operator()(std::string_view, bool& value, std::string_view, std::string_view, Range) { value = !value; }
  void operator()(std::string_view, std::vector<int>& value, std::string_view, std::string_view, Range range) {
    value = {static_cast<int>(draw(range)), 0, 1};
  }
  void operator()(std::string_view, std::vector<double>& value, std::string_view, std::string_view, Range range) {
    value = {draw(range), 0, 1.5};
  }
  template <class E>
  void operator()(std::string_view, E& value, std::string_view, std::string_view, Range) {
    value = static_cast<E>(names(E{}).size() - 1 - static_cast<std::size_t>(value));
  }
};

TEST(Config, EveryFieldRoundTripsAtRandomValues) {
  Parameters shuffled;
  Shuffler shuffler;
  for (int i = 0; i < 50; ++i) {
    fields(shuffled, shuffler);
    Parameters back;
    parse_parameters(to_toml(shuffled), "shuffled", &back);
    ASSERT_EQ(to_toml(back), to_toml(shuffled));
  }
}

TEST(Config, EveryFieldIsPrintedWithItsHelp) {
  const std::string toml = to_toml(Parameters());
  for (const std::string& key : parameter_keys())
    EXPECT_THAT(toml, HasSubstr("\n" + key.substr(key.find('.') + 1) + " = "));
  EXPECT_THAT(toml, HasSubstr("# readings nearer than this are ignored (m; 0 to 100)\nmin_depth = 0.3\n"));
  EXPECT_THAT(toml, HasSubstr("front | fit | given"));
}

TEST(Config, OnlyTheNamedValuesChange) {
  Parameters p;
  p.volume.side = 6;
  parse_parameters("[tracking]\nnormal_gate = 25\niterations = [2, 3]\n", "my.toml", &p);
  EXPECT_EQ(p.tracking.normal_gate, 25);
  EXPECT_EQ(p.tracking.iterations, (std::vector<int>{2, 3}));
  EXPECT_EQ(p.volume.side, 6);
  EXPECT_EQ(p.tracking.distance_gate, Parameters().tracking.distance_gate);
}

TEST(Config, AnUnknownKeySuggestsTheNearest) {
  EXPECT_THAT(parse_error("[tracking]\n\nnormal_gte = 25\n"),
              AllOf(HasSubstr("my.toml:3"), HasSubstr("'tracking.normal_gte'"), HasSubstr("'tracking.normal_gate'")));
  EXPECT_THAT(parse_error("[volume]\nnormal_gate = 25\n"), HasSubstr("'tracking.normal_gate'"));
  EXPECT_THAT(parse_error("[trackin]\nnormal_gate = 25\n"), HasSubstr("'tracking.normal_gate'"));
  EXPECT_THAT(parse_error("normal_gate = 25\n"), HasSubstr("'tracking.normal_gate'"));
  EXPECT_THAT(parse_error("[tracking]\nxyzzy_plugh_frobnicate = 25\n"),
              AllOf(HasSubstr("--print-config"), Not(HasSubstr("Did you mean"))));
}

TEST(Config, WrongTypesNameWhatIsPermitted) {
  EXPECT_THAT(parse_error("[volume]\nresolution = 3.5\n"), AllOf(HasSubstr("my.toml:2"), HasSubstr("whole number")));
  EXPECT_THAT(parse_error("[volume]\nside = \"big\"\n"), HasSubstr("a number, 0.01 to 1000"));
  EXPECT_THAT(parse_error("[preprocess]\nbilateral = 1\n"), HasSubstr("true or false"));
  EXPECT_THAT(parse_error("[volume]\nplacement = \"back\"\n"), HasSubstr("front, fit, given"));
  EXPECT_THAT(parse_error("[tracking]\niterations = 10\n"), HasSubstr("list of whole numbers"));
  EXPECT_THAT(parse_error("[tracking]\niterations = [4, 5.5]\n"), HasSubstr("list of whole numbers"));
  EXPECT_THAT(parse_error("tracking = 3\n"), HasSubstr("group"));
  EXPECT_THAT(parse_error("[volume]\nresolution = 99999999999\n"), HasSubstr("whole number"));
}

TEST(Config, ValuesOutOfRangeNameTheRange) {
  EXPECT_THAT(parse_error("[volume]\nresolution = 4\n"),
              AllOf(HasSubstr("my.toml:2"), HasSubstr("a whole number, 8 to ")));
  EXPECT_THAT(parse_error("[volume]\nside = nan\n"), HasSubstr("out of range"));
  EXPECT_THAT(parse_error("[volume]\nside = inf\n"), HasSubstr("out of range"));
  EXPECT_THAT(parse_error("[tracking]\niterations = [4, -1]\n"), HasSubstr("0 to 1000"));
}

TEST(Config, BrokenTomlNamesTheLine) { EXPECT_THAT(parse_error("[volume]\nside = = 3\n"), HasSubstr("my.toml:2")); }

TEST(Config, AnErrorLeavesTheParametersAsTheyWere) {
  Parameters p;
  EXPECT_THROW(parse_parameters("[volume]\nside = 6.0\nresolution = 1\n", "my.toml", &p), Error);
  EXPECT_EQ(to_toml(p), to_toml(Parameters()));
}

TEST(Config, SettingsTakeEveryKindOfValue) {
  Parameters p;
  apply_setting("tracking.normal_gate=25", &p);
  apply_setting("tracking.iterations=[2,3]", &p);
  apply_setting("volume.placement=fit", &p);
  apply_setting("orientation.seed=\"absolute\"", &p);
  apply_setting("preprocess.bilateral=true", &p);
  apply_setting("volume.resolution=256", &p);
  apply_setting("volume.offset= -0.4", &p);
  EXPECT_EQ(p.tracking.normal_gate, 25);
  EXPECT_EQ(p.tracking.iterations, (std::vector<int>{2, 3}));
  EXPECT_EQ(p.volume.placement, VolumePlacement::fit);
  EXPECT_EQ(p.orientation.seed, OrientationSeed::absolute);
  EXPECT_TRUE(p.preprocess.bilateral);
  EXPECT_EQ(p.volume.resolution, 256);
  EXPECT_EQ(p.volume.offset, -0.4);
}

TEST(Config, BadSettingsSayWhichAndWhy) {
  EXPECT_THAT(setting_error("tracking.normal_gte=25"),
              AllOf(HasSubstr("--set tracking.normal_gte=25"), HasSubstr("'tracking.normal_gate'")));
  EXPECT_THAT(setting_error("tracking.normal_gate=steep"), HasSubstr("a number, 0.1 to 180"));
  EXPECT_THAT(setting_error("tracking.normal_gate=900"), HasSubstr("0.1 to 180"));
  EXPECT_THAT(setting_error("tracking.normal_gate="), HasSubstr("a number"));
  EXPECT_THAT(setting_error("tracking.normal_gate"), HasSubstr("group.name=value"));
  EXPECT_THAT(setting_error("normal_gate=25"), HasSubstr("group.name=value"));
  EXPECT_THAT(setting_error("=25"), HasSubstr("group.name=value"));
  EXPECT_THAT(setting_error("tracking.normal_gate=25\ndistance_gate=0.2"), HasSubstr("a number"));
}

TEST(Config, FilesAreReadAndMissingOnesNamed) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "plumbline_config_test.toml";
  std::ofstream(path) << "[volume]\nside = 5.5\n";
  Parameters p;
  load_parameters(path.string(), &p);
  EXPECT_EQ(p.volume.side, 5.5);
  std::filesystem::remove(path);
  EXPECT_THAT(error_of([&] { load_parameters(path.string(), &p); }), HasSubstr(path.string()));
  EXPECT_THAT(error_of([&] { load_parameters(testing::TempDir(), &p); }), HasSubstr("cannot be read"));
}

std::string contradiction(const std::string& toml) {
  return error_of([&] {
    Parameters p;
    parse_parameters(toml, "my.toml", &p);
    validate(p);
  });
}

TEST(Validate, ContradictionsAreNamed) {
  EXPECT_THAT(contradiction("[preprocess]\nmin_depth = 8.0\n"), HasSubstr("preprocess.max_depth"));
  EXPECT_THAT(contradiction("[tracking]\niterations = []\n"), HasSubstr("tracking.iterations"));
  EXPECT_THAT(contradiction("[tracking]\niterations = [0, 0]\n"), HasSubstr("tracking.iterations"));
  EXPECT_THAT(contradiction("[tracking]\nfinest_level = 5\n"), HasSubstr("Levels 0 to 6"));
  EXPECT_THAT(contradiction("[volume]\nside = 100.0\n"), HasSubstr("less than one voxel"));
  EXPECT_THAT(contradiction("[volume]\ntruncation = 5.0\n"), HasSubstr("half"));
  EXPECT_THAT(contradiction("[volume]\npose = [0, 0, 0]\n"), HasSubstr("volume.pose"));
  EXPECT_THAT(contradiction("[volume]\npose = [0, 0, 0, 1, 1, 0, 0]\n"), HasSubstr("unit quaternion"));
}

TEST(Validate, AGivenVolumePoseIsAccepted) {
  Parameters p;
  apply_setting("volume.placement=given", &p);
  apply_setting("volume.pose=[0, -1.5, 0, 0, 0.6, 0, 0.8]", &p);
  EXPECT_NO_THROW(validate(p));
  EXPECT_EQ(p.volume.pose[1], -1.5);
}

TEST(Validate, ValuesSetInCodeAreCheckedToo) {
  Parameters p;
  p.volume.side = NAN;
  EXPECT_THAT(error_of([&] { validate(p); }), HasSubstr("volume.side"));
}

}  // namespace
}  // namespace plumbline
