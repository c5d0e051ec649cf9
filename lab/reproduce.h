// The tables and figures of the paper (Giancola, Schneider, Wonka, Ghanem 2018), each as a plan: which sequences and
// runs it needs, and what it makes of them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/table.h"
#include "lab/run_list.h"
#include "report/plot.h"
#include "run/run_figures.h"

namespace plumbline::app {

struct ReproduceOptions {
  std::string data, output;           ///< folders; `data` may be empty
  std::vector<std::string> datasets;  ///< of the paper's, by name; empty = all
  std::vector<std::string> scenes = {"desk", "room"};
  std::vector<double> speeds = {1};
  std::vector<double> angles = {5, 10, 15, 20, 25, 30, 40, 50, 60};  ///< degrees
  /// pan: as in the paper, where nothing is left in common at 60°, a little more than such a camera sees across; or
  /// any.
  std::string turn_axis = "pan";
  std::vector<std::string> sensors = {"ideal", "bno055"};  ///< of the λ table
  std::vector<int> strides = {1};                          ///< of the ATE table: every so manieth frame
  int frames = 300, timed_frames = 300;                    ///< of a sequence, 0 = all
  int seeds = 5;                                           ///< of the sensor's error
  int pairs = 20;                                          ///< of frames, for each scene and angle
  std::vector<std::string> incidental;                     ///< arguments of every run
};

/// What fits in a quarter of an hour on two processors.
ReproduceOptions reduced(ReproduceOptions options);

/// A dataset of the paper's tables, with its figures.
struct PaperDataset {
  const char *name, *stem;                 ///< "fr1/desk", "freiburg1_desk"
  double ate[3], rpe[3];                   ///< metres: original, with IMU, with IMU and its error
  int frames;                              ///< of the time table
  double original_ms, fixed_ms, until_ms;  ///< means
};
const std::vector<PaperDataset>& paper_datasets();

/// Where a dataset comes from here: recorded, or the recorded path through a simulated scene.
struct DatasetSource {
  const PaperDataset* paper;
  std::string name;             ///< "fr1/desk", with the scene where it is simulated
  std::string key;              ///< in names of folders
  std::string folder;           ///< of the sequence
  std::optional<Run> simulate;  ///< makes it
  int stride = 1;               ///< every so manieth frame is taken
};

/// What `options.data` has of the wanted datasets, in the paper's order. Throws Error if there is none.
std::vector<DatasetSource> dataset_sources(const ReproduceOptions& options, int frames);

/// The same with every `stride`th frame.
DatasetSource thinned(DatasetSource source, int stride);

/// A preset with an orientation: "none", or the ground truth's with an error model.
struct Setup {
  std::string preset, sensor;
  std::vector<std::string> settings = {};  ///< on top
  std::string label = {};                  ///< of the settings, in names of folders
};

/// Seeds that a sensor is worth.
std::vector<int> seeds_of(const std::string& sensor, int seeds);
/// Where the volume stands: the paper's 6 m for the published presets (docs/method.md §6.5), its own for `plumbline`.
std::vector<std::string> volume_arguments(const std::string& preset);
Run run_of(const ReproduceOptions& options, const DatasetSource& source, const Setup& setup, int seed, int frames);

/// Figures of a run that is finished.
std::optional<RunFigures> figures_if_finished(const Run& run);

std::optional<double> mean_of(const std::vector<double>& values);
/// Of what is known; none if one is not, so that what is hard is never left out of a mean.
std::optional<double> mean_if_complete(const std::vector<std::optional<double>>& values);

struct ReproduceResult {
  std::vector<Table> tables;
  std::vector<std::pair<std::string, Plot>> plots;  ///< by name of the file, without its ending
};

struct Plan {
  std::vector<Run> sequences;  ///< come first,
  std::vector<Run> runs;       ///< then these side by side,
  std::vector<Run> timed;      ///< then these one at a time, for their times are what is wanted
  std::function<ReproduceResult()> result;
};

Plan plan_angles(const ReproduceOptions& options);
Plan plan_lambda(const ReproduceOptions& options);
Plan plan_timing(const ReproduceOptions& options);
Plan plan_iterations(const ReproduceOptions& options);
Plan plan_ate(const ReproduceOptions& options);
Plan plan_uncertainty(const ReproduceOptions& options);

}  // namespace plumbline::app
