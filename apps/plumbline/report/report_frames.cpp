#include "report/report_frames.h"
#include "plumbline/angles.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>

namespace plumbline::app {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMaxRows = 40'000, kMaxTruePoses = 20'000;

/// What is known of one frame.
struct FrameRow {
  const FrameReport* frame = nullptr;
  const ReadTimes* read = nullptr;
  double start = 0;  ///< seconds, the run's first frame
  double error = kNone;
  Eigen::Vector3d truth = Eigen::Vector3d::Constant(kNone);
};

using FrameFigure = std::function<double(const FrameRow&)>;
struct Column {
  std::string name;
  FrameFigure value;
};

/// A figure that only a registered frame has.
FrameFigure registered(double (*value)(const TrackingResult&)) {
  return [value](const FrameRow& row) {
    const TrackingResult& tracking = row.frame->tracking;
    return tracking.iterations.empty() ? kNone : value(tracking);
  };
}

std::vector<Column> identity_columns() {
  return {{"index", [](const FrameRow& r) { return r.frame->index; }},
          {"time_s", [](const FrameRow& r) { return to_seconds(r.frame->time) - r.start; }},
          {"status", [](const FrameRow& r) { return static_cast<double>(r.frame->tracking.status); }},
          {"reason", [](const FrameRow& r) { return static_cast<double>(r.frame->tracking.reason); }},
          {"orientation", [](const FrameRow& r) { return static_cast<double>(r.frame->orientation); }}};
}

std::vector<Column> tracking_columns() {
  return {{"iterations", registered([](const TrackingResult& t) {
             return static_cast<double>(std::accumulate(t.iterations.begin(), t.iterations.end(), 0));
           })},
          {"inlier_fraction", registered([](const TrackingResult& t) { return t.inlier_fraction; })},
          {"rms_m", registered([](const TrackingResult& t) { return t.rms; })},
          {"median_distance_m", registered([](const TrackingResult& t) { return t.median_distance; })},
          {"seed_deg", [](const FrameRow& r) { return degrees(r.frame->seed_angle); }},
          {"seed_to_result_deg", [](const FrameRow& r) { return degrees(r.frame->seed_to_result_angle); }}};
}

std::vector<Column> time_columns() {
  return {{"decode_ms", [](const FrameRow& r) { return r.read->decode; }},
          {"preprocess_ms", [](const FrameRow& r) { return r.frame->milliseconds.preprocess; }},
          {"track_ms", [](const FrameRow& r) { return r.frame->milliseconds.track; }},
          {"integrate_ms", [](const FrameRow& r) { return r.frame->milliseconds.integrate; }},
          {"raycast_ms", [](const FrameRow& r) { return r.frame->milliseconds.raycast; }}};
}

std::vector<Column> pose_columns() {
  const auto position = [](int axis) {
    return [axis](const FrameRow& r) { return r.frame->world_from_camera.translation()[axis]; };
  };
  const auto rotation = [](int component) {
    return [component](const FrameRow& r) { return r.frame->world_from_camera.quaternion().coeffs()[component]; };
  };
  return {{"tx", position(0)}, {"ty", position(1)}, {"tz", position(2)}, {"qx", rotation(0)},
          {"qy", rotation(1)}, {"qz", rotation(2)}, {"qw", rotation(3)}};
}

std::vector<Column> truth_columns() {
  return {{"error_m", [](const FrameRow& r) { return r.error; }},
          {"true_tx", [](const FrameRow& r) { return r.truth.x(); }},
          {"true_ty", [](const FrameRow& r) { return r.truth.y(); }},
          {"true_tz", [](const FrameRow& r) { return r.truth.z(); }}};
}

std::vector<Column> columns_of(const Reconstruction& run) {
  std::vector<Column> columns;
  const auto append = [&](std::vector<Column> more) { columns.insert(columns.end(), more.begin(), more.end()); };
  append(identity_columns());
  append(tracking_columns());
  append(time_columns());
  append(pose_columns());
  if (run.ate) append(truth_columns());
  return columns;
}

void add_truth(const Reconstruction& run, std::vector<FrameRow>* rows) {
  std::vector<std::size_t> frame_of_pose;  // only tracked frames have a pose
  for (std::size_t i = 0; i < run.frames.size(); ++i)
    if (run.frames[i].tracking.status != TrackingStatus::lost) frame_of_pose.push_back(i);
  const SE3 estimate_from_reference = run.ate->reference_from_estimate.inverse();
  for (const auto& pair : run.ate->pairs) {
    FrameRow& row = (*rows)[frame_of_pose[pair.estimate]];
    row.error = pair.translation;
    row.truth = estimate_from_reference * run.truth[pair.reference].world_from_camera.translation();
  }
}

std::vector<FrameRow> rows_of(const Reconstruction& run) {
  std::vector<FrameRow> rows(run.frames.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].frame = &run.frames[i];
    rows[i].read = &run.reads[i];
    rows[i].start = to_seconds(run.frames.front().time);
  }
  if (run.ate) add_truth(run, &rows);
  return rows;
}

}  // namespace

FrameTable frame_table(const Reconstruction& run) {
  const std::vector<FrameRow> rows = rows_of(run);
  FrameTable table;
  const std::size_t stride = std::max<std::size_t>(1, (rows.size() + kMaxRows - 1) / kMaxRows);
  table.stride = static_cast<int>(stride);
  table.rows = (rows.size() + stride - 1) / stride;
  for (const Column& column : columns_of(run)) {
    table.columns.push_back(column.name);
    for (std::size_t i = 0; i < rows.size(); i += stride)
      table.values.push_back(static_cast<float>(column.value(rows[i])));
  }
  return table;
}

std::vector<float> true_path(const Reconstruction& run) {
  std::vector<float> path;
  if (!run.ate) return path;
  const Nanoseconds first = run.frames.front().time, last = run.frames.back().time;
  const auto begin = std::lower_bound(run.truth.begin(), run.truth.end(), first,
                                      [](const StampedPose& pose, Nanoseconds t) { return pose.time < t; });
  const auto end = std::upper_bound(begin, run.truth.end(), last,
                                    [](Nanoseconds t, const StampedPose& pose) { return t < pose.time; });
  const auto count = static_cast<std::size_t>(end - begin);
  const std::size_t stride = std::max<std::size_t>(1, (count + kMaxTruePoses - 1) / kMaxTruePoses);
  const SE3 estimate_from_reference = run.ate->reference_from_estimate.inverse();
  for (std::size_t i = 0; i < count; i += stride) {
    const Eigen::Vector3d p =
        estimate_from_reference * (begin + static_cast<std::ptrdiff_t>(i))->world_from_camera.translation();
    for (const double x : {p.x(), p.y(), p.z()}) path.push_back(static_cast<float>(x));
  }
  return path;
}

}  // namespace plumbline::app
