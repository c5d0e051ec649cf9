#include "io/checks/plausibility.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "io/stamped_lines.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"

namespace plumbline {
namespace {

constexpr int kLooks = 12, kEveryPixel = 7;

// What depth cameras of this kind see: nothing nearer than their pattern or lens allows, no hall.
constexpr double kMinReading = 0.3, kMedianMin = 0.6, kMedianMax = 6, kMaxReading = 12;

struct KnownScale {
  double readings;
  const char* who;
};
constexpr std::array<KnownScale, 7> kScales = {{{1000, "millimetres"},
                                                {5000, "TUM RGB-D, ICL-NUIM"},
                                                {6553.5, "Replica"},
                                                {8000, "SUN3D with its bits as they are"},
                                                {4000, "quarters of a millimetre"},
                                                {10000, "tenths of a millimetre"},
                                                {100, "centimetres"}}};

const char* who_writes(double scale) {
  for (const KnownScale& known : kScales)
    if (known.readings == scale) return known.who;
  return "";
}

bool is_plausible(double near, double median, double far) {
  return near >= kMinReading && median >= kMedianMin && median <= kMedianMax && far <= kMaxReading;
}

/// "at 1000 a metre (millimetres) it would be 2.2 m, at …".
std::string alternatives(const DepthFigures& figures, double scale, const std::vector<double>& scales) {
  std::string text;
  for (std::size_t i = 0; i < scales.size() && i < 3; ++i)
    text += fmt::format("{}{:g} a metre ({}) it would be {:.2g} m", i == 0 ? "at " : ", at ", scales[i],
                        who_writes(scales[i]), figures.median * scale / scales[i]);
  return text;
}

void check_scale(const SequenceInfo& info, const DepthFigures& figures, std::vector<Warning>* warnings) {
  const bool told = !info.depth_scale_is_guess && info.depth_scale_source != "given";
  // What a file tells may be another recording's, but cameras that see so near or far exist.
  const bool impossible = figures.median < 0.35 || figures.median > 5;
  const bool odd = !is_plausible(figures.near, figures.median, figures.far);
  const std::vector<double> scales = plausible_scales(figures, info.depth_scale);
  if (impossible || (odd && !told)) {
    const std::string where = fmt::format(
        "with {:g} readings a metre ({}) the median depth is {:.2g} m, and 5 % of the readings are nearer than {:.2g} "
        "m",
        info.depth_scale, info.depth_scale_source, figures.median, figures.near);
    if (scales.empty())
      warnings->push_back({where, "Check the scale, and give the right one with --depth-scale."});
    else
      warnings->push_back({"the depth scale is probably wrong: " + where,
                           fmt::format("Give --depth-scale {:g} if that is right: {}.", scales.front(),
                                       alternatives(figures, info.depth_scale, scales))});
    return;
  }
  // Cameras that count millimetres leave multiples of five where five thousand are a metre.
  const double other = info.depth_scale == 5000 ? 1000 : info.depth_scale == 1000 ? 5000 : 0;
  const bool fives = figures.step > 0 && figures.step % 5 == 0;
  if (!info.depth_scale_is_guess || other == 0 || fives == (info.depth_scale == 5000)) return;
  // Held by hand, a camera looks at what is a few metres away: a median beyond four speaks for the guess.
  constexpr double kUsualMedian = 4;
  const bool is_usual = figures.median * info.depth_scale / other <= kUsualMedian;
  if (!is_usual || std::find(scales.begin(), scales.end(), other) == scales.end()) return;
  warnings->push_back(
      {fmt::format("the depth scale is a guess, and {:g} and {:g} readings a metre are both plausible: the median "
                   "depth is {:.2g} m or {:.2g} m",
                   info.depth_scale, other, figures.median, figures.median * info.depth_scale / other),
       fmt::format("Give --depth-scale {:g} or --depth-scale {:g}.", other, info.depth_scale)});
}

void check_holes(const DepthFigures& figures, std::vector<Warning>* warnings) {
  if (figures.share >= 0.1) return;
  warnings->push_back(
      {fmt::format("only {:.1f} % of the pixels have a reading", 100 * figures.share),
       "Check that these are the depth images, and that the camera saw something within its range; where "
       "files hold real numbers of millimetres, give --depth-scale 1000."});
}

void check_field_of_view(const Pinhole& k, const std::string& values, std::vector<Warning>* warnings) {
  const double view = degrees(2 * std::atan(0.5 * k.width / k.fx));
  if (view < 20 || view > 130)
    warnings->push_back({fmt::format("the images would be {:.0f} degrees wide: {}", view, values),
                         "Check that the intrinsics are in pixels, of images of this size."});
}

/// Readings that are none: what cameras and simulators write where nothing was measured, and pictures for the eye.
/// Whether that, and not the scale, is what does not add up.
bool check_readings(const DepthFigures& figures, double scale, std::vector<Warning>* warnings) {
  if (figures.stretched) {
    warnings->push_back(
        {"each depth image reaches up to the largest number that 16 bits hold: the images seem to be "
         "stretched for viewing, so that a reading means another distance in each",
         "Give the depth images as the camera wrote them."});
    return true;
  }
  const bool is_round = figures.end % 500 == 0 || (figures.end & (figures.end + 1)) == 0;
  if (figures.end_share < 0.15 || !is_round) return false;
  warnings->push_back(
      {fmt::format(
           "{:.0f} % of the readings have the largest value, {} ({:.2g} m): it seems to stand for \"nothing was "
           "measured\", and would be taken for a wall",
           100 * figures.end_share, figures.end, figures.end / scale),
       fmt::format("Give --set preprocess.max_depth={:.3g}, or write 0 there.", 0.99 * figures.end / scale)});
  return false;
}

void check_camera(const SequenceInfo& info, std::vector<Warning>* warnings) {
  const Pinhole& k = info.camera;
  const std::string values = fmt::format("fx {} fy {} cx {} cy {} of {}x{} images ({})", k.fx, k.fy, k.cx, k.cy,
                                         k.width, k.height, info.camera_source);
  if (const auto order = other_order(k)) {
    warnings->push_back({"the intrinsics seem to be in another order: " + values, *order});
    return;
  }
  const double ratio = std::abs(k.fx / k.fy);
  if (ratio < 0.9 || ratio > 1.1)
    warnings->push_back({"fx and fy differ by more than a tenth: " + values, "Check the intrinsics."});
  const double off_x = std::abs((k.cx + 0.5) / k.width - 0.5), off_y = std::abs((k.cy + 0.5) / k.height - 0.5);
  if (off_x > 0.15 || off_y > 0.15)
    warnings->push_back({"the principal point lies far from the images' centre: " + values,
                         "Check that the intrinsics belong to images of this size."});
  check_field_of_view(k, values, warnings);
}

/// The unit in which `interval` would be that of a camera's frames, if it is not one in seconds.
const char* likely_unit(double interval) {
  constexpr double kMinInterval = 1.0 / 500, kMaxInterval = 5;
  for (const int decimals : {0, 3, 6, 9})
    if (const double seconds = interval * std::pow(10, -decimals); seconds >= kMinInterval && seconds <= kMaxInterval)
      return decimals == 0 ? "" : unit_of_decimals(decimals);
  return "another unit";
}

void check_jumps(const std::vector<Nanoseconds>& times, std::vector<Warning>* warnings) {
  const Nanoseconds limit = jump_limit(times);
  int jumps = 0;
  std::size_t longest = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const Nanoseconds gap = times[i] - times[i - 1];
    if (gap > limit) ++jumps;
    if (longest == 0 || gap > times[longest] - times[longest - 1]) longest = i;
  }
  if (jumps == 0) return;
  warnings->push_back(
      {fmt::format("the stamps jump {} time{} by more than {:.2g} s, at most by {:.2f} s between frames {} "
                   "and {}, {:.2f} s after the start",
                   jumps, jumps == 1 ? "" : "s", to_seconds(limit), to_seconds(times[longest] - times[longest - 1]),
                   longest - 1, longest, to_seconds(times[longest - 1] - times[0])),
       "Tracking may lose its way there: leave out what lies before or after it, or check that frames are "
       "not missing."});
}

void check_times(const Sequence& sequence, std::vector<Warning>* warnings) {
  std::vector<Nanoseconds> times;
  for (int i = 0; i < sequence.size(); ++i) times.push_back(sequence.time(i));
  if (times.size() < 3) return;
  const double interval = to_seconds(usual_interval(times));
  const std::string unit = likely_unit(interval);
  if (unit.empty()) return check_jumps(times, warnings);
  warnings->push_back({fmt::format("the frames are {:.3g} s apart in the median: their stamps seem to be in {} where "
                                   "seconds are expected",
                                   interval, unit),
                       "Write the stamps in seconds; a sensor's readings and colour are looked up by them."});
}

double quantile(const std::vector<std::uint32_t>& counts, double count, double share) {
  double below = 0;
  for (std::size_t reading = 1; reading < counts.size(); ++reading) {
    below += counts[reading];
    if (below >= share * count) return static_cast<double>(reading);
  }
  return 0;
}

}  // namespace

