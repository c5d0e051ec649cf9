// What the topics of a ROS recording are to each other: which one is depth and which colour, whose camera_info is
// whose, how the cameras and the inertial sensor are mounted.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/containers/message_store.h"
#include "io/containers/ros_messages.h"

namespace plumbline::ros {

/// "scan.bag /camera/depth/image_raw", for errors.
std::string name_of(const MessageStore& store, const MessageTopic& topic);
bool is_compressed(const MessageTopic& topic);

/// A message with its parsed form, which may refer to its bytes.
struct StoredImage {
  Image image;
  MessageBytes bytes;
};
StoredImage read_image(const MessageStore& store, const MessageTopic& topic, const StoredMessage& message);

/// The named topic, or of those that hold depth (or colour) the one whose name fits best; never infrared unless named.
/// Null if there is none. Throws Error if the named one holds none.
const MessageTopic* choose_depth(const MessageStore& store, const std::string& named);
/// Colour of the depth topic's namespace comes first.
const MessageTopic* choose_color(const MessageStore& store, const std::string& named, const MessageTopic& depth);
/// Depth topics that can be read and are not `taken`.
std::vector<std::string> other_depth_topics(const MessageStore& store, const MessageTopic& taken);
/// "; /camera/depth/image holds 8UC1", of the topics that are named for depth and are none; for errors.
std::string list_unread_depth(const MessageStore& store);
/// Whether two topics have the first part of their names in common, "/camera".
bool share_namespace(std::string_view a, std::string_view b);
/// "\n  /camera/depth (sensor_msgs/Image, 30 messages)…", for errors.
std::string list_topics(const MessageStore& store);

/// Whether a depth topic's name says that it was brought to the colour camera's pixels, or a colour topic's the
/// reverse.
bool is_registered_by_name(std::string_view depth, std::string_view color);

/// A camera_info that belongs to a topic of images: it shares the namespace or the frame of reference, has the image's
/// size, and is not another kind of camera's. The image's camera is the rectified one where its name says so. Without
/// one, `refusal` gets what is wrong with those that are there.
struct CameraOfTopic {
  std::string topic;
  Pinhole camera;
  Distortion distortion;
};
std::optional<CameraOfTopic> camera_of(const MessageStore& store, const MessageTopic& image, const Image& first,
                                       int width, int height, std::string* refusal = nullptr);

/// Readings per metre by a RealSense's option "Depth Units" of the sensor that the topic belongs to.
std::optional<double> realsense_depth_scale(const MessageStore& store, const MessageTopic& depth);

/// Rigid motions between the frames of reference in the recording.
class Mountings {
 public:
  explicit Mountings(const MessageStore& store);

  /// second_from_first of two topics with messages of those frames: by librealsense's stream extrinsics, a RealSense
  /// wrapper's extrinsics topic, or the tree of tf_static and tf. Empty if nothing connects them.
  struct Found {
    SE3 second_from_first;
    std::string source;
  };
  std::optional<Found> between(const MessageTopic& first, std::string_view first_frame, const MessageTopic& second,
                               std::string_view second_frame) const;

 private:
  struct OfStream {
    std::string prefix;  ///< "/device_0/sensor_1/Color_0"
    SE3 stream_from_reference;
  };
  struct Extrinsics {
    std::string topic;
    SE3 second_from_first;
  };
  std::optional<SE3> through_tree(std::string_view first, std::string_view second) const;

  std::vector<OfStream> streams_;
  std::vector<Extrinsics> extrinsics_;
  std::vector<Transform> tree_;
};

/// The inertial topics that serve: one with both sensors, or one each.
struct ImuTopics {
  const MessageTopic* gyroscope = nullptr;      ///< null: none
  const MessageTopic* accelerometer = nullptr;  ///< null: none; the same as the gyroscope's where it has both
  std::string frame;                            ///< of reference
};
ImuTopics imu_topics(const MessageStore& store);

/// Gyroscope and accelerometer; where they come on topics apart, the force is interpolated to the gyroscope's stamps.
/// Without a gyroscope the force alone.
ImuRecording read_imu(const MessageStore& store, const ImuTopics& topics, std::vector<std::string>* notes);

}  // namespace plumbline::ros
