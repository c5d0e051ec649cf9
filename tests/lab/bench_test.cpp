// What `bench --grow` makes of its measurements.
#include "lab/bench_growth.h"

#include <gmock/gmock.h>

#include "support/program.h"
#include "support/small_sequence.h"

namespace plumbline::test {
namespace {

using app::Growth;
using testing::HasSubstr;

Growth example() {
  return {"image",
          "Time over the image's size",
          "pixels",
          {100, 400, 1600},
          {"10x10", "20x20", "40x40"},
          {"linear", "constant", "root"},
          {{1, 4, 16}, {3, 3, 3}, {5, 10, 20}}};
}

TEST(Exponent, IsTheSlopeOnLogarithmicAxes) {
  const Growth g = example();
  EXPECT_NEAR(app::exponent(g.sizes, g.milliseconds[0]), 1, 1e-12);
  EXPECT_NEAR(app::exponent(g.sizes, g.milliseconds[1]), 0, 1e-12);
  EXPECT_NEAR(app::exponent(g.sizes, g.milliseconds[2]), 0.5, 1e-12);
  EXPECT_EQ(app::exponent({1}, {2}), 0) << "one size tells nothing";
}

TEST(GrowthTable, HasARowForEachStageAndEndsWithItsExponent) {
  const app::Table table = app::growth_table(example());
  EXPECT_EQ(table.columns, (std::vector<std::string>{"stage", "10x10", "20x20", "40x40", "exponent"}));
  EXPECT_THAT(app::table_csv(table), HasSubstr("root,5,10,20,0.5"));
}

TEST(GrowthPlot, HasAPanelForEach) {
  const app::Plot plot = app::growth_plot({example(), example()});
  ASSERT_EQ(plot.panels.size(), 2U);
  EXPECT_EQ(plot.panels[0].series.size(), 3U);
  EXPECT_TRUE(plot.panels[0].x.log && plot.panels[0].y.log);
}

using Bench = SmallSequence;

TEST_F(Bench, RefusesAnOutputThatIsAFileBeforeItMeasures) {
  write_text(path("in_the_way"), "x");
  const Outcome outcome = plumbline({"bench", "--grow", "-o", path("in_the_way")});
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("in_the_way"));
}

}  // namespace
}  // namespace plumbline::test