DepthFigures depth_figures(const Sequence& sequence) {
  DepthFigures figures;
  std::vector<std::uint32_t> counts(65536);
  double pixels = 0, count = 0;
  int stretched = 0;
  double scale = sequence.info().depth_scale;
  for (int i = 0; i < kLooks; ++i) {
    const int index = static_cast<int>(static_cast<long long>(i) * sequence.size() / kLooks);
    if (i > 0 && index == static_cast<int>(static_cast<long long>(i - 1) * sequence.size() / kLooks)) continue;
    try {
      const Frame frame = sequence.read(index);
      scale = frame.depth_scale;
      int largest = 0;
      for (std::size_t p = 0; p < frame.depth.pixels.size(); p += kEveryPixel) {
        const std::uint16_t reading = frame.depth.pixels[p];
        ++pixels;
        if (reading == 0) continue;
        largest = std::max<int>(largest, reading);
        if (reading == 65535) continue;  // nothing was measured
        ++count;
        ++counts[reading];
        figures.step = std::gcd(figures.step, static_cast<int>(reading));
      }
      ++figures.frames;
      stretched += largest >= 65000;
    } catch (const Error&) {  // the run will tell
    }
  }
  if (count == 0) return figures;
  figures.share = count / pixels;
  const double high = std::accumulate(counts.begin() + 45000, counts.begin() + 65535, 0.0);
  figures.stretched = figures.frames > 1 && stretched == figures.frames && high > 0.01 * count && scale < 6000;
  for (int reading = 65534; reading > 0 && figures.end == 0; --reading)
    if (counts[static_cast<std::size_t>(reading)] > 0) figures.end = reading;
  figures.end_share = counts[static_cast<std::size_t>(figures.end)] / count;
  if (figures.end_share >= 0.15) count -= counts[static_cast<std::size_t>(figures.end)];
  figures.near = quantile(counts, count, 0.05) / scale;
  figures.median = quantile(counts, count, 0.5) / scale;
  figures.far = quantile(counts, count, 0.95) / scale;
  return figures;
}

