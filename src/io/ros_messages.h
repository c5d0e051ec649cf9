// The messages of ROS 1's sensor_msgs that a reconstruction can use, from their serialised form.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/image.h"
#include "plumbline/imu.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline::ros {

/// sensor_msgs/Image, or sensor_msgs/CompressedImage, whose `format` then says how `data` is packed.
struct Image {
  Nanoseconds time = 0;  ///< of the header: when it was taken
  std::uint32_t width = 0, height = 0, step = 0;
  std::string encoding;  ///< "16UC1", "rgb8", …, or the format of a compressed image
  bool big_endian = false, compressed = false;
  std::string_view data;
};

/// sensor_msgs/CameraInfo.
struct CameraInfo {
  int width = 0, height = 0;
  Pinhole camera;  ///< of the image as it is
  Distortion distortion;
  Pinhole rectified;  ///< of the rectified image
};

/// sensor_msgs/Imu.
struct Imu {
  ImuSample sample;
  bool has_gyroscope = true, has_accelerometer = true;
};

/// All throw Error for a message that is cut off or impossible; `name` is the bag and topic for errors.
Image parse_image(std::string_view message, bool compressed, const std::string& name);
CameraInfo parse_camera_info(std::string_view message, const std::string& name);
Imu parse_imu(std::string_view message, const std::string& name);

/// Readings per metre of a depth image of this encoding; empty if it is none.
std::optional<double> depth_scale(const Image& image);
/// Whether color_of() can read it.
bool is_color(const Image& image);

/// Raw readings of depth_scale(image) per metre; 0 = none. Throws Error for other images and damaged ones.
DepthImage depth_of(const Image& image, const std::string& name);
/// 8-bit RGB. Throws Error as above.
ColorImage color_of(const Image& image, const std::string& name);

}  // namespace plumbline::ros
