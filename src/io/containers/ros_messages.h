// The messages of ROS that a reconstruction can use, from their serialised form, in ROS 1's and in ROS 2's encoding.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/containers/message_store.h"
#include "plumbline/image.h"
#include "plumbline/imu.h"
#include "plumbline/pinhole.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"

namespace plumbline::ros {

/// sensor_msgs/Image, or sensor_msgs/CompressedImage, whose `format` then says how `data` is packed.
struct Image {
  Nanoseconds time = 0;    ///< of the header: when it was taken
  std::string_view frame;  ///< of reference, by its name
  std::uint32_t width = 0, height = 0, step = 0;
  std::string encoding;  ///< "16UC1", "rgb8", …, or the format of a compressed image
  bool big_endian = false, compressed = false;
  std::string_view data;
};

/// sensor_msgs/CameraInfo.
struct CameraInfo {
  std::string frame;
  int width = 0, height = 0;
  Pinhole camera;  ///< of the image as it is
  Distortion distortion;
  Pinhole rectified;  ///< of the rectified image
};

/// sensor_msgs/Imu.
struct Imu {
  std::string frame;
  ImuSample sample;
  bool has_gyroscope = true, has_accelerometer = true;
};

/// geometry_msgs/TransformStamped.
struct Transform {
  std::string parent, child;
  SE3 parent_from_child;
};

/// All throw Error for a message that is cut off or impossible; `name` is the recording and topic for errors.
Image parse_image(std::string_view message, Wire wire, bool compressed, const std::string& name);
/// The stamp of a message that begins with a header, of which the first `kHeaderBytes` are enough.
Nanoseconds parse_stamp(std::string_view message, Wire wire, const std::string& name);
constexpr std::size_t kHeaderBytes = 256;
CameraInfo parse_camera_info(std::string_view message, Wire wire, const std::string& name);
Imu parse_imu(std::string_view message, Wire wire, const std::string& name);
/// std_msgs/Float32.
double parse_float(std::string_view message, Wire wire, const std::string& name);
/// tf2_msgs/TFMessage.
std::vector<Transform> parse_transforms(std::string_view message, Wire wire, const std::string& name);
/// geometry_msgs/Transform.
SE3 parse_transform(std::string_view message, Wire wire, const std::string& name);
/// realsense2_camera/Extrinsics, with or without a header: second_from_first of the cameras in the topic's name.
SE3 parse_extrinsics(std::string_view message, Wire wire, const std::string& name);

/// Readings per metre of a depth image of this encoding; empty if it is none.
std::optional<double> depth_scale(const Image& image);
/// Whether color_of() can read it.
bool is_color(const Image& image);

/// Raw readings of depth_scale(image) per metre; 0 = none. `float_unit` is what 1 means in 32FC1, metres. Throws Error
/// for other images and damaged ones.
DepthImage depth_of(const Image& image, const std::string& name, double float_unit = 1);
/// 8-bit RGB. Throws Error as above.
ColorImage color_of(const Image& image, const std::string& name);

}  // namespace plumbline::ros
