#include "report/plot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

#include "io/atomic_file.h"
#include "plumbline/error.h"

extern char** environ;

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr double kHuge = std::numeric_limits<double>::infinity();

/// Distinct in print and for colour-blind eyes (after Okabe and Ito).
constexpr std::array<const char*, 7> kPalette = {"#2a78c4", "#d55e00", "#2e9e6b", "#b8519c",
                                                 "#e0a100", "#6b6b6b", "#56b4e9"};

// ---- the script

/// A string as gnuplot reads it literally.
std::string gnuplot_string(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return result + "'";
}

struct Point {
  double x, y;
};

/// What can be drawn on these axes; the rest are gaps.
std::vector<Point> drawable(const Series& series, const Panel& panel) {
  std::vector<Point> points;
  points.reserve(series.x.size());
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const double x = series.x[i], y = series.y[i];
    const bool good = std::isfinite(x) && std::isfinite(y) && (!panel.x.log || x > 0) && (!panel.y.log || y > 0);
    points.push_back(good ? Point{x, y} : Point{kNoValue, kNoValue});
  }
  return points;
}

/// Extremes of y per run of points, in their order: peaks survive, which every n-th point would lose.
std::vector<Point> thinned(const std::vector<Point>& points) {
  if (points.size() <= kMaxPlotPoints) return points;
  const std::size_t run = 2 * points.size() / kMaxPlotPoints + 1;
  std::vector<Point> kept;
  for (std::size_t begin = 0; begin < points.size(); begin += run) {
    const std::size_t end = std::min(points.size(), begin + run);
    std::size_t low = end, high = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (std::isnan(points[i].y)) continue;
      if (low == end || points[i].y < points[low].y) low = i;
      if (high == end || points[i].y > points[high].y) high = i;
    }
    if (low == end) {
      kept.push_back({kNoValue, kNoValue});
    } else {
      kept.push_back(points[std::min(low, high)]);
      if (low != high) kept.push_back(points[std::max(low, high)]);
    }
  }
  return kept;
}

/// Width of one bar, and how far the first series' bars stand from their x.
struct BarPlace {
  double width = 1, first = 0;
};

BarPlace bar_place(const Panel& panel) {
  std::vector<double> xs;
  int count = 0;
  for (const Series& series : panel.series) {
    if (series.mark != Mark::bars) continue;
    ++count;
    std::copy_if(series.x.begin(), series.x.end(), std::back_inserter(xs), [](double x) { return std::isfinite(x); });
  }
  std::sort(xs.begin(), xs.end());
  xs.erase(std::unique(xs.begin(), xs.end()), xs.end());
  double spacing = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < xs.size(); ++i) spacing = std::min(spacing, xs[i] - xs[i - 1]);
  if (!std::isfinite(spacing)) spacing = 1;
  if (count <= 1) return {spacing, 0};
  const double width = 0.8 * spacing / count;
  return {width, -0.5 * width * (count - 1)};
}

std::string style_text(const Series& series, double bar_width, const std::string& color) {
  const std::string paint = fmt::format("lc rgb '{}'", color);
  const std::string line = fmt::format("{} lw {:g}", paint, series.width);
  const double point_size = 0.25 * series.width;
  switch (series.mark) {
    case Mark::line:
      return "with lines dt solid " + line;
    case Mark::dashed:
      return "with lines dt (8,6) " + line;
    case Mark::steps:
      return "with steps dt solid " + line;
    case Mark::points:
      return fmt::format("with points pt 7 ps {:g} {}", point_size, paint);
    case Mark::line_points:
      return fmt::format("with linespoints dt solid pt 7 ps {:g} {}", 2 * point_size, line);
    case Mark::bars:
      return fmt::format("using 1:2:({:.17g}) with boxes fill solid 0.75 noborder {}", bar_width, paint);
  }
  return "";
}

/// "$name << EOD … EOD". A blank line ends a stroke.
std::string data_block(const std::string& name, const std::vector<Point>& points, double shift) {
  std::string text = fmt::format("${} << EOD\n", name);
  for (const Point& p : points) text += std::isnan(p.y) ? "\n" : fmt::format("{:.10g} {:.10g}\n", p.x + shift, p.y);
  return text + "EOD\n";
}

/// `low`: where the axis begins unless it says so itself.
std::string axis_text(const char* name, const Axis& axis, const char* low, const char* high) {
  std::string text = fmt::format("set {}label {} noenhanced\n", name, gnuplot_string(axis.label));
  const auto bound = [&](const std::optional<double>& value, const char* otherwise) {
    return value ? fmt::format("{:.17g}", *value) : otherwise;
  };
  text += fmt::format("set {}range [{}:{}]\n", name, bound(axis.low, low), bound(axis.high, high));
  if (axis.log) text += fmt::format("set logscale {}\n", name);
  if (!axis.ticks.empty()) {
    text += fmt::format("set {}tics noenhanced (", name);
    for (std::size_t i = 0; i < axis.ticks.size(); ++i)
      text += fmt::format("{}{} {:.17g}", i > 0 ? ", " : "", gnuplot_string(axis.ticks[i].second), axis.ticks[i].first);
    text += ")\n";
  }
  return text;
}

