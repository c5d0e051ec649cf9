#include "io/containers/ros_messages.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "io/images/image_size.h"
#include "io/images/jpeg.h"
#include "io/images/png.h"
#include "io/images/raw_color.h"
#include "io/images/rvl.h"
#include "plumbline/error.h"

namespace plumbline::ros {
namespace {

constexpr double kMillimetres = 1000;
constexpr double kFloatScale = 5000;  // to which 32-bit floats in metres are rounded: 0.2 mm, up to 13 m

/// Values one after the other, as ROS serialises them: ROS 1 little-endian and without gaps; ROS 2 in OMG's Common Data
/// Representation, which begins with four bytes that tell the order of bytes, and aligns each value to its size.
class Reader {
 public:
  Reader(std::string_view bytes, Wire wire, const std::string& name)
      : all_(bytes), name_(name), aligned_(wire == Wire::cdr) {
    if (!aligned_) return;
    const std::string_view head = take_bytes(4);
    const auto kind = static_cast<unsigned char>(head[1]);
    const bool known = head[0] == 0 && (kind <= 1 || kind == 6 || kind == 7);  // version 1, version 2
    if (!known) throw Error("a message is in an encoding of CDR that is not known", name_, "convert the recording");
    big_endian_ = (kind & 1) == 0;
    max_alignment_ = kind <= 1 ? 8 : 4;
  }

  template <class T>
  T take() {
    if (aligned_) align(std::min(sizeof(T), max_alignment_));
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), take_bytes(sizeof(T)).data(), sizeof(T));
    if (big_endian_) std::reverse(bytes.begin(), bytes.end());
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }
  std::string_view take_bytes(std::size_t size) {
    if (size > all_.size() - at_) throw Error("a message is cut off", name_, "copy the recording again");
    const std::string_view bytes = all_.substr(at_, size);
    at_ += size;
    return bytes;
  }
  std::string_view take_sequence() { return take_bytes(take<std::uint32_t>()); }
  std::string_view take_string() {
    std::string_view text = take_sequence();
    if (aligned_ && text.ends_with('\0')) text.remove_suffix(1);
    return text;
  }
  template <std::size_t N>
  std::array<double, N> take_doubles() {
    std::array<double, N> values;
    for (double& value : values) value = take<double>();
    return values;
  }
  /// std_msgs/Header: the stamp, and the frame of reference.
  struct Header {
    Nanoseconds time = 0;
    std::string_view frame;
  };
  Nanoseconds take_stamp() {
    if (!aligned_) take<std::uint32_t>();  // seq
    const auto seconds = take<std::uint32_t>(), nanoseconds = take<std::uint32_t>();
    return seconds * kNanosecondsPerSecond + nanoseconds;
  }
  Header take_header() {
    const Nanoseconds time = take_stamp();
    return {time, take_string()};
  }
  /// geometry_msgs/Transform. A quaternion of no length is none.
  SE3 take_transform() {
    const auto t = take_doubles<3>();
    const auto q = take_doubles<4>();
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    const Eigen::Vector3d translation(t[0], t[1], t[2]);
    if (!(std::abs(rotation.norm() - 1) < 0.01) || !translation.allFinite())
      throw Error("a transform is no rigid motion", name_, "copy the recording again");
    return SE3(rotation.normalized(), translation);
  }
  std::size_t left() const { return all_.size() - at_; }

 private:
  void align(std::size_t size) {
    constexpr std::size_t kHead = 4;  // alignment counts from behind it
    const std::size_t past = (at_ - kHead) % size;
    if (past != 0) take_bytes(size - past);
  }

  std::string_view all_;
  std::size_t at_ = 0;
  const std::string& name_;
  bool aligned_ = false, big_endian_ = false;
  std::size_t max_alignment_ = 1;
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
  if (image.width == 0 || image.height == 0 || image.width > kMaxImageSide || image.height > kMaxImageSide)
    fail(image, "has an impossible size", name);
  if (image.step < image.width * bytes_per_pixel ||
      image.data.size() < std::size_t{image.step} * (image.height - 1) + image.width * bytes_per_pixel)
    fail(image, "holds fewer bytes than its size asks for", name);
}

bool is_png_depth(const Image& image) {
  if (!image.compressed || is_packed_depth(image) || !is_png(image.data)) return false;
  try {
    return read_png_header(image.data, "").is_depth;
  } catch (const Error&) {
    return false;
  }
}

std::uint16_t to_reading(double metres) {
  const double reading = std::round(metres * kFloatScale);
  return std::isfinite(reading) && reading > 0 && reading <= 65535 ? static_cast<std::uint16_t>(reading) : 0;
}

