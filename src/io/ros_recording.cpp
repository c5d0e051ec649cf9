// ROS 1 bags as sequences.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/undistort.h"
#include "io/camera.h"
#include "io/recording.h"
#include "io/ros_messages.h"
#include "io/rosbag.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

/// One message of a topic, by the time at which its image was taken.
struct StampedMessage {
  Nanoseconds time = 0;
  BagMessage message;
};

struct ImageTopic {
  const BagTopic* topic = nullptr;
  bool compressed = false;
  std::vector<StampedMessage> messages = {};  // by time
};

struct BagFrame {
  StampedMessage depth;
  std::optional<StampedMessage> color = {};
};

std::string name_of(const Bag& bag, const BagTopic& topic) { return bag.path() + " " + topic.name; }

bool is_compressed(const BagTopic& topic) { return topic.type == "sensor_msgs/CompressedImage"; }

/// What a topic of images holds, by its first message; empty for other topics.
struct Content {
  std::optional<double> depth_scale;
  bool color = false;
  ros::Image first;
  BagBytes bytes;  ///< that `first` refers to
};
std::optional<Content> content_of(const Bag& bag, const BagTopic& topic) {
  if ((topic.type != "sensor_msgs/Image" && !is_compressed(topic)) || topic.messages.empty()) return std::nullopt;
  Content content;
  content.bytes = bag.read(topic.messages.front());
  content.first = ros::parse_image(content.bytes.bytes, is_compressed(topic), name_of(bag, topic));
  content.depth_scale = ros::depth_scale(content.first);
  content.color = ros::is_color(content.first);
  return content;
}

/// How much a topic's name says that it is the one: registered and rectified images before raw ones.
int rank(std::string_view name, bool depth) {
  const auto has = [&](std::string_view word) { return name.find(word) != std::string_view::npos; };
  int rank = 0;
  if (depth) rank += 8 * has("depth") + 4 * (has("registered") || has("aligned")) - 16 * (has("infra") || has("/ir"));
  if (!depth)
    rank += 8 * (has("rgb") || has("color") || has("colour")) - 4 * has("mono") - 16 * (has("infra") || has("/ir"));
  return rank + 2 * has("rect");
}

std::string list_topics(const Bag& bag) {
  std::string text;
  for (const BagTopic& topic : bag.topics())
    text += fmt::format("\n  {} ({}, {} messages)", topic.name, topic.type, topic.messages.size());
  return text.empty() ? "\n  none" : text;
}

/// The named topic, or the best of those that hold depth (or colour). Null if there is none.
const BagTopic* choose_topic(const Bag& bag, const std::string& named, bool depth) {
  const BagTopic* best = nullptr;
  for (const BagTopic& topic : bag.topics()) {
    if (!named.empty() && topic.name != named) continue;
    const auto content = content_of(bag, topic);
    if (!content || !(depth ? content->depth_scale.has_value() : content->color)) continue;
    if (best == nullptr || rank(topic.name, depth) > rank(best->name, depth)) best = &topic;
  }
  if (best == nullptr && !named.empty())
    throw Error(
        fmt::format("has no {} under '{}'; its topics are{}", depth ? "depth" : "colour", named, list_topics(bag)),
        bag.path(), "name one that holds images");
  return best;
}

ImageTopic list_messages(const Bag& bag, const BagTopic& topic, std::vector<std::string>* notes) {
  ImageTopic result{&topic, is_compressed(topic), {}};
  for (const BagMessage& message : topic.messages) {
    const BagBytes bytes = bag.read(message);
    const Nanoseconds time = ros::parse_image(bytes.bytes, result.compressed, name_of(bag, topic)).time;
    result.messages.push_back({time != 0 ? time : message.time, message});
  }
  sort_and_thin(&result.messages, "images", notes);
  return result;
}

/// The camera_info that stands beside a topic of images: /a/b/image_raw/compressed has it under /a/b.
std::optional<CameraChoice> camera_beside(const Bag& bag, const BagTopic& image) {
  std::string folder = image.name;
  for (int up = 0; up < 2 && folder.find('/') != std::string::npos; ++up) {
    folder.erase(folder.rfind('/'));
    for (const BagTopic& topic : bag.topics()) {
      if (topic.name != folder + "/camera_info" || topic.type != "sensor_msgs/CameraInfo" || topic.messages.empty())
        continue;
      const ros::CameraInfo info = ros::parse_camera_info(bag.read(topic.messages.front()).bytes, name_of(bag, topic));
      const bool rectified = image.name.find("rect") != std::string::npos && info.rectified.is_valid();
      if (!rectified && !info.camera.is_valid()) continue;  // not calibrated
      return CameraChoice{rectified ? info.rectified : info.camera, rectified ? Distortion{} : info.distortion,
                          "the bag's " + topic.name, false};
    }
  }
  return std::nullopt;
}

class BagSequence : public Sequence {
 public:
  BagSequence(SequenceInfo found, std::unique_ptr<Bag> bag, const BagTopic* depth, const BagTopic* color,
              const BagTopic* imu, std::vector<BagFrame> frames, std::vector<Nanoseconds> times, double scale,
              bool undistort)
      : Sequence(std::move(found), std::move(times)),
        bag_(std::move(bag)),
        depth_(depth),
        color_(color),
        imu_(imu),
        frames_(std::move(frames)),
        scale_(scale),
        undistorter_(info().camera, undistort ? info().distortion : Distortion{}) {}