/// The panel with both axes as long as its map and its shape ask for: gnuplot alone would make it narrow, with its
/// ticks crowded.
Panel fitted_map(Panel panel, double width_per_height) {
  const bool fixed = panel.x.low || panel.x.high || panel.y.low || panel.y.high;
  double low[2] = {kHuge, kHuge}, high[2] = {-kHuge, -kHuge};
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      const double p[2] = {series.x[i], series.y[i]};
      if (!std::isfinite(p[0]) || !std::isfinite(p[1])) continue;
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], p[axis]);
        high[axis] = std::max(high[axis], p[axis]);
      }
    }
  }
  if (fixed || high[0] < low[0]) return panel;
  constexpr double kMargin = 1.05;
  const double height = kMargin * std::max({high[1] - low[1], (high[0] - low[0]) / width_per_height, 1e-6});
  const double size[2] = {height * width_per_height, height};
  Axis* const axes[2] = {&panel.x, &panel.y};
  for (int axis = 0; axis < 2; ++axis) {
    axes[axis]->low = (low[axis] + high[axis] - size[axis]) / 2;
    axes[axis]->high = (low[axis] + high[axis] + size[axis]) / 2;
  }
  return panel;
}

constexpr const char* kPanelLook =
    "reset\nset encoding utf8\nset border 3 lc rgb '#444444'\nset tics nomirror out scale 0.5\n"
    "set grid back lt 1 dt solid lw 0.5 lc rgb '#dddddd'\n"
    "set key outside top center horizontal reverse Left noenhanced samplen 2 width 1\nset style fill solid\n";

std::string panel_text(const Panel& panel, std::size_t index, const std::string& path) {
  const BarPlace bars = bar_place(panel);
  std::string data, curves;
  std::size_t bar_series = 0, drawn = 0, named = 0;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series& series = panel.series[i];
    if (series.x.size() != series.y.size())
      throw Error(
          fmt::format("the series '{}' has {} values of x and {} of y", series.name, series.x.size(), series.y.size()),
          path, "give as many of both");
    const double shift = series.mark == Mark::bars ? bars.first + bars.width * static_cast<double>(bar_series++) : 0;
    const std::vector<Point> points = thinned(drawable(series, panel));
    if (std::all_of(points.begin(), points.end(), [](const Point& p) { return std::isnan(p.y); })) continue;
    const std::string name = fmt::format("d{}_{}", index, i);
    data += data_block(name, points, shift);
    const std::string color = series.color.empty() ? plot_color(i) : series.color;
    curves +=
        fmt::format("{}${} {} {}", drawn++ > 0 ? ", \\\n  " : "plot ", name, style_text(series, bars.width, color),
                    series.name.empty() ? "notitle" : "title " + gnuplot_string(series.name));
    named += !series.name.empty();
  }
  std::string text = kPanelLook;
  const std::string title = panel.title + (drawn > 0 ? "" : panel.title.empty() ? "no data" : " (no data)");
  text += fmt::format("set title {} noenhanced\n", gnuplot_string(title));
  const char* foot = bar_series > 0 && !panel.y.log ? "0" : "*";  // bars stand on zero
  text += drawn > 0 ? axis_text("x", panel.x, "*", "*") + axis_text("y", panel.y, foot, "*")
                    : axis_text("x", panel.x, "1", "2") + axis_text("y", panel.y, "1", "2");
  if (panel.equal_scale) text += "set size ratio -1\n";
  if (named == 0) text += "unset key\n";
  return text + data + (drawn > 0 ? curves : "plot NaN notitle") + "\n";
}

bool is_png(const std::string& path) { return fs::path(path).extension() == ".png"; }

/// `set terminal` and the panels; the output is gnuplot's standard output unless a script sets it.
std::string terminal_text(const Plot& plot, const std::string& path, int rows) {
  const int title_height = plot.title.empty() ? 0 : 30;
  const int width = plot.columns * plot.panel_width, height = rows * plot.panel_height + title_height;
  if (is_png(path))
    return fmt::format(
        "set terminal pngcairo noenhanced size {},{} fontscale 2 linewidth 2 pointscale 2 font 'sans,9' background "
        "'white'\n",
        2 * width, 2 * height);
  return fmt::format("set terminal svg noenhanced size {},{} fixed font 'sans-serif,12' background 'white'\n", width,
                     height);
}

