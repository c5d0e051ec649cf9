#include "plumbline/orientation_stream.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "plumbline/error.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;

constexpr const char* kOrientationStreamWhere = "orientation";

bool is_rotation(const Matrix3d& r) {
  return r.allFinite() && (r * r.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
         r.determinant() > 0;
}

void validate(const OrientationStreamOptions& o) {
  constexpr double kMaxTime = 1e3;  // seconds
  if (!(std::abs(o.time_offset) <= 1e9))
    throw Error("the time offset is out of range", kOrientationStreamWhere, "give seconds, up to a billion");
  if (!(o.max_gap > 0 && o.max_gap <= kMaxTime) || !(o.max_extrapolation >= 0 && o.max_extrapolation <= kMaxTime))
    throw Error("the longest gap or extrapolation is out of range", kOrientationStreamWhere,
                "give seconds, up to 1000");
  if (!is_rotation(o.body_from_camera))
    throw Error("the mounting is no rotation", kOrientationStreamWhere, "give a unit quaternion");
}

void validate(const std::vector<OrientationSample>& samples, double offset) {
  if (samples.empty()) throw Error("there are no samples", kOrientationStreamWhere, "give a file with orientations");
  // Keeps the sums with offset and gaps within 64 bits.
  constexpr double kLargest = 9.2e9;  // seconds
  for (const OrientationSample& sample : {samples.front(), samples.back()})
    if (std::abs(to_seconds(sample.time) + offset) > kLargest)
      throw Error("the time offset takes the stamps out of range", kOrientationStreamWhere, "check stamps and offset");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i > 0 && samples[i].time <= samples[i - 1].time)
      throw Error("the samples are not ordered by time", kOrientationStreamWhere, "sort them, each stamp once");
    if (!is_rotation(samples[i].earth_from_body))
      throw Error("sample " + std::to_string(i) + " is no rotation", kOrientationStreamWhere, "leave it out");
  }
}

/// Nanoseconds from one stamp to a later one, without overflow.
std::uint64_t elapsed(Nanoseconds earlier, Nanoseconds later) {
  return static_cast<std::uint64_t>(later) - static_cast<std::uint64_t>(earlier);
}

bool within(Nanoseconds earlier, Nanoseconds later, double seconds) {
  return elapsed(earlier, later) <= static_cast<std::uint64_t>(from_seconds(seconds));
}

/// The rotation at constant angular rate through both samples.
Matrix3d at_constant_rate(const OrientationSample& a, const OrientationSample& b, Nanoseconds time) {
  const double share = static_cast<double>(time - a.time) / static_cast<double>(b.time - a.time);
  return a.earth_from_body * so3::exp(share * so3::log(a.earth_from_body.transpose() * b.earth_from_body));
}

}  // namespace

std::string_view to_string(OrientationStatus status) {
  switch (status) {
    case OrientationStatus::ok:
      return "ok";
    case OrientationStatus::before_start:
      return "before the orientation's start";
    case OrientationStatus::after_end:
      return "after the orientation's end";
    case OrientationStatus::gap:
      return "gap in the orientation";
  }
  return "unknown";
}

OrientationStream::OrientationStream(std::vector<OrientationSample> samples, const OrientationStreamOptions& options)
    : samples_(std::move(samples)), options_(options) {
  validate(options_);
  validate(samples_, options_.time_offset);
  const Nanoseconds offset = from_seconds(options_.time_offset);
  for (OrientationSample& sample : samples_) sample.time += offset;
}

OrientationReading OrientationStream::lookup(Nanoseconds time) const {
  const auto after = std::lower_bound(samples_.begin(), samples_.end(), time,
                                      [](const OrientationSample& s, Nanoseconds t) { return s.time < t; });
  const std::size_t next = static_cast<std::size_t>(after - samples_.begin());
  if (after != samples_.end() && after->time == time) return reading(after->earth_from_body);
  if (after == samples_.begin())
    return near(time, after->time) ? extrapolate(next, time) : OrientationReading{OrientationStatus::before_start};
  const OrientationSample& before = *(after - 1);
  if (after == samples_.end())
    return near(before.time, time) ? extrapolate(next - 1, time) : OrientationReading{OrientationStatus::after_end};
  if (within(before.time, after->time, options_.max_gap)) return reading(at_constant_rate(before, *after, time));
  // The shores of a gap are ends like the others.
  const bool first_is_nearer = elapsed(before.time, time) <= elapsed(time, after->time);
  if (first_is_nearer && near(before.time, time)) return extrapolate(next - 1, time);
  if (!first_is_nearer && near(time, after->time)) return extrapolate(next, time);
  return {OrientationStatus::gap};
}

OrientationReading OrientationStream::reading(const Matrix3d& earth_from_body) const {
  return {OrientationStatus::ok, earth_from_body, earth_from_body * options_.body_from_camera};
}

bool OrientationStream::near(Nanoseconds earlier, Nanoseconds later) const {
  return within(earlier, later, options_.max_extrapolation);
}

OrientationReading OrientationStream::extrapolate(std::size_t index, Nanoseconds time) const {
  const OrientationSample& end = samples_[index];
  // The nearest sample that lies at least as far on the other side.
  const auto by_time = [](const OrientationSample& s, Nanoseconds t) { return s.time < t; };
  const Nanoseconds mirrored = end.time - (time - end.time);
  auto partner = std::lower_bound(samples_.begin(), samples_.end(), mirrored, by_time);
  if (time > end.time && (partner == samples_.end() || partner->time > mirrored)) {
    if (partner == samples_.begin()) return reading(end.earth_from_body);
    --partner;
  }
  if (partner == samples_.end()) return reading(end.earth_from_body);
  const bool forward = partner->time > end.time;
  const OrientationSample& step = forward ? *(partner - 1) : *(partner + 1);
  const bool broken = forward ? !within(step.time, partner->time, options_.max_gap)
                              : !within(partner->time, step.time, options_.max_gap);
  if (broken) return reading(end.earth_from_body);
  return reading(at_constant_rate(end, *partner, time));
}

OrientationReading add_orientation(const OrientationStream& stream, Frame* frame) {
  OrientationReading reading = stream.lookup(frame->time);
  if (reading.status == OrientationStatus::ok && stream.options().convention.has_up)
    frame->earth_from_camera = reading.earth_from_camera;
  return reading;
}

}  // namespace plumbline
