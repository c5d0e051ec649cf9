#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/parameter_arguments.h"
#include "io/atomic_file.h"
#include "lab/bench_growth.h"
#include "lab/run_times.h"
#include "lab/stages.h"

namespace plumbline::app {
namespace {

constexpr double kRunStages = 4;  // that share a run's time

struct BenchArguments {
  ParameterArguments parameters;
  std::string sequence, backend = "auto";
  int threads = 0, width = 640, height = 480, warm_up = 20;
  double seconds = 0.5;
  bool grow = false;
  std::string output;
};

/// What one thread copies in memory too large for any cache, bytes read and written per second.
double copied_per_second(double seconds) {
  constexpr std::size_t kBytes = std::size_t{128} << 20;
  std::vector<char> from(kBytes, 1), to(kBytes, 2);
  const double ms = median_milliseconds([&] { std::memcpy(to.data(), from.data(), kBytes); }, seconds);
  return 2 * static_cast<double>(kBytes) / (1e-3 * ms);
}

/// What a device writes to memory too large for any cache, bytes per second.
double written_per_second(const Backend& backend, double seconds) {
  constexpr std::size_t kBytes = std::size_t{1} << 30;
  const DeviceArray<std::byte> memory(backend, kBytes);
  const double ms = median_of([&] { return backend.milliseconds([&] { memory.clear(backend); }); }, seconds);
  return static_cast<double>(kBytes) / (1e-3 * ms);
}

struct Row {
  Stage stage;
  std::vector<double> milliseconds;  ///< per column
};

struct StageTable {
  std::vector<std::string> columns;
  std::vector<Row> rows;
  std::size_t judged = 0;  ///< the column that is compared with the floor
  double bytes_per_second = 0;
};

std::string times_text(const std::string& name, const std::vector<double>& milliseconds) {
  std::string line = fmt::format("{:<26}", name);
  for (const double time : milliseconds) line += fmt::format("{:>10.3f} ms", time);
  return line;
}

void say_table(const StageTable& table) {
  std::string head = fmt::format("{:<26}", "stage");
  for (const std::string& column : table.columns) head += fmt::format("{:>13}", column);
  say("{}{:>11}{:>10}{:>11}{:>8}", head, "ns/item", "MB", "floor", "times");
  std::vector<double> totals(table.columns.size(), 0);
  for (const Row& row : table.rows) {
    for (std::size_t i = 0; row.stage.is_whole && i < totals.size(); ++i) totals[i] += row.milliseconds[i];
    const double floor = 1e3 * row.stage.bytes / table.bytes_per_second, judged = row.milliseconds[table.judged];
    say("{}{:>11}{:>10.1f}{:>8.3f} ms{:>8.1f}", times_text(row.stage.name, row.milliseconds),
        fmt::format("{:.2f}/{}", 1e6 * judged / std::max(1.0, row.stage.items), row.stage.item), 1e-6 * row.stage.bytes,
        floor, judged / floor);
  }
  say(times_text("sum of the stages", totals));
}

int processors() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

/// Tables, and a folder with their CSV and the figure if one is asked for.
int bench_growth(const BenchArguments& arguments, const Parameters& parameters) {
  const std::filesystem::path folder = arguments.output;
  const std::string figure = (folder / "growth.svg").string();
  if (!arguments.output.empty()) {
    check_plot(figure);
    ensure_directory(arguments.output);
  }
  const int threads = arguments.threads > 0 ? arguments.threads : processors();
  const std::vector<Growth> growths = measure_growth(parameters, arguments.backend, threads, arguments.seconds);
  for (const Growth& growth : growths) {
    const Table table = growth_table(growth);
    say("{}\n{}", table.title, table_text(table));
    if (arguments.output.empty()) continue;
    write_file((folder / (table.name + ".csv")).string(), table_csv(table));
  }
  if (!arguments.output.empty()) {
    save_plot(growth_plot(growths), figure);
    say("figure     {}", figure);
  }
  return 0;
}

using Head = std::function<void(const Backend&)>;

/// Wall times with one thread and with all: the stages as a run has them, their parts on one frame again and again.
void bench_threads(const BenchArguments& arguments, const Parameters& parameters, const StageFrames& frames,
                   const Head& say_head) {
  std::vector<int> threads = {1};
  const int all = arguments.threads > 0 ? arguments.threads : processors();
  if (all > 1) threads.push_back(all);
  StageTable table;
  for (const int n : threads) {
    StageScene scene(frames, parameters, arguments.backend, n);
    if (n == 1) say_head(scene.backend());
    table.columns.push_back(fmt::format("{} thread{}", n, n == 1 ? "" : "s"));
    const std::vector<Stage> stages = scene.stages();
    const StageTimes times = run_stage_times(frames, parameters, arguments.backend, n, kRunStages * arguments.seconds);
    for (std::size_t i = 0; i < stages.size(); ++i) {
      if (n == 1) table.rows.push_back({stages[i], {}});
      table.rows[i].milliseconds.push_back(stages[i].is_whole ? milliseconds_of(times, stages[i].name)
                                                              : scene.wall(stages[i], arguments.seconds));
    }
  }
  table.bytes_per_second = copied_per_second(arguments.seconds);
  say_table(table);
  say("Medians of wall time: of the stages in a run over these frames to and fro, of their parts (indented) on the "
      "final "
      "frame. ns/item, floor and times are those of one thread: the floor is what reading and writing "
      "every\n"
      "byte once costs at the {:.1f} GB/s that one thread copies here. Arithmetic is not in it.",
      1e-9 * table.bytes_per_second);
}

/// By the host's clock and by the device's.
void bench_device(const BenchArguments& arguments, const Parameters& parameters, const StageFrames& frames,
                  const Head& say_head) {
  StageScene scene(frames, parameters, arguments.backend, 1);
  say_head(scene.backend());
  StageTable table{{"wall", "device"}, {}, 1, written_per_second(scene.backend(), arguments.seconds)};
  std::vector<Stage> stages = scene.stages();
  stages.push_back(scene.frame(stages));
  for (const Stage& stage : stages) {
    table.rows.push_back({stage, {scene.wall(stage, arguments.seconds), scene.device(stage, arguments.seconds)}});
  }
  say_table(table);
  say("Medians: wall time until the device is through, and the device's own time by its events. ns/item, floor and "
      "times are\n"
      "those of the device: the floor is what every byte costs once at the {:.0f} GB/s that clearing memory writes.",
      1e-9 * table.bytes_per_second);
}

StageFrames frames_of(const BenchArguments& arguments) {
  if (arguments.sequence.empty()) return simulated_frames(arguments.width, arguments.height, arguments.warm_up);
  return recorded_frames(arguments.sequence, arguments.warm_up);
}

int bench(const BenchArguments& arguments) {
  const Parameters parameters = effective_parameters(arguments.parameters);
  if (!arguments.output.empty() && !arguments.grow)
    throw UsageError("only the figure of --grow is written", "-o", "Add --grow, or leave it out.");
  if (arguments.grow) return bench_growth(arguments, parameters);
  const StageFrames frames = frames_of(arguments);
  const auto say_head = [&](const Backend& backend) {
    say("{}; {}x{}, {}^3 voxels; {}", backend.description(), frames.camera.width, frames.camera.height,
        parameters.volume.resolution,
        arguments.sequence.empty() ? "the simulated desk" : arguments.sequence + ", first frames");
  };
  if (make_backend(arguments.backend, 1)->name() == "cpu")
    bench_threads(arguments, parameters, frames, say_head);
  else
    bench_device(arguments, parameters, frames, say_head);
  return 0;
}

}  // namespace

void add_bench_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<BenchArguments>();
  CLI::App* command = app.add_subcommand("bench", "Time every stage of a frame on this machine");
  command->add_option("SEQUENCE", arguments->sequence, "Folder of a sequence (default: a simulated desk)");
  add_parameter_arguments(*command, arguments->parameters);
  command->add_option("--backend", arguments->backend, "Where to compute; cpu:avx2+fma chooses the instruction set")
      ->capture_default_str()
      ->type_name("NAME");
  command->add_option("--threads", arguments->threads, "CPU threads beside 1, 0 for all")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str()
      ->type_name("N");
  command->add_option("--width", arguments->width, "Of the simulated image")
      ->check(CLI::Range(80, 4096))
      ->capture_default_str()
      ->type_name("PX");
  command->add_option("--height", arguments->height, "Of the simulated image")
      ->check(CLI::Range(60, 4096))
      ->capture_default_str()
      ->type_name("PX");
  command->add_option("--warm-up", arguments->warm_up, "Frames fused before the one that is timed")
      ->check(CLI::Range(1, 200))
      ->capture_default_str()
      ->type_name("N");
  command->add_option("--seconds", arguments->seconds, "Time for each stage")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str()
      ->type_name("S");
  command->add_flag("--grow", arguments->grow,
                    "How the times grow with the image, the volume and the threads, on the simulated desk");
  command->add_option("-o,--output", arguments->output, "Folder for --grow's tables and figure")->type_name("DIR");
  command->callback([arguments, &chosen] { chosen = [arguments] { return bench(*arguments); }; });
}

}  // namespace plumbline::app