std::string body_text(const Plot& plot, const std::string& path, int rows) {
  std::string text = "set encoding utf8\n";
  text += fmt::format("set multiplot layout {},{}", rows, plot.columns);
  if (!plot.title.empty()) text += fmt::format(" title {} noenhanced", gnuplot_string(plot.title));
  text += "\n";
  // What labels and key leave of a panel, about.
  const double shape = (plot.panel_width - 90.0) / std::max(1.0, plot.panel_height - 90.0);
  for (std::size_t i = 0; i < plot.panels.size(); ++i) {
    const Panel& panel = plot.panels[i];
    text += panel_text(panel.equal_scale ? fitted_map(panel, shape) : panel, i, path);
  }
  return text + "unset multiplot\n";
}

// ---- gnuplot

/// A nameless file in memory: nothing to clean up, and a child's pipes cannot block each other.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : fd_(memfd_create(name, MFD_CLOEXEC)) {
    if (fd_ < 0)
      throw Error(std::string("no file in memory can be made: ") + std::strerror(errno), "plot", "free some memory");
  }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int fd() const { return fd_; }
  void fill(const std::string& text, const std::string& path) const {
    write_fully(fd_, text, path);
    lseek(fd_, 0, SEEK_SET);
  }
  std::string read_all() const {
    std::string bytes(static_cast<std::size_t>(std::max<off_t>(0, lseek(fd_, 0, SEEK_END))), '\0');
    std::size_t size = 0;
    while (size < bytes.size()) {
      const ssize_t n = pread(fd_, bytes.data() + size, bytes.size() - size, static_cast<off_t>(size));
      if (n <= 0) break;
      size += static_cast<std::size_t>(n);
    }
    bytes.resize(size);
    return bytes;
  }

 private:
  int fd_;
};

[[noreturn]] void throw_cannot_start(const std::string& path, int error) {
  if (error == ENOENT)
    throw Error("gnuplot, which draws the plots, is not installed", path, "Install it: apt-get install gnuplot-nox");
  throw Error(std::string("gnuplot cannot be started: ") + std::strerror(error), path,
              "Check that `gnuplot --version` works.");
}

struct Drawn {
  int status;
  std::string out, err;
};

/// Runs gnuplot with `arguments` over `script`.
Drawn run_gnuplot(std::vector<std::string> arguments, const std::string& script, const std::string& path) {
  const MemoryFile in("script"), out("plot"), err("messages");
  in.fill(script, path);
  arguments.insert(arguments.begin(), "gnuplot");
  std::vector<char*> words;
  for (std::string& word : arguments) words.push_back(word.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const int ends[] = {in.fd(), out.fd(), err.fd()};
  for (int to = 0; to < 3; ++to) posix_spawn_file_actions_adddup2(&actions, ends[to], to);
  pid_t pid = -1;
  const int error = posix_spawnp(&pid, "gnuplot", &actions, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw_cannot_start(path, error);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return {status, out.read_all(), err.read_all()};
}

/// The first line of gnuplot's messages that names a reason.
std::string reason_of(const std::string& messages) {
  std::size_t begin = messages.find_first_not_of(" \n\t^");
  if (begin == std::string::npos) return "it gave no reason";
  const std::size_t last = messages.find_last_not_of(" \n\t");
  const std::size_t line = messages.rfind('\n', last);
  if (line != std::string::npos && line > begin) begin = line + 1;
  return messages.substr(begin, last - begin + 1);
}

void check_ending(const std::string& path) {
  const std::string ending = fs::path(path).extension().string();
  if (ending != ".svg" && ending != ".png")
    throw Error("the kind of plot is not known from the file's name", path, "Let it end in .svg or .png.");
}

}  // namespace

std::string plot_color(std::size_t index) { return kPalette[index % kPalette.size()]; }

void check_plot(const std::string& path) {
  check_ending(path);
  if (run_gnuplot({"--version"}, "", path).status != 0) throw_cannot_start(path, EACCES);
}

void save_plot(const Plot& plot, const std::string& path, bool keep_script) {
  check_ending(path);
  if (plot.panels.empty() || plot.columns < 1) throw Error("the plot has no panels", path, "give at least one");
  const int rows = (static_cast<int>(plot.panels.size()) + plot.columns - 1) / plot.columns;
  const std::string terminal = terminal_text(plot, path, rows), body = body_text(plot, path, rows);
  // -d: the user's ~/.gnuplot must not change a figure.
  const Drawn drawn = run_gnuplot({"-d", "-"}, terminal + body, path);
  if (drawn.status != 0 || drawn.out.empty())
    throw Error("gnuplot could not draw the plot: " + reason_of(drawn.err), path,
                "Check that `gnuplot --version` says 5.4 or later.");
  write_file(path, drawn.out);
  if (!keep_script) return;
  const std::string name = fs::path(path).filename().string();
  write_file(fs::path(path).replace_extension(".gp").string(), "# gnuplot THIS_FILE draws " + name + "\n" + terminal +
                                                                   "set output " + gnuplot_string(name) + "\n" + body);
}

}  // namespace plumbline::app
