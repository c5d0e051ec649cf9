// How the times of a frame's stages grow with the image, the volume and the threads.
#pragma once

#include <string>
#include <vector>

#include "cli/table.h"
#include "plumbline/parameters.h"
#include "report/plot.h"

namespace plumbline::app {

/// Medians of wall time over one size, all else as it is by default.
struct Growth {
  std::string name;                 ///< of its files: "image", "volume", "threads"
  std::string title;                ///< a sentence
  std::string label;                ///< of the axis
  std::vector<double> sizes;        ///< pixels, voxels, or threads
  std::vector<std::string> points;  ///< the sizes in words
  std::vector<std::string> stages;
  std::vector<std::vector<double>> milliseconds;  ///< by stage, then by size
};

/// The simulated desk at 160×120 to 1280×960 pixels, in 128³ to 768³ voxels (one thread), and with 1 to `threads`
/// threads; `seconds` for each stage of each.
std::vector<Growth> measure_growth(const Parameters& parameters, const std::string& backend, int threads,
                                   double seconds);

/// The slope of `milliseconds` over `sizes` on logarithmic axes (least squares): 1 is linear, 0 does not grow.
double exponent(const std::vector<double>& sizes, const std::vector<double>& milliseconds);

/// A row for each stage with its exponent.
Table growth_table(const Growth& growth);
/// A panel for each.
Plot growth_plot(const std::vector<Growth>& growths);

}  // namespace plumbline::app
