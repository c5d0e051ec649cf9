#include "cli/sequence_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "plumbline/time.h"

namespace plumbline::app {
namespace {

std::string distortion_text(const Distortion& d) {
  if (d.is_zero()) return "no distortion";
  std::string text = fmt::format("distortion {} {} {} {} {}", d.k1, d.k2, d.p1, d.p2, d.k3);
  if (d.is_rational()) text += fmt::format(" {} {} {}", d.k4, d.k5, d.k6);
  return text;
}

std::string frames_text(const Sequence& sequence) {
  const Timing times = timing(sequence);
  std::string text = fmt::format("{}", sequence.size());
  if (times.median_interval > 0)
    text += fmt::format(" in {:.1f} s, {:.1f} a second", times.duration, 1 / times.median_interval);
  const int color = sequence.info().color_frames;
  return text + (color > 0 ? fmt::format(", {} with colour", color) : ", no colour");
}

}  // namespace

std::string camera_text(const Pinhole& k) {
  return fmt::format("{}x{}, fx {} fy {} cx {} cy {}", k.width, k.height, k.fx, k.fy, k.cx, k.cy);
}

Timing timing(const Sequence& sequence) {
  Timing result;
  const int frames = sequence.size();
  if (frames < 2) return result;
  std::vector<Nanoseconds> intervals;
  for (int i = 1; i < frames; ++i) intervals.push_back(sequence.time(i) - sequence.time(i - 1));
  const auto longest = std::max_element(intervals.begin(), intervals.end());
  result.longest_gap = to_seconds(*longest);
  result.longest_gap_start =
      to_seconds(sequence.time(static_cast<int>(longest - intervals.begin())) - sequence.time(0));
  std::nth_element(intervals.begin(), intervals.begin() + intervals.size() / 2, intervals.end());
  result.median_interval = to_seconds(intervals[intervals.size() / 2]);
  result.duration = to_seconds(sequence.time(frames - 1) - sequence.time(0));
  return result;
}

std::vector<std::string> describe(const Sequence& sequence) {
  const SequenceInfo& info = sequence.info();
  std::vector<std::string> lines = {
      fmt::format("sequence   {} ({})", info.path, info.format),
      fmt::format("frames     {}", frames_text(sequence)),
      fmt::format("camera     {}, {}", camera_text(info.camera), distortion_text(info.distortion)),
      fmt::format("           from {}", info.camera_source),
      fmt::format("depth      {:g} readings a metre, from {}{}", info.depth_scale, info.depth_scale_source,
                  info.depth_scale_is_guess ? " (a guess)" : ""),
      fmt::format("truth      {}", info.groundtruth.empty() ? "none" : info.groundtruth)};
  for (const std::string& note : info.notes) lines.push_back(fmt::format("note       {}", note));
  for (const Warning& warning : info.warnings)
    lines.push_back(fmt::format("warning    {}. {}", warning.what, warning.what_to_do));
  return lines;
}

std::vector<std::string> describe(const ImuRecording& imu, const SequenceInfo& info) {
  const double duration = to_seconds(imu.samples.back().time - imu.samples.front().time);
  std::string text = fmt::format("imu        {} sample{}", imu.samples.size(), imu.samples.size() == 1 ? "" : "s");
  if (duration > 0)
    text +=
        fmt::format(" in {:.1f} s, {:.0f} a second", duration, static_cast<double>(imu.samples.size() - 1) / duration);
  text += !imu.has_gyroscope       ? ": accelerometer"
          : !imu.has_accelerometer ? ": gyroscope"
                                   : ": gyroscope, accelerometer";
  if (imu.has_magnetometer) text += ", magnetometer";
  std::vector<std::string> lines = {text};
  if (info.body_from_camera) {
    const Eigen::Quaterniond q(*info.body_from_camera);
    lines.push_back(fmt::format("mounting   \"{:.6f} {:.6f} {:.6f} {:.6f}\" (--mounting), from the calibration", q.x(),
                                q.y(), q.z(), q.w()));
  }
  return lines;
}

}  // namespace plumbline::app
