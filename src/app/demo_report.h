// report.html of the demo: one page that needs nothing beside itself.
#pragma once

#include <string>

#include "app/reconstruction.h"
#include "eval/statistics.h"

namespace plumbline::app {

struct DemoResult {
  const Reconstruction& run;
  eval::Statistics surface;  ///< metres, the mesh's vertices to the scene's true surfaces
  std::string picture_png;   ///< bytes of the mesh's picture
  std::string error_png;     ///< bytes of the picture of the mesh painted by its error, red from 2 cm
  std::string fast_motion;   ///< what came of the same path played fast, in a sentence
};

/// Whether the demo shows what it should, in one sentence.
std::string verdict(const DemoResult& result);

/// The whole page.
std::string report_html(const DemoResult& result);

}  // namespace plumbline::app
