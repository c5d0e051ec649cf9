#include "run/summary.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "cli/console.h"
#include "core/median.h"
#include "plumbline/angles.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "reconstruction/run_parts.h"
#include "run/verdict.h"
#include "view/message.h"

namespace plumbline::app {
namespace {

using Json = nlohmann::ordered_json;

/// Median of a figure of every element.
template <class T, class Figure>
double median_of(const std::vector<T>& list, Figure&& figure) {
  std::vector<double> values;
  values.reserve(list.size());
  for (const T& element : list) values.push_back(figure(element));
  return median(std::move(values));
}

std::vector<int> lost_frames(const Reconstruction& run) {
  std::vector<int> lost;
  for (const FrameReport& frame : run.frames)
    if (frame.tracking.status == TrackingStatus::lost) lost.push_back(frame.index);
  return lost;
}

Json sequence_json(const SequenceInfo& info) {
  Json warnings = Json::array();
  for (const Warning& warning : info.warnings)
    warnings.push_back({{"what", warning.what}, {"what_to_do", warning.what_to_do}});
  return {{"path", info.path},
          {"format", info.format},
          {"frames", info.frames},
          {"color_frames", info.color_frames},
          {"depth_scale", info.depth_scale},
          {"depth_scale_source", info.depth_scale_source},
          {"camera_is_guess", info.camera_is_guess},
          {"depth_scale_is_guess", info.depth_scale_is_guess},
          {"notes", info.notes},
          {"warnings", warnings}};
}

Json depth_json(const Reconstruction& run) {
  if (!run.depth) return {};
  return {{"rms_per_m", run.depth->distortion.rms()},
          {"pairs", run.depth->pairs},
          {"before_per_m", run.depth->before},
          {"after_per_m", run.depth->after},
          {"seconds", run.depth_seconds}};
}

Json camera_json(const SequenceInfo& info) {
  const Pinhole& k = info.camera;
  const Distortion& d = info.distortion;
  return {{"width", k.width},
          {"height", k.height},
          {"fx", k.fx},
          {"fy", k.fy},
          {"cx", k.cx},
          {"cy", k.cy},
          {"distortion", {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6}},
          {"source", info.camera_source}};
}

Json ate_json(const Reconstruction& run) {
  if (run.groundtruth.empty()) return nullptr;
  Json json = {{"groundtruth", run.groundtruth}};
  if (!run.ate) {
    json["note"] = run.ate_note;
    return json;
  }
  const eval::Statistics& s = run.ate->translation;
  json.update({{"pairs", s.count},
               {"rmse_m", s.rmse},
               {"mean_m", s.mean},
               {"median_m", s.median},
               {"std_m", s.std},
               {"max_m", s.max}});
  if (!run.ate_note.empty()) json["note"] = run.ate_note;
  return json;
}

/// tx ty tz qx qy qz qw.
Json pose_json(const SE3& pose) {
  const Eigen::Vector3d& t = pose.translation();
  const Eigen::Quaterniond q = pose.quaternion();
  return {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

Json volume_json(const Reconstruction& run) {
  return {{"resolution", (run.parameters.volume.resolution + 7) / 8 * 8},
          {"side_m", run.volume_side},
          {"world_from_volume", pose_json(run.world_from_volume)}};
}

Json milliseconds_json(const Reconstruction& run) {
  const StageMedians ms = stage_medians(run);
  return {{"wait", ms.wait},   {"decode", ms.decode},       {"preprocess", ms.preprocess},
          {"track", ms.track}, {"integrate", ms.integrate}, {"raycast", ms.raycast},
          {"total", ms.total}};
}

std::ptrdiff_t frames_with(const Reconstruction& run, OrientationUse use) {
  return std::count_if(run.frames.begin(), run.frames.end(),
                       [&](const FrameReport& frame) { return frame.orientation == use; });
}

/// Of the sensor, as far as it was found before the run.
Json clock_json(const Reconstruction& run) {
  if (!run.clock) return nullptr;
  return {{"is_sure", run.clock->is_sure},         {"offset_s", run.clock->offset}, {"sd_s", run.clock->sd},
          {"correlation", run.clock->correlation}, {"text", run.clock->text},       {"seconds", run.clock->seconds}};
}

/// In how many frames the sensor was used, and why not in the others.
Json orientation_json(const Reconstruction& run) {
  if (run.orientation.empty()) return nullptr;
  const auto count = [&](OrientationUse use) { return frames_with(run, use); };
  return {{"source", run.orientation},
          {"used", count(OrientationUse::used)},
          {"missing", count(OrientationUse::missing)},
          {"distrusted", count(OrientationUse::distrusted)},
          {"dropped", count(OrientationUse::dropped)},
          {"clock", clock_json(run)},
          {"lateness_s", run.frames.empty() ? 0.0 : run.frames.back().sensor_lateness},
          {"notes", run.orientation_notes},
          {"message", run.orientation_message.empty() ? Json() : Json(run.orientation_message)}};
}

Json interruptions_json(const Reconstruction& run) {
  const Interruptions found = interruptions(run);
  const std::optional<double> from = lost_to_the_end(run);
  return {{"count", found.count},
          {"recovered", found.recovered},
          {"revoked", found.revoked},
          {"lost_to_the_end_from_s", from ? Json(*from) : Json()}};
}

/// The loops of each status, and those that the path was corrected by.
Json loops_json(const Reconstruction& run) {
  if (!run.loops) return nullptr;
  const LoopClosure& loops = *run.loops;
  Json refused = Json::object(), accepted = Json::array();
  for (const LoopReport& loop : loops.loops) {
    if (loop.status == LoopStatus::accepted)
      accepted.push_back({{"frames", {loop.first_frame, loop.second_frame}},
                          {"first_from_second", pose_json(loop.first_from_second)}});
    else
      refused[std::string(to_string(loop.status))] = loops.count(loop.status);
  }
  return {{"applied", loops.is_applied},
          {"note", loops.note.empty() ? Json() : Json(loops.note)},
          {"views", loops.views},
          {"tried", loops.loops.size()},
          {"accepted", accepted},
          {"refused", refused},
          {"disagreement_before", loops.disagreement_before},
          {"disagreement_after", loops.disagreement_after},
          {"max_correction_m", loops.max_translation},
          {"max_correction_deg", degrees(loops.max_rotation)},
          {"wall_s", loops.seconds}};
}

Json live_json(const Reconstruction& run) {
  if (!run.live) return nullptr;
  return {{"captured", run.live->captured}, {"dropped", run.live->dropped}};
}

/// The verdict with all that it weighs, whether it spoke against the result or not.
Json verdict_json(const Reconstruction& run) {
  const Verdict verdict = verdict_of(run);
  Json evidence = Json::object();
  for (const Doubt& doubt : verdict.doubts) evidence[doubt.name] = doubt.value;
  return {
      {"level", to_string(verdict.level)}, {"text", verdict.text}, {"doubt", verdict.doubt}, {"evidence", evidence}};
}

/// ICP iterations of a registered frame, over all levels.
double mean_iterations(const Reconstruction& run) {
  int iterations = 0, registered = 0;
  for (const FrameReport& frame : run.frames) {
    for (const int n : frame.tracking.iterations) iterations += n;
    registered += !frame.tracking.iterations.empty();
  }
  return static_cast<double>(iterations) / std::max(1, registered);
}

/// What became of the path.
std::vector<std::string> loops_text(const Reconstruction& run) {
  if (!run.loops || (run.loops->loops.empty() && run.loops->views == 0)) return {};
  const LoopClosure& loops = *run.loops;
  std::vector<std::string> lines;
  if (!loops.loops.empty()) lines.push_back("loops      " + loops_words(loops));
  if (loops.is_applied)
    lines.push_back(fmt::format("path       corrected by up to {:.3f} m and {:.2f} degrees in {:.1f} s",
                                loops.max_translation, degrees(loops.max_rotation), loops.seconds));
  else if (!loops.loops.empty())
    lines.push_back("path       as it was tracked: " + loops.note);
  if (loops.is_applied && !run.fusion && !run.mesh.triangles.empty())
    lines.push_back("note       the mesh was fused along the path as it was tracked (trajectory_live.txt)");
  return lines;
}

}  // namespace

Interruptions interruptions(const Reconstruction& run) {
  Interruptions found;
  bool was_interrupted = false;
  for (const FrameReport& frame : run.frames) {
    found.count += frame.is_after_interruption && !was_interrupted;
    found.recovered += frame.is_recovered;
    found.revoked += frame.is_recovered && frame.tracking.status == TrackingStatus::lost;
    was_interrupted = frame.is_after_interruption;
  }
  return found;
}

std::optional<double> lost_to_the_end(const Reconstruction& run) {
  auto first = run.frames.end();
  while (first != run.frames.begin() && std::prev(first)->tracking.status == TrackingStatus::lost) --first;
  if (first == run.frames.end() || !std::prev(run.frames.end())->is_after_interruption) return std::nullopt;
  return to_seconds(first->time - run.frames.front().time);
}

StageMedians stage_medians(const Reconstruction& run) {
  const auto stage = [&](auto&& figure) {
    return median_of(run.frames, [&](const FrameReport& frame) { return figure(frame.milliseconds); });
  };
  return {median_of(run.reads, [](const ReadTimes& read) { return read.wait; }),
          median_of(run.reads, [](const ReadTimes& read) { return read.decode; }),
          stage([](const StageTimes& ms) { return ms.preprocess; }),
          stage([](const StageTimes& ms) { return ms.track; }),
          stage([](const StageTimes& ms) { return ms.integrate; }),
          stage([](const StageTimes& ms) { return ms.raycast; }),
          stage([](const StageTimes& ms) { return ms.total(); })};
}

double path_length(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length +=
        (trajectory[i].world_from_camera.translation() - trajectory[i - 1].world_from_camera.translation()).norm();
  return length;
}

double peak_memory_mebibytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;  // Linux counts in KiB
}

Json fusion_json(const Reconstruction& run) {
  if (!run.fusion) return run.fusion_note.empty() ? Json() : Json({{"note", run.fusion_note}});
  const FusionResult& f = *run.fusion;
  return {{"detail_m", f.detail}, {"frames", f.frames}, {"bricks", f.bricks},          {"bytes", f.bytes},
          {"islands", f.islands}, {"notes", f.notes},   {"wall_s", run.fusion_seconds}};
}

std::string loops_words(const LoopClosure& loops) {
  std::string text = fmt::format("{} of {} tried are accepted", loops.accepted(), loops.loops.size());
  std::string refused;
  for (const LoopStatus status : {LoopStatus::not_registered, LoopStatus::too_weak, LoopStatus::one_way,
                                  LoopStatus::seen_through, LoopStatus::too_far, LoopStatus::contradicted})
    if (const int count = loops.count(status); count > 0)
      refused += fmt::format("{}{} {}", refused.empty() ? "" : ", ", count, to_string(status));
  return refused.empty() ? text : text + "; " + refused;
}

std::string summary_json(const Reconstruction& run) {
  const auto frames = static_cast<double>(run.frames.size());
  const Json json = {
      {"plumbline", PLUMBLINE_VERSION},
      {"command", run.command_line},
      {"sequence", sequence_json(run.sequence)},
      {"camera", camera_json(run.sequence)},
      {"depth_calibration", depth_json(run)},
      {"depth_calibration_refusal", run.depth_refusal.empty() ? Json() : Json(depth_refusal_text(run.depth_refusal))},
      {"volume", volume_json(run)},
      {"backend", run.backend},
      {"verdict", verdict_json(run)},
      {"frames", run.frames.size()},
      {"tracked", run.tracked()},
      {"lost", run.lost()},
      {"lost_frames", lost_frames(run)},
      {"interruptions", interruptions_json(run)},
      {"live", live_json(run)},
      {"interrupted", run.signal != 0},
      {"skipped_frames", run.skipped},
      {"error", run.failure.empty() ? Json() : Json(run.failure)},
      {"loops", loops_json(run)},
      {"path_length_m", path_length(run.trajectory)},
      {"orientation", orientation_json(run)},
      {"mean_iterations", mean_iterations(run)},
      {"ate", ate_json(run)},
      {"mesh", {{"vertices", run.mesh.positions.size()}, {"triangles", run.mesh.triangles.size()}}},
      {"crop", box_json(run.crop)},
      {"final_fusion", fusion_json(run)},
      {"median_ms", milliseconds_json(run)},
      {"wall_s", run.wall_seconds},
      {"frames_per_s", run.wall_seconds > 0 ? frames / run.wall_seconds : 0},
      {"peak_memory_mib", peak_memory_mebibytes()},
  };
  // Paths may hold bytes that are not UTF-8, which JSON cannot.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> summary_text(const Reconstruction& run) {
  const StageMedians ms = stage_medians(run);
  std::vector<std::string> lines = {fmt::format("tracked    {} of {} frames, {} lost; {:.2f} m of path", run.tracked(),
                                                run.frames.size(), run.lost(), path_length(run.trajectory))};
  if (const Interruptions found = interruptions(run); found.count > 0)
    lines.push_back(
        fmt::format("breaks     {} interruptions; a known place was recognised {} times, {} of them not confirmed",
                    found.count, found.recovered, found.revoked));
  if (const auto from = lost_to_the_end(run))
    lines.push_back(fmt::format("lost       from {:.1f} s to the end: no known place was seen", *from));
  for (const std::string& line : loops_text(run)) lines.push_back(line);
  if (run.live)
    lines.push_back(fmt::format("camera     {} frames, {} of them dropped for lack of time", run.live->captured,
                                run.live->dropped));
  if (!run.orientation.empty()) {
    lines.push_back(fmt::format("sensor     used in {} frames", frames_with(run, OrientationUse::used)));
    if (!run.orientation_message.empty()) lines.push_back("warning    " + run.orientation_message);
  }
  if (run.ate)
    lines.push_back(fmt::format("ATE        {:.4f} m rmse, {:.4f} m median, {:.4f} m max over {} pairs",
                                run.ate->translation.rmse, run.ate->translation.median, run.ate->translation.max,
                                run.ate->translation.count));
  if (!run.ate_note.empty()) lines.push_back((run.ate ? "           " : "ATE        not known: ") + run.ate_note);
  const Verdict verdict = verdict_of(run);
  lines.push_back(fmt::format("verdict    {}", to_string(verdict.level)));
  for (const std::string& reason : verdict.reasons) lines.push_back("           " + reason);
  lines.push_back(
      fmt::format("time       {} in all; median a frame {:.1f} ms (preprocess {:.1f}, track {:.1f}, "
                  "integrate {:.1f}, raycast {:.1f})",
                  duration_text(run.wall_seconds), ms.total, ms.preprocess, ms.track, ms.integrate, ms.raycast));
  if (!run.mesh.triangles.empty())
    lines.push_back(
        fmt::format("mesh       {} vertices, {} triangles", run.mesh.positions.size(), run.mesh.triangles.size()));
  if (run.fusion) {
    lines.push_back(fmt::format("detail     {:.1f} mm: {} frames fused again along the final path in {:.1f} s",
                                1e3 * run.fusion->detail, run.fusion->frames, run.fusion_seconds));
    for (const std::string& note : run.fusion->notes) lines.push_back("note       " + note);
  }
  if (run.crop) lines.emplace_back("note       the mesh is cropped to the box that was set in the page");
  if (!run.fusion_note.empty()) lines.push_back("note       the mesh is that of the volume: " + run.fusion_note);
  lines.push_back(fmt::format("memory     {:.0f} MiB at the peak", peak_memory_mebibytes()));
  return lines;
}

}  // namespace plumbline::app