DepthImage depth_of_raw(const Image& image, const std::string& name, double float_unit) {
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
      depth.pixels[i++] = floats ? to_reading(float_unit * static_cast<double>(metres)) : reading;
    }
  }
  return depth;
}

/// Columns, rows (4 bytes each), and depth packed by RVL.
DepthImage depth_of_rvl(const Image& image, std::string_view packed, const std::string& name) {
  constexpr std::size_t kHeader = 8;
  if (packed.size() < kHeader) fail(image, "is cut off", name);
  std::array<std::uint32_t, 2> size{};
  std::memcpy(size.data(), packed.data(), kHeader);
  if (size[0] == 0 || size[1] == 0 || size[0] > kMaxImageSide || size[1] > kMaxImageSide)
    fail(image, "has an impossible size", name);
  DepthImage depth(static_cast<int>(size[0]), static_cast<int>(size[1]));
  depth.pixels = decode_rvl(packed.substr(kHeader), depth.pixels.size(), name);
  return depth;
}

/// compressed_depth_image_transport: a header of 12 bytes (a format, two parameters), then a PNG or RVL. Floats are
/// stored as a/depth + b.
DepthImage depth_of_packed(const Image& image, const std::string& name) {
  constexpr std::size_t kHeader = 12;
  if (image.data.size() < kHeader) fail(image, "is cut off", name);
  const std::string_view packed = image.data.substr(kHeader);
  const bool rvl = image.encoding.find("rvl") != std::string::npos;
  if (!rvl && !is_png(packed)) fail(image, "is packed neither as PNG nor as RVL", name);
  DepthImage depth = rvl ? depth_of_rvl(image, packed, name) : decode_depth_png(packed, name);
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

/// The Brown-Conrady coefficients that undo those of librealsense's inverse model, which maps distorted positions to
/// undistorted ones: linear least squares over a grid of the image.
Distortion inverted(const std::array<double, 8>& d, const Pinhole& camera) {
  constexpr int kSteps = 16;
  Eigen::Matrix<double, Eigen::Dynamic, 5> a(2 * (kSteps + 1) * (kSteps + 1), 5);
  Eigen::VectorXd b(a.rows());
  int row = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j, row += 2) {
      const double xd = (camera.width * static_cast<double>(i) / kSteps - static_cast<double>(camera.cx)) / camera.fx;
      const double yd = (camera.height * static_cast<double>(j) / kSteps - static_cast<double>(camera.cy)) / camera.fy;
      const double rd = xd * xd + yd * yd, radial = 1 + rd * (d[0] + rd * (d[1] + rd * d[4]));
      const double x = xd * radial + 2 * d[2] * xd * yd + d[3] * (rd + 2 * xd * xd);
      const double y = yd * radial + 2 * d[3] * xd * yd + d[2] * (rd + 2 * yd * yd);
      const double r = x * x + y * y;
      a.row(row) << x * r, x * r * r, 2 * x * y, r + 2 * x * x, x * r * r * r;
      a.row(row + 1) << y * r, y * r * r, r + 2 * y * y, 2 * x * y, y * r * r * r;
      b[row] = xd - x;
      b[row + 1] = yd - y;
    }
  }
  const Eigen::VectorXd k = a.colPivHouseholderQr().solve(b);
  return {k[0], k[1], k[2], k[3], k[4]};
}

/// Of a lens model by its name in a CameraInfo, or in librealsense's recordings.
Distortion distortion_of(std::string_view model, const std::array<double, 8>& d, const Pinhole& camera,
                         const std::string& name) {
  if (std::all_of(d.begin(), d.end(), [](double k) { return k == 0; })) return {};
  const bool finite = std::all_of(d.begin(), d.end(), [](double k) { return std::isfinite(k); });
  if (finite && model == "Inverse Brown Conrady" && camera.is_valid()) return inverted(d, camera);
  constexpr std::array<std::string_view, 5> kBrown = {"plumb_bob", "rational_polynomial", "", "Brown Conrady",
                                                      "Modified Brown Conrady"};
  if (!finite || std::find(kBrown.begin(), kBrown.end(), model) == kBrown.end())
    throw Error(fmt::format("the lens model '{}' is not known", model), name, "give --intrinsics");
  return {d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7]};
}

}  // namespace

Image parse_image(std::string_view message, Wire wire, bool compressed, const std::string& name) {
  Reader reader(message, wire, name);
  Image image;
  image.compressed = compressed;
  const auto header = reader.take_header();
  image.time = header.time;
  image.frame = header.frame;
  if (!compressed) {
    image.height = reader.take<std::uint32_t>();
    image.width = reader.take<std::uint32_t>();
  }
  image.encoding = reader.take_string();
  if (!compressed) {
    image.big_endian = reader.take<std::uint8_t>() != 0;
    image.step = reader.take<std::uint32_t>();
  }
  image.data = reader.take_sequence();
  return image;
}

