// Plots as files: what gnuplot was told shows in the picture.
#include "report/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "io/images/image_file.h"
#include "plumbline/error.h"
#include "plumbline/image.h"
#include "support/error_of.h"
#include "support/program.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::read_text;
using test::write_text;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class PlotFile : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (fs::path(folder_) / name).string(); }

  /// The only files in the folder: nothing temporary stays.
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  test::TempFolder temp_;
  std::string folder_ = temp_.path().string();
};

Plot red_bar() {
  Plot plot;
  plot.panels.push_back({.title = "Bars"});
  plot.panels[0].series.push_back({"", {1, 2, 3}, {0, 5, 0}, Mark::bars, "#ff0000"});
  plot.panels[0].y.low = 0;
  plot.panel_width = 300;
  plot.panel_height = 200;
  return plot;
}

TEST_F(PlotFile, PngShowsTheBarInItsColour) {
  save_plot(red_bar(), path("bar.png"));
  const ColorImage image = read_color_image(path("bar.png"));
  EXPECT_EQ(image.width, 600);
  EXPECT_EQ(image.height, 400);
  int reddish = 0, left_half = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const bool red = image.at(x, y, 0) > 200 && image.at(x, y, 1) < 150 && image.at(x, y, 2) < 150;
      reddish += red;
      left_half += red && x < image.width / 2;
    }
  }
  EXPECT_GT(reddish, 10000);
  EXPECT_NEAR(left_half, reddish / 2, reddish / 5);  // the middle one of three stands in the middle
  EXPECT_EQ(files(), 1u);
}

TEST_F(PlotFile, SvgHasTheTextAsGiven) {
  Plot plot;
  plot.title = "It's 5% of x_1^2 & more";
  plot.panels.push_back({.title = "{/Bold <left>}", .x = {.label = "µm"}, .y = {.label = "time (s)", .log = true}});
  plot.panels[0].series.push_back({"fr1_desk", {1, 2, 3}, {0.1, 10, 100}});
  plot.panels.push_back({.title = "right", .equal_scale = true});
  plot.panels[1].x.ticks = {{1, "one"}, {3, "three"}};
  plot.panels[1].series.push_back({"dots", {1, 2, 3}, {3, 2, 1}, Mark::points});
  plot.columns = 2;
  save_plot(plot, path("both.svg"));
  const std::string svg = read_text(path("both.svg"));
  EXPECT_THAT(svg, AllOf(HasSubstr("It's 5% of x_1^2 &amp; more"), HasSubstr("{/Bold &lt;left>}"), HasSubstr("µm"),
                         HasSubstr("time (s)"), HasSubstr("fr1_desk"), HasSubstr("dots"), HasSubstr(">three<")));
  EXPECT_THAT(svg, AllOf(HasSubstr("width=\"1440\""), HasSubstr("</svg>")));
}

TEST_F(PlotFile, GapsAndValuesThatCannotBeDrawn) {
  const double nan = std::nan(""), inf = INFINITY;
  Plot plot;
  plot.panels.push_back({.y = {.log = true}});
  plot.panels[0].series.push_back({"some", {1, 2, nan, 3, 4, 5}, {1, 2, 3, inf, -4, 5}, Mark::line_points});
  plot.panels[0].series.push_back({"none", {1, 2}, {nan, 0}});
  plot.panels.push_back({.title = "Nothing"});
  save_plot(plot, path("gaps.svg"), true);
  EXPECT_THAT(read_text(path("gaps.svg")),
              AllOf(HasSubstr("some"), Not(HasSubstr("none<")), HasSubstr("Nothing (no data)")));
  EXPECT_THAT(read_text(path("gaps.gp")), HasSubstr("1 1\n2 2\n\n\n\n5 5\n"));
}

TEST_F(PlotFile, TheScriptDrawsTheSameAgain) {
  save_plot(red_bar(), path("bar.svg"), true);
  EXPECT_EQ(files(), 2u);
  const std::string first = read_text(path("bar.svg"));
  fs::remove(path("bar.svg"));
  ASSERT_EQ(std::system(("cd '" + folder_ + "' && gnuplot -d bar.gp").c_str()), 0);
  EXPECT_EQ(read_text(path("bar.svg")), first);
}

TEST_F(PlotFile, LongSeriesAreThinnedButKeepTheirPeaks) {
  Plot plot;
  plot.panels.push_back({});
  Series& series = plot.panels[0].series.emplace_back();
  for (int i = 0; i < 1'000'000; ++i) {
    series.x.push_back(i);
    series.y.push_back(i == 777'777 ? 1000 : std::sin(1e-5 * i));
  }
  save_plot(plot, path("long.svg"), true);
  EXPECT_THAT(read_text(path("long.gp")), HasSubstr("\n777777 1000\n"));
  EXPECT_LT(fs::file_size(path("long.svg")), 400'000u);
}

TEST_F(PlotFile, RefusesWhatItCannotDraw) {
  EXPECT_THAT(error_of([&] { save_plot(red_bar(), path("bar.jpg")); }), HasSubstr("end in .svg or .png"));
  EXPECT_THAT(error_of([&] { check_plot(path("bar")); }), HasSubstr("end in .svg or .png"));
  EXPECT_THAT(error_of([&] { save_plot(red_bar(), path("none/bar.png")); }), HasSubstr("create the folder first"));
  EXPECT_THAT(error_of([&] { save_plot({}, path("bar.png")); }), HasSubstr("no panels"));
  Plot uneven = red_bar();
  uneven.panels[0].series[0].x.push_back(1);
  EXPECT_THAT(error_of([&] { save_plot(uneven, path("bar.png")); }), HasSubstr("4 values of x and 3 of y"));
  EXPECT_EQ(files(), 0u);
}

TEST_F(PlotFile, SaysWhatToInstallWhereGnuplotIsMissing) {
  write_text(path("old.svg"), "mine");
  const std::string search = std::getenv("PATH");
  setenv("PATH", folder_.c_str(), 1);
  const std::string drawing = error_of([&] { save_plot(red_bar(), path("old.svg")); });
  const std::string checking = error_of([&] { check_plot(path("old.svg")); });
  setenv("PATH", search.c_str(), 1);
  EXPECT_THAT(drawing, HasSubstr("apt-get install gnuplot-nox"));
  EXPECT_EQ(drawing, checking);
  EXPECT_EQ(read_text(path("old.svg")), "mine");
  EXPECT_NO_THROW(check_plot(path("old.svg")));
}

}  // namespace
}  // namespace plumbline::app
