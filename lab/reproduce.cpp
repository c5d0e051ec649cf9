#include "lab/reproduce.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "lab/run_grid.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

/// Tables 2 to 4 of the paper, a row a sequence.
// clang-format off
const std::vector<PaperDataset> kPaperDatasets = {
    {"fr1/desk", "freiburg1_desk", {0.072962, 0.030087, 0.044159}, {0.738048, 0.74483, 0.739424}, 571, 15.9685, 26.5849, 12.8336},
    {"fr1/desk2", "freiburg1_desk2", {1.161819, 0.292637, 0.444369}, {1.287929, 0.838171, 0.869576}, 609, 16.1272, 25.8095, 14.0985},
    {"fr1/plant", "freiburg1_plant", {0.569372, 0.134107, 0.176352}, {0.706834, 0.654759, 0.632407}, 1117, 15.3648, 25.3902, 14.8845},
    {"fr1/room", "freiburg1_room", {0.533064, 0.29157, 0.369766}, {0.572936, 0.568497, 0.57648}, 1351, 15.7780, 25.6922, 13.8342},
    {"fr1/rpy", "freiburg1_rpy", {0.143752, 0.02627, 0.039267}, {0.189792, 0.147253, 0.155186}, 689, 15.4078, 25.8273, 12.8984},
    {"fr1/teddy", "freiburg1_teddy", {0.771908, 0.032981, 0.136453}, {1.107038, 0.562483, 0.551832}, 1398, 15.3767, 25.1314, 13.0594},
    {"fr1/xyz", "freiburg1_xyz", {0.02201, 0.017639, 0.031814}, {0.471017, 0.455407, 0.44321}, 789, 15.7567, 26.3536, 13.0849},
    {"fr2/desk", "freiburg2_desk", {1.398591, 1.086605, 1.106806}, {0.513134, 0.325256, 0.411005}, 2173, 15.6567, 25.7899, 14.4160},
    {"fr2/dishes", "freiburg2_dishes", {1.117713, 0.26825, 0.619345}, {0.39359, 0.239472, 0.323013}, 2940, 15.2580, 25.0826, 14.2199},
    {"fr2/ms2", "freiburg2_metallic_sphere2", {1.126076, 0.140761, 0.142085}, {0.426254, 0.321132, 0.329455}, 1834, 15.5649, 25.5104, 13.0987},
    {"fr3/teddy", "freiburg3_teddy", {0.396014, 0.097218, 0.292001}, {0.430286, 0.392398, 0.397371}, 2322, 15.5526, 25.2669, 12.7461},
};
// clang-format on

namespace fs = std::filesystem;

std::string absolute_path(const fs::path& path) { return fs::absolute(path).lexically_normal().string(); }

/// A recording of the dataset, and what to add to its name; its first frames serve too.
std::optional<std::pair<fs::path, std::string>> recording(const fs::path& data, const std::string& stem) {
  for (const fs::path& folder : {data / "tum", data})
    for (const auto& [suffix, words] : {std::pair("", ""), std::pair("_head", " (beginning)")}) {
      const fs::path path = folder / ("rgbd_dataset_" + stem + suffix);
      if (fs::exists(path / "depth.txt")) return std::pair<fs::path, std::string>(path, words);
    }
  return std::nullopt;
}

DatasetSource simulated(const ReproduceOptions& options, const PaperDataset& dataset, const fs::path& trajectory,
                        const std::string& scene, double speed, int frames) {
  DatasetSource source;
  source.paper = &dataset;
  const std::string fast = speed == 1 ? "" : fmt::format("-speed{:g}", speed);
  source.name = fmt::format("{} ({}{})", dataset.name, scene, speed == 1 ? "" : fmt::format(", {:g}×", speed));
  source.key = fmt::format("{}-{}{}-{}", scene, dataset.stem, fast, frames);
  source.folder = absolute_path(fs::path(options.output) / "sequences" / source.key);
  Run run{source.key, source.folder, {}, options.incidental};
  run.arguments = {"simulate",
                   "-o",
                   source.folder,
                   "--scene",
                   scene,
                   "--trajectory",
                   absolute_path(trajectory),
                   "--speed",
                   fmt::format("{:g}", speed),
                   "--frames",
                   std::to_string(frames),
                   "--no-color"};
  source.simulate = run;
  return source;
}

