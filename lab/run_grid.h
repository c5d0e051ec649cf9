// A grid of reconstructions: every sequence with every preset, setting, orientation, …
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "lab/run_list.h"

namespace plumbline::app {

/// Values of one key in turn: "orientation.lambda", {"0.2", "1"}.
using Variation = std::pair<std::string, std::vector<std::string>>;

/// An orientation sensor of a run; without a file there is none.
struct RunSensor {
  std::string file;   ///< its readings
  std::string model;  ///< error model that is added, or empty
  int seed = 1;       ///< of the model
};

struct Grid {
  std::vector<std::string> sequences;  ///< folders
  std::vector<std::string> presets = {"plumbline"};
  std::vector<Variation> variations;
  std::vector<std::string> orientations = {
      "none"};                                 ///< "none", or a file; a relative one lies in the sequence's folder
  std::vector<std::string> imu_models = {""};  ///< added to each file; empty = none
  int seeds = 1;                               ///< 1 to this, of models that have an error
  std::vector<int> strides = {1};
  std::vector<std::string> arguments;   ///< of `plumbline run`, for all
  std::vector<std::string> incidental;  ///< same, without influence on the result
};

/// Splits "a,b,[1,2]" at the commas outside of brackets.
std::vector<std::string> split_values(const std::string& text);

/// "KEY=V1,V2,…". Throws UsageError for text of another form.
Variation parse_variation(const std::string& text);

/// Names that tell the sequences apart: the last part of the path, with those before it where they are needed.
std::vector<std::string> sequence_names(const std::vector<std::string>& paths);

/// Options of `plumbline run` and `angles` for a sensor. A ground truth has gaps of tracking, so half a second is
/// bridged.
std::vector<std::string> sensor_arguments(const RunSensor& sensor);

/// A run in its folder below `output`. The name holds what the run was given, so that a grid may grow and keep what is
/// finished. Throws UsageError for values that are none, and where nothing but the order of two runs differs.
std::vector<Run> runs_of(const Grid& grid, const std::string& output);

}  // namespace plumbline::app
