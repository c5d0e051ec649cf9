#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "app/arguments.h"
#include "app/bench_growth.h"
#include "app/commands.h"
#include "app/console.h"
#include "app/parameter_arguments.h"
#include "app/stages.h"
#include "io/atomic_file.h"

namespace plumbline::app {
namespace {

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

struct Row {
  Stage stage;
  std::vector<double> milliseconds;  ///< per number of threads
};

void say_table(const std::vector<Row>& rows, const std::vector<int>& threads, double bytes_per_second) {
  std::string head = fmt::format("{:<26}", "stage");
  for (const int n : threads) head += fmt::format("{:>12}", fmt::format("{} thread{}", n, n == 1 ? "" : "s"));
  say("{}{:>11}{:>10}{:>10}{:>8}", head, "ns/item", "MB", "floor", "times");
  std::vector<double> totals(threads.size(), 0);
  for (const Row& row : rows) {
    std::string line = fmt::format("{:<26}", row.stage.name);
    for (std::size_t i = 0; i < threads.size(); ++i) {
      line += fmt::format("{:>9.2f} ms", row.milliseconds[i]);
      if (row.stage.is_whole) totals[i] += row.milliseconds[i];
    }
    const double floor = 1e3 * row.stage.bytes / bytes_per_second;
    say("{}{:>11}{:>10.1f}{:>7.2f} ms{:>8.1f}", line,
        fmt::format("{:.2f}/{}", 1e6 * row.milliseconds[0] / std::max(1.0, row.stage.items), row.stage.item),
        1e-6 * row.stage.bytes, floor, row.milliseconds[0] / floor);
  }
  std::string line = fmt::format("{:<26}", "a frame");
  for (const double total : totals) line += fmt::format("{:>9.2f} ms", total);
  say(line);
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
    AtomicFile file((folder / (table.name + ".csv")).string());
    file.write(table_csv(table));
    file.commit();
  }
  if (!arguments.output.empty()) {
    save_plot(growth_plot(growths), figure);
    say("figure     {}", figure);
  }
  return 0;
}

int bench(const BenchArguments& arguments) {
  const Parameters parameters = effective_parameters(arguments.parameters);
  if (!arguments.output.empty() && !arguments.grow)
    throw UsageError("only the figure of --grow is written", "-o", "Add --grow, or leave it out.");
  if (arguments.grow) return bench_growth(arguments, parameters);
  const StageFrames frames = arguments.sequence.empty()
                                 ? simulated_frames(arguments.width, arguments.height, arguments.warm_up)
                                 : recorded_frames(arguments.sequence, arguments.warm_up);
  std::vector<int> threads = {1};
  const int all = arguments.threads > 0 ? arguments.threads : processors();
  if (all > 1) threads.push_back(all);
  std::vector<Row> rows;
  for (const int n : threads) {
    StageScene scene(frames, parameters, arguments.backend, n);
    if (n == 1)
      say("{}; {}x{}, {}^3 voxels; {}", scene.backend(), frames.camera.width, frames.camera.height,
          parameters.volume.resolution,
          arguments.sequence.empty() ? "the simulated desk" : arguments.sequence + ", first frames");
    const std::vector<Stage> stages = scene.stages();
    for (std::size_t i = 0; i < stages.size(); ++i) {
      if (n == 1) rows.push_back({stages[i], {}});
      rows[i].milliseconds.push_back(median_milliseconds(stages[i].run, arguments.seconds));
    }
  }
  const double bytes_per_second = copied_per_second(arguments.seconds);
  say_table(rows, threads, bytes_per_second);
  say("Medians of wall time. ns/item, floor and times are those of one thread: the floor is what reading and writing "
      "every\n"
      "byte once costs at the {:.1f} GB/s that one thread copies here. Arithmetic is not in it.",
      1e-9 * bytes_per_second);
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
