#include "app/demo_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "app/console.h"
#include "app/sequence_text.h"
#include "app/summary.h"

namespace plumbline::app {
namespace {

constexpr double kGoodTrajectory = 0.010, kGoodSurface = 0.010;  // metres

constexpr std::string_view kPage = R"html(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Plumbline demo</title>
<style>
  :root { color-scheme: light dark; }
  body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
  img, svg { width: 100%; height: auto; border-radius: 6px; }
  table { border-collapse: collapse; width: 100%; }
  th, td { text-align: left; padding: .3rem .8rem .3rem 0; border-bottom: 1px solid #8884; vertical-align: top; }
  th { font-weight: 500; white-space: nowrap; }
  .verdict { font-size: 1.15rem; }
  svg text { fill: currentColor; font-size: 12px; }
</style>
<h1>Plumbline demo</h1>
<p class="verdict">@VERDICT@</p>
<img src="data:image/png;base64,@PICTURE@" alt="The reconstructed mesh with the camera's path">
<p>@FAST@</p>
<h2>Distance to the true surface</h2>
<img src="data:image/png;base64,@ERRORS@" alt="The mesh painted by its error">
<p>Green: none. Yellow: 1 cm. Red: 2 cm and more.</p>
<h2>Figures</h2>
<table>
@ROWS@</table>
<h2>Frame by frame</h2>
@PLOTS@
</html>
)html";

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    if (c == '<')
      html += "&lt;";
    else if (c == '&')
      html += "&amp;";
    else
      html += c;
  }
  return html;
}

using Curve = std::vector<std::pair<double, double>>;

/// A line over the frame's index, from zero to the largest value.
std::string plot(const std::string& title, const std::string& unit, const Curve& curve) {
  constexpr double kWidth = 860, kHeight = 200, kLeft = 84, kTop = 38, kBottom = 24;
  double last = 1, top = 0;
  for (const auto& [x, y] : curve) {
    last = std::max(last, x);
    top = std::max(top, y);
  }
  if (top == 0) top = 1;
  std::string points;
  for (const auto& [x, y] : curve)
    points += fmt::format("{:.1f},{:.1f} ", kLeft + x / last * (kWidth - kLeft - 8),
                          kHeight - kBottom - y / top * (kHeight - kTop - kBottom));
  return fmt::format(
      R"(<svg viewBox="0 0 {w} {h}" role="img" aria-label="{title}">
<text x="0" y="14">{title}</text>
<text x="{axis}" y="{yt}" dy="4" text-anchor="end">{top:.3g} {unit}</text><text x="{axis}" y="{yb}" dy="4" text-anchor="end">0</text>
<text x="{left}" y="{h}" dy="-6">frame 0</text><text x="{w}" y="{h}" dy="-6" text-anchor="end">{last:.0f}</text>
<path d="M{left} {yb}H{w}M{left} {yt}H{w}" stroke="currentColor" stroke-opacity=".25" fill="none"/>
<polyline points="{points}" fill="none" stroke="#2a78c4" stroke-width="1.5"/>
</svg>
)",
      fmt::arg("w", kWidth), fmt::arg("h", kHeight), fmt::arg("title", title), fmt::arg("axis", kLeft - 6),
      fmt::arg("left", kLeft), fmt::arg("yt", kTop), fmt::arg("yb", kHeight - kBottom), fmt::arg("top", top),
      fmt::arg("unit", unit), fmt::arg("last", last), fmt::arg("points", points));
}

std::string plots(const Reconstruction& run) {
  std::string html;
  if (run.ate) {
    Curve error;
    for (const auto& pair : run.ate->pairs)
      error.emplace_back(static_cast<double>(pair.estimate), 1e3 * pair.translation);
    html += plot("Distance of the camera from its true position", "mm", error);
  }
  Curve inliers, time;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    const auto x = static_cast<double>(i);
    if (i > 0) inliers.emplace_back(x, 100 * run.frames[i].tracking.inlier_fraction);
    time.emplace_back(x, run.frames[i].milliseconds.total());
  }
  return html + plot("Pixels with depth that were matched", "%", inliers) + plot("Time for one frame", "ms", time);
}

std::string rows(const DemoResult& result) {
  const Reconstruction& run = result.run;
  const StageMedians ms = stage_medians(run);
  std::vector<std::pair<std::string, std::string>> table = {
      {"Frames", fmt::format("{} tracked, {} lost", run.tracked(), run.lost())},
      {"Camera", camera_text(run.sequence.camera)},
      {"Path", fmt::format("{:.2f} m", path_length(run.trajectory))}};
  if (run.ate)
    table.emplace_back(
        "Trajectory error (ATE)",
        fmt::format("{:.1f} mm rmse, {:.1f} mm median, {:.1f} mm at most", 1e3 * run.ate->translation.rmse,
                    1e3 * run.ate->translation.median, 1e3 * run.ate->translation.max));
  table.emplace_back("Surface error",
                     fmt::format("{:.1f} mm mean, {:.1f} mm median, {:.1f} mm rmse", 1e3 * result.surface.mean,
                                 1e3 * result.surface.median, 1e3 * result.surface.rmse));
  table.emplace_back("Mesh",
                     fmt::format("{} vertices, {} triangles", run.mesh.positions.size(), run.mesh.triangles.size()));
  table.emplace_back("Volume", fmt::format("{0} voxels along each side of {1:g} m", run.parameters.volume.resolution,
                                           run.parameters.volume.side));
  table.emplace_back("Time a frame (median)",
                     fmt::format("{:.1f} ms: preprocess {:.1f}, track {:.1f}, integrate {:.1f}, raycast {:.1f}",
                                 ms.total, ms.preprocess, ms.track, ms.integrate, ms.raycast));
  table.emplace_back("Computed on", run.backend);
  table.emplace_back("Memory", fmt::format("{:.0f} MiB at the peak", peak_memory_mebibytes()));
  std::string html;
  for (const auto& [name, value] : table)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(name), escaped(value));
  return html;
}

}  // namespace

std::string verdict(const DemoResult& result) {
  const Reconstruction& run = result.run;
  const bool tracked = run.lost() == 0 && run.ate;
  if (tracked && run.ate->translation.rmse <= kGoodTrajectory && result.surface.mean <= kGoodSurface)
    return fmt::format(
        "It works: all {} frames were tracked, the camera's path is within {:.1f} mm (rmse) of the truth, and the mesh "
        "lies {:.1f} mm (mean) from the true surfaces.",
        run.frames.size(), 1e3 * run.ate->translation.rmse, 1e3 * result.surface.mean);
  return fmt::format(
      "This is not as good as it should be: {} of {} frames were lost, the camera's path is {} from the truth, and the "
      "mesh lies {:.1f} mm (mean) from the true surfaces.",
      run.lost(), run.frames.size(),
      run.ate ? fmt::format("{:.1f} mm (rmse)", 1e3 * run.ate->translation.rmse) : "an unknown distance",
      1e3 * result.surface.mean);
}

std::string report_html(const DemoResult& result) {
  std::string page(kPage);
  const std::array<std::pair<std::string_view, std::string>, 6> parts = {{{"@VERDICT@", escaped(verdict(result))},
                                                                          {"@PICTURE@", base64(result.picture_png)},
                                                                          {"@FAST@", escaped(result.fast_motion)},
                                                                          {"@ERRORS@", base64(result.error_png)},
                                                                          {"@ROWS@", rows(result)},
                                                                          {"@PLOTS@", plots(result.run)}}};
  for (const auto& [mark, text] : parts) page.replace(page.find(mark), mark.size(), text);
  return page;
}

}  // namespace plumbline::app