Nanoseconds parse_stamp(std::string_view message, Wire wire, const std::string& name) {
  return Reader(message, wire, name).take_stamp();
}

CameraInfo parse_camera_info(std::string_view message, Wire wire, const std::string& name) {
  Reader reader(message, wire, name);
  CameraInfo info;
  info.frame = reader.take_header().frame;
  const auto height = reader.take<std::uint32_t>(), width = reader.take<std::uint32_t>();
  if (width > kMaxImageSide || height > kMaxImageSide)
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
  const auto k = reader.take_doubles<9>();
  reader.take_doubles<9>();  // R
  const auto p = reader.take_doubles<12>();
  info.camera = pinhole(k[0], k[4], k[2], k[5], info);
  info.rectified = pinhole(p[0], p[5], p[2], p[6], info);
  info.distortion = distortion_of(model, d, info.camera, name);
  return info;
}

Imu parse_imu(std::string_view message, Wire wire, const std::string& name) {
  Reader reader(message, wire, name);
  Imu imu;
  const auto header = reader.take_header();
  imu.frame = header.frame;
  imu.sample.time = header.time;
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

double parse_float(std::string_view message, Wire wire, const std::string& name) {
  return static_cast<double>(Reader(message, wire, name).take<float>());
}

std::vector<Transform> parse_transforms(std::string_view message, Wire wire, const std::string& name) {
  Reader reader(message, wire, name);
  std::vector<Transform> transforms;
  const auto count = reader.take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    Transform transform;
    transform.parent = reader.take_header().frame;
    transform.child = reader.take_string();
    transform.parent_from_child = reader.take_transform();
    transforms.push_back(std::move(transform));
  }
  return transforms;
}

SE3 parse_transform(std::string_view message, Wire wire, const std::string& name) {
  return Reader(message, wire, name).take_transform();
}

SE3 parse_extrinsics(std::string_view message, Wire wire, const std::string& name) {
  Reader reader(message, wire, name);
  constexpr std::size_t kBytes = 12 * sizeof(double);
  if (reader.left() > kBytes + 3) reader.take_header();
  const auto r = reader.take_doubles<9>();
  const auto t = reader.take_doubles<3>();
  const Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix3d>(r.data());
  const bool rigid = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 0.01 &&
                     rotation.determinant() > 0 && std::isfinite(t[0] + t[1] + t[2]);
  if (!rigid) throw Error("the extrinsics are no rigid motion", name, "copy the recording again");
  return SE3(rotation, Eigen::Vector3d(t[0], t[1], t[2])).normalized();
}

std::optional<double> depth_scale(const Image& image) {
  if (is_packed_depth(image)) return image.encoding.starts_with("32FC1") ? kFloatScale : kMillimetres;
  if (is_png_depth(image)) return kMillimetres;
  if (image.compressed) return std::nullopt;
  if (image.encoding == "16UC1" || image.encoding == "mono16") return kMillimetres;
  if (image.encoding == "32FC1") return kFloatScale;
  return std::nullopt;
}

bool is_color(const Image& image) {
  if (!image.compressed)
    return color_layout(image) != nullptr || yuv_order(image.encoding) || bayer_order(image.encoding);
  return !is_packed_depth(image) && !is_png_depth(image) && (is_jpeg(image.data) || is_png(image.data));
}

DepthImage depth_of(const Image& image, const std::string& name, double float_unit) {
  if (!depth_scale(image)) fail(image, "is no depth", name);
  if (is_png_depth(image)) return decode_depth_png(image.data, name);
  return image.compressed ? depth_of_packed(image, name) : depth_of_raw(image, name, float_unit);
}

ColorImage color_of(const Image& image, const std::string& name) {
  if (image.compressed) return is_jpeg(image.data) ? decode_jpeg(image.data, name) : decode_color_png(image.data, name);
  if (const auto yuv = yuv_order(image.encoding)) {
    check_rows(image, 2, name);
    if (image.width % 2 != 0) fail(image, "has an odd width", name);
    return decode_yuv(reinterpret_cast<const std::uint8_t*>(image.data.data()), image.step,
                      static_cast<int>(image.width), static_cast<int>(image.height), *yuv);
  }
  if (const auto bayer = bayer_order(image.encoding)) {
    check_rows(image, 1, name);
    return decode_bayer(reinterpret_cast<const std::uint8_t*>(image.data.data()), image.step,
                        static_cast<int>(image.width), static_cast<int>(image.height), *bayer);
  }
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
