#include "run/frame_log.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/time.h"
#include "tracking/starts.h"

namespace plumbline::app {
namespace {

std::vector<std::string> columns(const TrackingParameters& parameters) {
  std::vector<std::string> names = {"index", "time_s", "status", "reason"};
  const int levels = static_cast<int>(parameters.iterations.size());
  for (int i = 0; i < levels; ++i)
    names.push_back(fmt::format("iterations_level{}", parameters.finest_level + levels - 1 - i));
  for (const char* name : {"inliers",
                           "inlier_fraction",
                           "agreement",
                           "rms_m",
                           "median_distance_m",
                           "orientation",
                           "starts",
                           "seed_deg",
                           "seed_to_result_deg",
                           "rank",
                           "condition",
                           "wait_ms",
                           "decode_ms",
                           "preprocess_ms",
                           "track_ms",
                           "integrate_ms",
                           "raycast_ms",
                           "total_ms",
                           "tx",
                           "ty",
                           "tz",
                           "qx",
                           "qy",
                           "qz",
                           "qw"})
    names.emplace_back(name);
  return names;
}

/// The first frame of a place that was recognised says so.
std::string status_of(const FrameReport& report) {
  const TrackingStatus status = report.tracking.status;
  return report.is_recovered && status == TrackingStatus::provisional ? "recovered" : std::string(to_string(status));
}

void add_tracking(const FrameReport& report, int levels, std::vector<std::string>* row) {
  const TrackingResult& tracking = report.tracking;
  for (int i = 0; i < levels; ++i) {
    const auto level = static_cast<std::size_t>(i);
    row->push_back(std::to_string(level < tracking.iterations.size() ? tracking.iterations[level] : 0));
  }
  row->push_back(std::to_string(tracking.inliers));
  for (const double value : {tracking.inlier_fraction, agreement(tracking), tracking.rms, tracking.median_distance})
    row->push_back(fmt::format("{:.6g}", value));
}

void add_seed(const ProcessedFrame& processed, std::vector<std::string>* row) {
  const FrameReport& report = processed.report;
  if (report.orientation == OrientationUse::missing)
    row->emplace_back(processed.reading ? to_string(processed.reading->status) : "");
  else
    row->emplace_back(to_string(report.orientation));
  row->push_back(std::to_string(report.starts));
  row->push_back(fmt::format("{:.4f}", degrees(report.seed_angle)));
  row->push_back(fmt::format("{:.4f}", degrees(report.seed_to_result_angle)));
  row->push_back(std::to_string(report.tracking.rank));
  row->push_back(fmt::format("{:.6g}", report.tracking.condition));
}

void add_times(const ReadTimes& read, const StageTimes& ms, std::vector<std::string>* row) {
  for (const double value : {read.wait, read.decode, ms.preprocess, ms.track, ms.integrate, ms.raycast, ms.total()})
    row->push_back(fmt::format("{:.3f}", value));
}

void add_pose(const SE3& world_from_camera, std::vector<std::string>* row) {
  const Eigen::Vector3d t = world_from_camera.translation();
  const Eigen::Quaterniond q = world_from_camera.quaternion();
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
    row->push_back(fmt::format("{:.9f}", value));
}

}  // namespace

FrameLog::FrameLog(std::string path, TrackingParameters parameters)
    : path_(std::move(path)), partial_(path_ + ".partial"), parameters_(std::move(parameters)) {}

void FrameLog::observe(const ProcessedFrame& processed) {
  if (!csv_) csv_ = std::make_unique<CsvWriter>(partial_, columns(parameters_));
  const FrameReport& report = processed.report;
  std::vector<std::string> row = {std::to_string(report.index), format_seconds(report.time, 9), status_of(report),
                                  std::string(to_string(report.tracking.reason))};
  add_tracking(report, static_cast<int>(parameters_.iterations.size()), &row);
  add_seed(processed, &row);
  add_times(processed.read, report.milliseconds, &row);
  add_pose(report.world_from_camera, &row);
  csv_->row(row);
}

void FrameLog::commit() {
  if (!csv_) return;
  csv_->close();
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error)
    throw Error(fmt::format("the table of frames cannot be renamed ({})", error.message()), path_,
                "It is complete in " + partial_ + ".");
}

}  // namespace plumbline::app
