#include "plumbline/parameters.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "plumbline/error.h"

namespace plumbline {

namespace {

/// docs/method.md §1: KinectFusion as published (Newcombe et al. 2011), without a sensor.
Parameters kinectfusion() {
  Parameters p;
  p.preprocess.calibrate_depth = false;
  p.preprocess.bilateral = true;
  p.tracking.finest_level = 0;
  p.tracking.gate_per_median = 0;
  p.tracking.normal_gate = 20;
  p.tracking.depth_weights = false;
  p.tracking.huber = 0;
  p.tracking.redundancy = 1;
  p.tracking.iterations = {4, 5, 10};
  p.tracking.converged_step = 0;
  p.tracking.min_inlier_fraction = 0.10;
  p.tracking.min_matched = 0;
  p.tracking.search = 0;
  p.tracking.speed_sigma = 0;
  p.tracking.speed_memory = 0;
  p.tracking.relocalise_after = 0;
  p.orientation.seed = OrientationSeed::none;
  p.orientation.term = OrientationTerm::none;
  p.orientation.search = 0;
  p.motion.steady = false;
  p.motion.gyroscope = false;
  p.volume.side = 3;
  p.volume.placement = VolumePlacement::front;
  p.volume.offset = -0.1;
  p.volume.truncation = 0.03;
  return p;
}

/// As published (Giancola et al. 2018): docs/method.md §2 to §4 on top of the baseline. The wider gate is for the
/// median filter to narrow.
Parameters paper() {
  Parameters p = kinectfusion();
  p.tracking.distance_gate = 0.50;
  p.tracking.median_filter = true;
  p.tracking.converged_after = 3;
  p.orientation.seed = OrientationSeed::absolute;
  p.orientation.term = OrientationTerm::damping;
  p.orientation.schedule = LambdaSchedule::inverse_sqrt;
  p.orientation.lambda = 2;
  p.orientation.distrust = 0;
  return p;
}

struct Preset {
  const char* name;
  Parameters (*make)();
};
constexpr Preset kPresets[] = {
    {"plumbline", [] { return Parameters(); }}, {"paper", paper}, {"kinectfusion", kinectfusion}};

struct Quality {
  const char* name;
  void (*apply)(Parameters*);
};
constexpr Quality kQualities[] = {{"fast",
                                   [](Parameters* p) {
                                     p->tracking.iterations = {2, 3};
                                     p->tracking.finest_level = 2;
                                     p->volume.resolution = 384;
                                   }},
                                  {"balanced", [](Parameters*) {}},
                                  {"best", [](Parameters* p) {
                                     p->tracking.converged_step = 0.00025;
                                     p->tracking.max_iterations = 20;
                                     p->volume.resolution = 768;
                                   }}};

template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& known : table) names.emplace_back(known.name);
  return names;
}

/// The entry of `table` with that name. Throws Error naming the known ones.
template <class Table>
const auto& find_named(const Table& table, const char* noun, std::string_view name) {
  for (const auto& known : table) {
    if (name == known.name) return known;
  }
  throw Error(fmt::format("there is no such {}", noun), fmt::format("{} '{}'", noun, name),
              fmt::format("Choose one of: {}.", fmt::join(names_of(table), ", ")));
}

}  // namespace

Parameters preset(std::string_view name) { return find_named(kPresets, "preset", name).make(); }
std::vector<std::string> preset_names() { return names_of(kPresets); }

void apply_quality(std::string_view name, Parameters* parameters) {
  find_named(kQualities, "quality", name).apply(parameters);
}
std::vector<std::string> quality_names() { return names_of(kQualities); }

}  // namespace plumbline
