#include "report/report_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "cli/console.h"
#include "cli/sequence_text.h"
#include "plumbline/mesh.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "run/summary.h"

namespace plumbline::app {
namespace {

bool is_lost(const FrameReport& frame) { return frame.tracking.status == TrackingStatus::lost; }

std::string in_words(LostReason reason) {
  switch (reason) {
    case LostReason::no_depth:
      return "without enough depth";
    case LostReason::few_inliers:
      return "with too few matches";
    case LostReason::singular:
      return "where the view leaves a direction open";
    case LostReason::implausible_step:
      return "after a jump that no camera makes";
    case LostReason::unknown_place:
      return "where no known place was recognised";
    case LostReason::unconfirmed:
      return "whose place was not confirmed";
    case LostReason::none:
      break;
  }
  return "for no reason given";
}

std::string reasons_text(const Reconstruction& run) {
  std::map<LostReason, int> counts;
  for (const FrameReport& frame : run.frames)
    if (is_lost(frame)) ++counts[frame.tracking.reason];
  std::string text;
  for (const auto& [reason, count] : counts)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, in_words(reason));
  return text;
}

/// The longest stretch of lost frames, "frames 30 to 41".
std::string longest_gap_text(const Reconstruction& run) {
  std::size_t begin = 0, longest = 0, longest_begin = 0;
  for (std::size_t i = 0; i < run.frames.size(); ++i) {
    if (!is_lost(run.frames[i])) {
      begin = i + 1;
    } else if (i + 1 - begin > longest) {
      longest = i + 1 - begin;
      longest_begin = begin;
    }
  }
  const int first = run.frames[longest_begin].index, last = run.frames[longest_begin + longest - 1].index;
  return first == last ? fmt::format("frame {}", first) : fmt::format("frames {} to {}", first, last);
}

std::string sensor_text(const Reconstruction& run) {
  const auto used = std::count_if(run.frames.begin(), run.frames.end(),
                                  [](const FrameReport& frame) { return frame.orientation == OrientationUse::used; });
  return fmt::format("The orientation sensor was used in {} of {} frames.", used, run.frames.size());
}

std::string compiler() {
#ifdef __clang__
  return "Clang " __clang_version__;
#else
  return "GCC " __VERSION__;
#endif
}

}  // namespace

std::string grouped(std::size_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, "\u202f");
  return text;
}

std::vector<std::string> remarks_of(const Reconstruction& run) {
  std::vector<std::string> remarks;
  if (!run.failure.empty()) remarks.push_back("What ended it: " + run.failure);
  if (run.lost() > 0)
    remarks.push_back(fmt::format("Lost: {}. The longest gap: {}.", reasons_text(run), longest_gap_text(run)));
  if (run.ate) {
    const auto worst = std::max_element(run.ate->pairs.begin(), run.ate->pairs.end(),
                                        [](const auto& a, const auto& b) { return a.translation < b.translation; });
    remarks.push_back(fmt::format("The largest distance from the true path is {}, {:.2f} s after the start.",
                                  length_text(worst->translation),
                                  to_seconds(run.trajectory[worst->estimate].time - run.frames.front().time)));
    if (!run.ate_note.empty()) remarks.push_back("The path against the truth: " + run.ate_note);
  } else if (!run.ate_note.empty()) {
    remarks.push_back("How far the path is from the truth could not be told: " + run.ate_note);
  } else {
    remarks.emplace_back("No ground truth was given, so how far the path is from the truth is not known.");
  }
  if (!run.orientation.empty()) remarks.push_back(sensor_text(run));
  if (run.crop)
    remarks.push_back(fmt::format("Of the surface a box of {:.2f} × {:.2f} × {:.2f} m was kept.",
                                  2 * run.crop->half.x(), 2 * run.crop->half.y(), 2 * run.crop->half.z()));
  if (!run.orientation_message.empty()) remarks.push_back(run.orientation_message);
  return remarks;
}

std::vector<Fact> facts_of(const Reconstruction& run) {
  const StageMedians ms = stage_medians(run);
  std::vector<Fact> facts = {{"Frames tracked", fmt::format("{} of {}", run.tracked(), run.frames.size()),
                              run.lost() == 0 ? "none lost" : fmt::format("{} lost", run.lost())}};
  if (run.ate)
    facts.push_back({"Trajectory error", length_text(run.ate->translation.rmse),
                     fmt::format("ATE rmse; median {}, at most {}", length_text(run.ate->translation.median),
                                 length_text(run.ate->translation.max))});
  facts.push_back({"Path", fmt::format("{:.2f} m", path_length(run.trajectory)),
                   fmt::format("{:.1f} s recorded", to_seconds(run.frames.back().time - run.frames.front().time))});
  if (run.loops && run.loops->is_applied)
    facts.push_back({"Drift corrected", length_text(run.loops->max_translation),
                     fmt::format("at most, by {} places seen again", run.loops->accepted())});
  facts.push_back({"Time a frame", fmt::format("{:.1f} ms", ms.total),
                   fmt::format("median; {} in all", duration_text(run.wall_seconds))});
  if (!run.mesh.triangles.empty())
    facts.push_back({"Mesh", grouped(run.mesh.triangles.size()),
                     fmt::format("triangles, {} vertices", grouped(run.mesh.positions.size()))});
  facts.push_back({"Memory", fmt::format("{:.0f} MiB", peak_memory_mebibytes()), "at the peak"});
  return facts;
}

std::vector<Fact> details_of(const Reconstruction& run) {
  const StageMedians ms = stage_medians(run);
  const int resolution = (run.parameters.volume.resolution + 7) / 8 * 8;
  std::vector<Fact> details = {
      {"Command", run.command_line, ""},
      {"Sequence", run.sequence.path, run.sequence.format},
      {"Camera", camera_text(run.sequence.camera), "from " + run.sequence.camera_source},
      {"Depth", fmt::format("{:g} readings a metre", run.sequence.depth_scale),
       "from " + run.sequence.depth_scale_source},
      {"Ground truth", run.groundtruth.empty() ? "none" : run.groundtruth, ""},
      {"Orientation sensor", run.orientation.empty() ? "none" : run.orientation, ""},
      {"Volume", fmt::format("{0} × {0} × {0} voxels", resolution),
       fmt::format("side {:g} m, {:.2f} mm a voxel", run.volume_side, 1e3 * run.volume_side / resolution)},
      {"Time a frame (medians)",
       fmt::format("preprocess {:.1f} ms, track {:.1f}, integrate {:.1f}, ray cast {:.1f}", ms.preprocess, ms.track,
                   ms.integrate, ms.raycast),
       fmt::format("reading {:.1f} ms beside it; waited for {:.1f} ms", ms.decode, ms.wait)},
      {"Loops", run.loops ? loops_words(*run.loops) : "not looked for",
       run.loops ? (run.loops->is_applied ? "the path was corrected by them" : run.loops->note) : ""},
      {"Computed on", run.backend, ""},
      {"Version", std::string("Plumbline ") + PLUMBLINE_VERSION, compiler()}};
  for (const Warning& warning : run.sequence.warnings) details.push_back({"Warning", warning.what, warning.what_to_do});
  for (const std::string& reason : run.skipped) details.push_back({"Frame skipped", reason, ""});
  for (const std::string& note : run.sequence.notes) details.push_back({"Note", note, ""});
  return details;
}

}  // namespace plumbline::app