std::vector<double> plausible_scales(const DepthFigures& figures, double depth_scale) {
  std::vector<double> scales;
  for (const KnownScale& known : kScales) {
    const double factor = depth_scale / known.readings;
    if (known.readings != depth_scale &&
        is_plausible(factor * figures.near, factor * figures.median, factor * figures.far))
      scales.push_back(known.readings);
  }
  const auto rotated = std::find(scales.begin(), scales.end(), 8000.0);
  if (figures.step > 0 && figures.step % 8 == 0 && rotated != scales.end())
    std::rotate(scales.begin(), rotated, rotated + 1);
  return scales;
}

std::optional<std::string> other_order(const Pinhole& camera) {
  const auto fits = [&](double fx, double fy, double cx, double cy) {
    return fx > 0 && std::abs(std::abs(fy) / fx - 1) < 0.1 && std::abs((cx + 0.5) / camera.width - 0.5) < 0.15 &&
           std::abs((cy + 0.5) / camera.height - 0.5) < 0.15;
  };
  const auto advice = [](const char* order, double fx, double fy, double cx, double cy) {
    return fmt::format("They were read as fx,fy,cx,cy and look like {}: then give --intrinsics {:g},{:g},{:g},{:g}.",
                       order, fx, fy, cx, cy);
  };
  const double a = camera.fx, b = camera.fy, c = camera.cx, d = camera.cy;
  if (fits(a, b, c, d)) return std::nullopt;
  if (fits(a, c, b, d)) return advice("fx,cx,fy,cy", a, c, b, d);
  if (fits(c, d, a, b)) return advice("cx,cy,fx,fy", c, d, a, b);
  if (fits(a, b, d, c)) return advice("fx,fy,cy,cx", a, b, d, c);
  return std::nullopt;
}

Nanoseconds usual_interval(const std::vector<Nanoseconds>& times) {
  std::vector<Nanoseconds> intervals;
  for (std::size_t i = 1; i < times.size(); ++i) intervals.push_back(times[i] - times[i - 1]);
  if (intervals.empty()) return 0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

Nanoseconds jump_limit(const std::vector<Nanoseconds>& times) {
  constexpr Nanoseconds kIntervals = 15;
  return std::max(kNanosecondsPerSecond, kIntervals * usual_interval(times));
}

std::vector<Warning> check_plausibility(const Sequence& sequence) {
  std::vector<Warning> warnings;
  const DepthFigures figures = depth_figures(sequence);
  if (figures.frames > 0) check_holes(figures, &warnings);
  if (figures.share > 0 && !check_readings(figures, sequence.info().depth_scale, &warnings))
    check_scale(sequence.info(), figures, &warnings);
  check_camera(sequence.info(), &warnings);
  check_times(sequence, &warnings);
  return warnings;
}

}  // namespace plumbline
