#include "run/frame_log.h"

#include <fmt/format.h>

#include <filesystem>
#include <numbers>
#include <system_error>
#include <utility>
#include <vector>

#include "plumbline/error.h"
#include "plumbline/time.h"
#include "tracking/starts.h"

namespace plumbline::app {
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

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

}  // namespace

FrameLog::FrameLog(std::string path, const TrackingParameters& parameters)
    : path_(std::move(path)),
      partial_(path_ + ".partial"),
      levels_(static_cast<int>(parameters.iterations.size())),
      csv_(std::make_unique<CsvWriter>(partial_, columns(parameters))) {}

void FrameLog::add(const FrameReport& report, const ReadTimes& read, std::string_view missing_reading) {
  const TrackingResult& tracking = report.tracking;
  std::vector<std::string> row = {std::to_string(report.index), format_seconds(report.time, 9),
                                  std::string(to_string(tracking.status)), std::string(to_string(tracking.reason))};
  for (int i = 0; i < levels_; ++i) {
    const auto level = static_cast<std::size_t>(i);
    row.push_back(std::to_string(level < tracking.iterations.size() ? tracking.iterations[level] : 0));
  }
  row.push_back(std::to_string(tracking.inliers));
  row.push_back(fmt::format("{:.6g}", tracking.inlier_fraction));
  row.push_back(fmt::format("{:.6g}", agreement(tracking)));
  row.push_back(fmt::format("{:.6g}", tracking.rms));
  row.push_back(fmt::format("{:.6g}", tracking.median_distance));
  row.emplace_back(report.orientation == OrientationUse::missing ? missing_reading : to_string(report.orientation));
  row.push_back(std::to_string(report.starts));
  row.push_back(fmt::format("{:.4f}", report.seed_angle * kDegreesPerRadian));
  row.push_back(fmt::format("{:.4f}", report.seed_to_result_angle * kDegreesPerRadian));
  row.push_back(std::to_string(tracking.rank));
  row.push_back(fmt::format("{:.6g}", tracking.condition));
  const StageTimes& ms = report.milliseconds;
  for (const double value : {read.wait, read.decode, ms.preprocess, ms.track, ms.integrate, ms.raycast, ms.total()})
    row.push_back(fmt::format("{:.3f}", value));
  const Eigen::Vector3d t = report.world_from_camera.translation();
  const Eigen::Quaterniond q = report.world_from_camera.quaternion();
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
    row.push_back(fmt::format("{:.9f}", value));
  csv_->row(row);
}

void FrameLog::commit() {
  csv_->close();
  std::error_code error;
  std::filesystem::rename(partial_, path_, error);
  if (error)
    throw Error(fmt::format("the table of frames cannot be renamed ({})", error.message()), path_,
                "It is complete in " + partial_ + ".");
}

}  // namespace plumbline::app
