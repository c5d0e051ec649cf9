#include "io/ros_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "io/jpeg.h"
#include "io/png.h"
#include "plumbline/error.h"

namespace plumbline::ros {
namespace {

constexpr double kMillimetres = 1000;
constexpr double kFloatScale = 5000;  // to which 32-bit floats in metres are rounded: 0.2 mm, up to 13 m
constexpr std::uint32_t kMaxSide = 1 << 14;

/// Values one after the other, little-endian, as ROS serialises them.
class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : rest_(bytes), name_(name) {}

  template <class T>
  T take() {
    T value;
    std::memcpy(&value, take_bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view take_bytes(std::size_t size) {
    if (size > rest_.size()) throw Error("a message is cut off", name_, "copy the bag again");
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
  std::string_view take_string() { return take_bytes(take<std::uint32_t>()); }
  template <std::size_t N>
  std::array<double, N> take_doubles() {
    std::array<double, N> values;
    for (double& value : values) value = take<double>();
    return values;
  }
  /// std_msgs/Header.
  Nanoseconds take_header() {
    take<std::uint32_t>();  // seq
    const auto seconds = take<std::uint32_t>(), nanoseconds = take<std::uint32_t>();
    take_string();  // frame_id
    return seconds * kNanosecondsPerSecond + nanoseconds;
  }

 private:
  std::string_view rest_;
  const std::string& name_;
};

bool is_packed_depth(const Image& image) {
  return image.compressed && image.encoding.find("compressedDepth") != std::string::npos;
}

[[noreturn]] void fail(const Image& image, const char* what, const std::string& name) {
  throw Error(fmt::format("an image of {}x{}, '{}', {}", image.width, image.height, image.encoding, what), name,
              "choose other topics");
}

/// Rows of `bytes_per_pixel`; throws Error if the data do not hold them.
void check_rows(const Image& image, std::size_t bytes_per_pixel, const std::string& name) {
  if (image.width == 0 || image.height == 0 || image.width > kMaxSide || image.height > kMaxSide)
    fail(image, "has an impossible size", name);
  if (image.step < image.width * bytes_per_pixel ||
      image.data.size() < std::size_t{image.step} * (image.height - 1) + image.width * bytes_per_pixel)
    fail(image, "holds fewer bytes than its size asks for", name);
}

std::uint16_t to_reading(double metres) {
  const double reading = std::round(metres * kFloatScale);
  return std::isfinite(reading) && reading > 0 && reading <= 65535 ? static_cast<std::uint16_t>(reading) : 0;
}

DepthImage depth_of_raw(const Image& image, const std::string& name) {
  const bool floats = image.encoding == "32FC1";
  const std::size_t size = floats ? 4 : 2;
  check_rows(image, size, name);
  DepthImage depth(static_cast<int>(image.width), static_cast<int>(image.height));
  std::size_t i = 0;
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const char* row = image.data.data() + std::size_t{y} * image.step;
    for (std::uint32_t x = 0; x < image.width; ++x, row += size) {
      std::array<char, 4> bytes{};
      std::copy_n(row, size, bytes.begin());
      if (image.big_endian) std::reverse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
      float metres = 0;
      std::uint16_t reading = 0;
      std::memcpy(&metres, bytes.data(), 4);
      std::memcpy(&reading, bytes.data(), 2);
      depth.pixels[i++] = floats ? to_reading(static_cast<double>(metres)) : reading;
    }
  }
  return depth;
}

/// compressed_depth_image_transport: a header of 12 bytes (a format, two parameters), then a PNG. Floats are stored as
/// a/depth + b.
DepthImage depth_of_packed(const Image& image, const std::string& name) {
  constexpr std::size_t kHeader = 12;
  if (image.data.size() < kHeader) fail(image, "is cut off", name);
  const std::string_view packed = image.data.substr(kHeader);
  if (!is_png(packed)) fail(image, "is not packed as PNG", name);
  DepthImage depth = decode_depth_png(packed, name);
  if (!image.encoding.starts_with("32FC1")) return depth;
  float a = 0, b = 0;
  std::memcpy(&a, image.data.data() + 4, 4);
  std::memcpy(&b, image.data.data() + 8, 4);
  for (std::uint16_t& reading : depth.pixels)
    reading = reading == 0 ? std::uint16_t{0} : to_reading(static_cast<double>(a) / (reading - static_cast<double>(b)));
  return depth;
}

struct ColorLayout {
  std::string_view encoding;
  std::size_t bytes;  ///< a pixel
  std::array<std::size_t, 3> rgb;
};
constexpr std::array<ColorLayout, 7> kColorLayouts = {{{"rgb8", 3, {0, 1, 2}},
                                                       {"bgr8", 3, {2, 1, 0}},
                                                       {"8UC3", 3, {2, 1, 0}},
                                                       {"rgba8", 4, {0, 1, 2}},
                                                       {"bgra8", 4, {2, 1, 0}},
                                                       {"mono8", 1, {0, 0, 0}},
                                                       {"8UC1", 1, {0, 0, 0}}}};

const ColorLayout* color_layout(const Image& image) {
  for (const ColorLayout& layout : kColorLayouts)
    if (image.encoding == layout.encoding) return &layout;
  return nullptr;
}

Pinhole pinhole(double fx, double fy, double cx, double cy, const CameraInfo& info) {
  return {static_cast<float>(fx),
          static_cast<float>(fy),
          static_cast<float>(cx),
          static_cast<float>(cy),
          info.width,
          info.height};
}

}  // namespace

Image parse_image(std::string_view message, bool compressed, const std::string& name) {
  Reader reader(message, name);
  Image image;
  image.compressed = compressed;
  image.time = reader.take_header();
  if (!compressed) {
    image.height = reader.take<std::uint32_t>();
    image.width = reader.take<std::uint32_t>();
  }
  image.encoding = reader.take_string();
  if (!compressed) {
    image.big_endian = reader.take<std::uint8_t>() != 0;
    image.step = reader.take<std::uint32_t>();
  }
  image.data = reader.take_string();
  return image;
}

CameraInfo parse_camera_info(std::string_view message, const std::string& name) {
  Reader reader(message, name);
  reader.take_header();
  CameraInfo info;
  const auto height = reader.take<std::uint32_t>(), width = reader.take<std::uint32_t>();
  if (width > kMaxSide || height > kMaxSide)
    throw Error("a camera has an impossible size", name, "choose other topics");
  info.width = static_cast<int>(width);
  info.height = static_cast<int>(height);
  const std::string_view model = reader.take_string();
  const auto coefficients = reader.take<std::uint32_t>();
  std::array<double, 8> d{};  // k1 k2 p1 p2 k3 k4 k5 k6
  for (std::uint32_t i = 0; i < coefficients; ++i) {
    const double value = reader.take<double>();
    if (i < d.size()) d[i] = value;
  }
  if (std::any_of(d.begin(), d.end(), [](double k) { return k != 0; }) && model != "plumb_bob" &&
      model != "rational_polynomial" && !model.empty())
    throw Error(fmt::format("the lens model '{}' is not known", model), name, "give --intrinsics");
  info.distortion = {d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
  const auto k = reader.take_doubles<9>();
  reader.take_doubles<9>();  // R
  const auto p = reader.take_doubles<12>();
  info.camera = pinhole(k[0], k[4], k[2], k[5], info);
  info.rectified = pinhole(p[0], p[5], p[2], p[6], info);
  return info;
}

Imu parse_imu(std::string_view message, const std::string& name) {
  Reader reader(message, name);
  Imu imu;
  imu.sample.time = reader.take_header();
  reader.take_doubles<4>();  // orientation
  reader.take_doubles<9>();  // its covariance
  const auto rate = reader.take_doubles<3>();
  imu.has_gyroscope = reader.take_doubles<9>()[0] != -1;
  const auto force = reader.take_doubles<3>();
  imu.has_accelerometer = reader.take_doubles<9>()[0] != -1;
  imu.sample.angular_rate = {rate[0], rate[1], rate[2]};
  imu.sample.specific_force = {force[0], force[1], force[2]};
  return imu;
}

std::optional<double> depth_scale(const Image& image) {
  if (is_packed_depth(image)) return image.encoding.starts_with("32FC1") ? kFloatScale : kMillimetres;
  if (image.compressed) return std::nullopt;
  if (image.encoding == "16UC1" || image.encoding == "mono16") return kMillimetres;
  if (image.encoding == "32FC1") return kFloatScale;
  return std::nullopt;
}

bool is_color(const Image& image) {
  if (!image.compressed) return color_layout(image) != nullptr;
  return !is_packed_depth(image) && (is_jpeg(image.data) || is_png(image.data));
}

DepthImage depth_of(const Image& image, const std::string& name) {
  if (!depth_scale(image)) fail(image, "is no depth", name);
  return image.compressed ? depth_of_packed(image, name) : depth_of_raw(image, name);
}

ColorImage color_of(const Image& image, const std::string& name) {
  if (image.compressed) return is_jpeg(image.data) ? decode_jpeg(image.data, name) : decode_color_png(image.data, name);
  const ColorLayout* layout = color_layout(image);
  if (layout == nullptr) fail(image, "is no colour that can be read", name);
  check_rows(image, layout->bytes, name);
  ColorImage color(static_cast<int>(image.width), static_cast<int>(image.height), 3);
  std::uint8_t* out = color.pixels.data();
  for (std::uint32_t y = 0; y < image.height; ++y) {
    const auto* in = reinterpret_cast<const std::uint8_t*>(image.data.data() + std::size_t{y} * image.step);
    for (std::uint32_t x = 0; x < image.width; ++x, in += layout->bytes)
      for (const std::size_t channel : layout->rgb) *out++ = in[channel];
  }
  return color;
}

}  // namespace plumbline::ros
