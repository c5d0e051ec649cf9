#include "capture/depth_device.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "capture/drivers.h"
#include "plumbline/error.h"

namespace plumbline::capture {
namespace {

constexpr const char* kKnown = "take openni2, openni2:FILE.oni, freenect, or virtual:DIR";

void use_intrinsics(const Pinhole& given, DepthDeviceInfo* info) {
  const Pinhole own = info->camera;
  info->camera = given;
  info->camera.width = own.width;
  info->camera.height = own.height;
  info->camera_source = "given intrinsics";
  if (!info->camera.is_valid())
    throw Error("the intrinsics are not those of a camera", "intrinsics", "give fx, fy, cx and cy in pixels");
}

#if !defined(PLUMBLINE_OPENNI2) || !defined(PLUMBLINE_FREENECT)
[[noreturn]] void throw_left_out(const std::string& kind, const char* package) {
  throw Error("this program was built without " + kind, kind,
              fmt::format("install {} and build again (cmake finds it)", package));
}
#endif

std::unique_ptr<DepthDevice> open_openni2([[maybe_unused]] const std::string& uri,
                                          [[maybe_unused]] const DepthDeviceOptions& options) {
#ifdef PLUMBLINE_OPENNI2
  return make_openni2_device(uri, options);
#else
  throw_left_out("openni2", "libopenni2-dev");
#endif
}

std::unique_ptr<DepthDevice> open_freenect([[maybe_unused]] const std::string& index,
                                           [[maybe_unused]] const DepthDeviceOptions& options) {
#ifdef PLUMBLINE_FREENECT
  return make_freenect_device(index, options);
#else
  throw_left_out("freenect", "libfreenect-dev");
#endif
}

std::unique_ptr<DepthDevice> open_kind(const std::string& kind, const std::string& rest,
                                       const DepthDeviceOptions& options) {
  if (kind == "virtual" && !rest.empty()) return make_virtual_device(rest, options);
  if (kind == "openni2") return open_openni2(rest, options);
  if (kind == "freenect") return open_freenect(rest, options);
  throw Error("there is no such depth camera", "'" + options.device + "'", kKnown);
}

}  // namespace

std::unique_ptr<DepthDevice> open_depth_device(const DepthDeviceOptions& options) {
  if (!std::isfinite(options.speed) || options.speed < 0)
    throw Error(fmt::format("a speed of {} is not possible", options.speed), "speed",
                "give 1 for real time, 0 for no pause");
  const std::size_t colon = options.device.find(':');
  return open_kind(options.device.substr(0, colon),
                   colon == std::string::npos ? std::string() : options.device.substr(colon + 1), options);
}

void apply(const DepthDeviceOptions& options, DepthDeviceInfo* info) {
  if (options.intrinsics) use_intrinsics(*options.intrinsics, info);
}

DepthImage at_scale(DepthImage depth, double from, double to) {
  if (from == to) return depth;
  const double factor = to / from;
  for (std::uint16_t& reading : depth.pixels) {
    const double scaled = std::round(factor * reading);
    reading = scaled <= std::numeric_limits<std::uint16_t>::max() ? static_cast<std::uint16_t>(scaled) : 0;
  }
  return depth;
}

}  // namespace plumbline::capture