bool is_wanted(const ReproduceOptions& options, const PaperDataset& dataset) {
  return options.datasets.empty() ||
         std::find(options.datasets.begin(), options.datasets.end(), dataset.name) != options.datasets.end();
}

}  // namespace

ReproduceOptions reduced(ReproduceOptions options) {
  if (options.datasets.empty()) options.datasets = {"fr1/desk", "fr1/rpy", "fr1/xyz"};
  options.scenes = {"desk"};
  options.speeds = {1};
  options.sensors = {"ideal"};
  options.frames = 80;
  options.timed_frames = 50;
  options.seeds = 2;
  options.pairs = 10;
  return options;
}

const std::vector<PaperDataset>& paper_datasets() { return kPaperDatasets; }

std::vector<DatasetSource> dataset_sources(const ReproduceOptions& options, int frames) {
  std::vector<DatasetSource> sources;
  const fs::path data(options.data);
  for (const PaperDataset& dataset : paper_datasets()) {
    if (!is_wanted(options, dataset)) continue;
    const fs::path trajectory = data / "trajectories" / "groundtruth" / (dataset.stem + std::string(".txt"));
    if (const auto found = recording(data, dataset.stem)) {
      sources.push_back({&dataset, dataset.name + found->second, fmt::format("{}-{}", dataset.stem, frames),
                         absolute_path(found->first), std::nullopt, 1});
    } else if (fs::exists(trajectory)) {
      for (const std::string& scene : options.scenes)
        for (const double speed : options.speeds)
          sources.push_back(simulated(options, dataset, trajectory, scene, speed, frames));
    }
  }
  if (sources.empty())
    throw Error("there is neither a recording (rgbd_dataset_freiburg1_…) nor a path (trajectories/groundtruth)",
                options.data.empty() ? "--data" : options.data,
                "Give the folder of the TUM RGB-D sequences with --data.");
  return sources;
}

DatasetSource thinned(DatasetSource source, int stride) {
  if (stride == 1) return source;
  source.stride = stride;
  source.name += fmt::format(", every {}{} frame", stride, stride == 2 ? "nd" : stride == 3 ? "rd" : "th");
  source.key += fmt::format("-stride{}", stride);
  return source;
}

std::vector<int> seeds_of(const std::string& sensor, int seeds) {
  std::vector<int> list(sensor == "none" || sensor == "ideal" ? 1U : static_cast<std::size_t>(seeds));
  std::iota(list.begin(), list.end(), 1);
  return list;
}

std::vector<std::string> volume_arguments(const std::string& preset) {
  if (preset == "plumbline") return {};
  return {"--set", "volume.side=6", "--set", "volume.offset=-0.4"};
}

namespace {

std::vector<std::string> orientation_arguments(const DatasetSource& source, const Setup& setup, int seed) {
  if (setup.sensor == "none") return {"--orientation", "none"};
  return sensor_arguments({(fs::path(source.folder) / "groundtruth.txt").string(), setup.sensor, seed});
}

}  // namespace

Run run_of(const ReproduceOptions& options, const DatasetSource& source, const Setup& setup, int seed, int frames) {
  Run run;
  run.name = fmt::format("{}-{}{}-{}-{}", source.key, setup.preset, setup.label.empty() ? "" : "-" + setup.label,
                         setup.sensor, seed);
  run.folder = absolute_path(fs::path(options.output) / "runs" / run.name);
  run.incidental = options.incidental;
  run.arguments = {"run",          source.folder,         "-o", run.folder, "--preset", setup.preset, "--no-mesh",
                   "--max-frames", std::to_string(frames)};
  const auto append = [&](const std::vector<std::string>& words) {
    run.arguments.insert(run.arguments.end(), words.begin(), words.end());
  };
  if (source.stride != 1) append({"--stride", std::to_string(source.stride)});
  append(volume_arguments(setup.preset));
  for (const std::string& setting : setup.settings) append({"--set", setting});
  append(orientation_arguments(source, setup, seed));
  return run;
}

std::optional<RunFigures> figures_if_finished(const Run& run) {
  if (outcome_of(run).status != RunStatus::finished) return std::nullopt;
  try {
    return run_figures(run.folder);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<double> mean_of(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::optional<double> mean_if_complete(const std::vector<std::optional<double>>& values) {
  std::vector<double> known;
  for (const auto& value : values) {
    if (!value) return std::nullopt;
    known.push_back(*value);
  }
  return mean_of(known);
}

}  // namespace plumbline::app
