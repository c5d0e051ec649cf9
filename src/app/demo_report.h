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
};

/// Whether the demo shows what it should, in one sentence.
std::string verdict(const DemoResult& result);

/// The whole page.
std::string report_html(const DemoResult& result);

}  // namespace plumbline::app