  Frame read(int index) const override {
    if (index < 0 || index >= size())
      throw Error(fmt::format("there is no frame {} among {}", index, size()), info().path, "count frames from 0");
    const BagFrame& recorded = frames_[static_cast<std::size_t>(index)];
    const std::string name = fmt::format("{} frame {}", name_of(*bag_, *depth_), index);
    const BagBytes bytes = bag_->read(recorded.depth.message);
    const ros::Image image = ros::parse_image(bytes.bytes, is_compressed(*depth_), name);
    if (ros::depth_scale(image) != scale_) throw Error("the depth's encoding changes", name, "choose another topic");
    Frame frame{index, recorded.depth.time, ros::depth_of(image, name), info().depth_scale, {}};
    check_size(frame.depth.width, frame.depth.height, name);
    undistorter_.apply(frame.depth);
    if (recorded.color) frame.color = read_color(*recorded.color, index);
    return frame;
  }

  ImuRecording read_imu(std::vector<std::string>* notes) const override {
    ImuRecording recording;
    if (imu_ == nullptr) return recording;
    for (const BagMessage& message : imu_->messages) {
      const ros::Imu imu = ros::parse_imu(bag_->read(message).bytes, name_of(*bag_, *imu_));
      recording.has_gyroscope = recording.has_gyroscope && imu.has_gyroscope;
      const ImuSample& sample = imu.sample;
      if (imu.has_accelerometer && sample.specific_force.allFinite() && sample.angular_rate.allFinite())
        recording.samples.push_back(sample);
    }
    sort_and_thin(&recording.samples, "samples", notes);
    return recording;
  }

 private:
  ColorImage read_color(const StampedMessage& message, int index) const {
    const std::string name = fmt::format("{} of frame {}", name_of(*bag_, *color_), index);
    const BagBytes bytes = bag_->read(message.message);
    ColorImage color = ros::color_of(ros::parse_image(bytes.bytes, is_compressed(*color_), name), name);
    check_size(color.width, color.height, name);
    undistorter_.apply(color);
    return color;
  }

  void check_size(int width, int height, const std::string& name) const {
    const Pinhole& camera = info().camera;
    if (width != camera.width || height != camera.height)
      throw Error(
          fmt::format("is {}x{}, but the sequence's images are {}x{}", width, height, camera.width, camera.height),
          name, "choose a topic whose images are of one size");
  }

  std::unique_ptr<Bag> bag_;
  const BagTopic *depth_, *color_, *imu_;
  std::vector<BagFrame> frames_;
  double scale_;
  Undistorter undistorter_;
};

/// Colour is taken for registered to depth if it has its size.
const BagTopic* fitting_color(const Bag& bag, const SequenceOptions& options, const DepthImage& depth,
                              std::vector<std::string>* notes) {
  const BagTopic* topic = options.color ? choose_topic(bag, options.color_topic, false) : nullptr;
  if (topic == nullptr) return nullptr;
  const ColorImage first = ros::color_of(content_of(bag, *topic)->first, name_of(bag, *topic));
  if (first.width == depth.width && first.height == depth.height) return topic;
  notes->push_back(fmt::format("the colour images ({}) are {}x{} and depth is {}x{}; going on without colour",
                               topic->name, first.width, first.height, depth.width, depth.height));
  return nullptr;
}

const BagTopic* imu_topic(const Bag& bag) {
  for (const BagTopic& topic : bag.topics())
    if (topic.type == "sensor_msgs/Imu" && !topic.messages.empty()) return &topic;
  return nullptr;
}

}  // namespace

std::unique_ptr<Sequence> open_ros_bag(const std::string& path, const SequenceOptions& options) {
  SequenceInfo info;
  info.path = path;
  info.format = "ROS bag";
  auto bag = std::make_unique<Bag>(path, &info.notes);
  const BagTopic* depth = choose_topic(*bag, options.depth_topic, true);
  if (depth == nullptr)
    throw Error("has no topic with depth images that can be read; its topics are" + list_topics(*bag), path,
                "give a bag with 16UC1, 32FC1 or compressedDepth images");
  const Content content = *content_of(*bag, *depth);
  const DepthImage first = ros::depth_of(content.first, name_of(*bag, *depth));
  const BagTopic* color = fitting_color(*bag, options, first, &info.notes);

  const CameraChoice choice =
      choose_camera(options, {path, "kinect", true, first.width, first.height, camera_beside(*bag, *depth)});
  info.camera = choice.camera;
  info.distortion = choice.distortion;
  info.camera_source = choice.source;
  info.depth_scale = options.depth_scale.value_or(*content.depth_scale);
  info.depth_scale_source = options.depth_scale ? "given" : "the encoding of " + depth->name;
  if (choice.is_guess)
    info.notes.emplace_back("the bag has no camera_info for its depth; the Kinect's default intrinsics are used");

  const ImageTopic depths = list_messages(*bag, *depth, &info.notes);
  const ImageTopic colors = color != nullptr ? list_messages(*bag, *color, &info.notes) : ImageTopic{};
  std::vector<BagFrame> frames;
  std::vector<Nanoseconds> times;
  for (const StampedMessage& message : depths.messages) {
    frames.push_back(
        {message, nearest_in_time(colors.messages, message.time, from_seconds(options.max_time_difference))});
    times.push_back(message.time);
    info.color_frames += frames.back().color ? 1 : 0;
  }
  const BagTopic* imu = imu_topic(*bag);
  return std::make_unique<BagSequence>(std::move(info), std::move(bag), depth, color, imu, std::move(frames),
                                       std::move(times), *content.depth_scale, options.undistort);
}

}  // namespace plumbline
