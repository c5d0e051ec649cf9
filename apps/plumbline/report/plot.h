// Plots as files, drawn by gnuplot: SVG for papers and pages, PNG for the rest.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plumbline::app {

/// `bars` are as wide as the smallest distance of their x; several series of bars in a panel share that place side by
/// side.
enum class Mark { line, dashed, points, line_points, steps, bars };

struct Series {
  std::string name = {};  ///< in the key; empty = not there
  /// As many of both. A value that is not finite (or not positive on a log axis) is left out and breaks the line, so
  /// that one series can hold many separate strokes.
  std::vector<double> x = {}, y = {};
  Mark mark = Mark::line;
  std::string color = {};  ///< "#rrggbb"; empty = the next of the palette
  double width = 1.5;      ///< of the line, or the size of the points; pixels
};

struct Axis {
  std::string label = {};
  std::optional<double> low = {}, high = {};  ///< empty = as the data need it
  bool log = false;
  std::vector<std::pair<double, std::string>> ticks = {};  ///< empty = numbers
};

struct Panel {
  std::string title = {};
  Axis x = {}, y = {};
  std::vector<Series> series = {};
  bool equal_scale = false;  ///< a metre along x is as long as one along y: maps
};

struct Plot {
  std::string title = {};
  std::vector<Panel> panels = {};             ///< row by row
  int columns = 1;                            ///< of panels
  int panel_width = 720, panel_height = 360;  ///< pixels of the SVG; a PNG has twice as many
};

/// Series of more points are thinned to about so many: of each run of points the smallest and the largest y stay.
constexpr std::size_t kMaxPlotPoints = 8000;

/// "#rrggbb" of the palette, which begins again after its last.
std::string plot_color(std::size_t index);

/// Throws Error if `path` does not end in .svg or .png, or there is no gnuplot: before a long run, not after it.
void check_plot(const std::string& path);

/// Draws into `path`, whose ending chooses the format; the file appears whole or not at all. `keep_script` also leaves
/// the gnuplot script with its data beside it (the ending replaced by .gp), for those who want other fonts. Throws
/// Error as check_plot(), and for series whose x and y differ in number.
void save_plot(const Plot& plot, const std::string& path, bool keep_script = false);

}  // namespace plumbline::app
