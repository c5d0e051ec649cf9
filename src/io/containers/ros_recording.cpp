// Recordings of ROS 1, ROS 2 and librealsense as sequences.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/undistort.h"
#include "io/camera.h"
#include "io/containers/message_store.h"
#include "io/containers/ros_messages.h"
#include "io/containers/ros_topics.h"
#include "io/recorded_camera.h"
#include "io/recording.h"
#include "io/registration.h"
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
  StoredMessage message;
};

struct RecordedFrame {
  StampedMessage depth;
  std::optional<StampedMessage> color = {};
};

std::vector<StampedMessage> list_messages(const MessageStore& store, const MessageTopic& topic,
                                          std::vector<std::string>* notes) {
  std::vector<StampedMessage> result;
  for (const StoredMessage& message : topic.messages) {
    const MessageBytes bytes = store.read_beginning(message, ros::kHeaderBytes);
    const Nanoseconds time = ros::parse_stamp(bytes.bytes, topic.wire, ros::name_of(store, topic));
    result.push_back({time != 0 ? time : message.time, message});
  }
  sort_and_thin(&result, "images", notes);
  return result;
}

/// The topic of colour, and what brings it to the depth's pixels; without that it is there already.
struct Color {
  const MessageTopic* topic = nullptr;
  std::optional<ColorRegistration> registration = {};
};

/// What read() needs of a recording.
struct Parts {
  std::unique_ptr<MessageStore> store;
  const MessageTopic* depth = nullptr;
  Color color;
  ros::ImuTopics imu;
  std::vector<RecordedFrame> frames;
  double encoding_scale = 0;  ///< readings per metre by the depth's encoding
  double float_unit = 1;      ///< what 1 means in depth of real numbers, metres
  bool undistort = true;
};

class RosSequence : public Sequence {
 public:
  RosSequence(SequenceInfo found, std::vector<Nanoseconds> times, Parts parts)
      : Sequence(std::move(found), std::move(times)),
        parts_(std::move(parts)),
        undistorter_(info().camera, parts_.undistort ? info().distortion : Distortion{}) {}

  Frame read(int index) const override {
    if (index < 0 || index >= size())
      throw Error(fmt::format("there is no frame {} among {}", index, size()), info().path, "count frames from 0");
    const RecordedFrame& recorded = parts_.frames[static_cast<std::size_t>(index)];
    const std::string name = fmt::format("{} frame {}", ros::name_of(*parts_.store, *parts_.depth), index);
    const ros::StoredImage stored = ros::read_image(*parts_.store, *parts_.depth, recorded.depth.message);
    if (ros::depth_scale(stored.image) != parts_.encoding_scale)
      throw Error("the depth's encoding changes", name, "choose another topic");
    Frame frame{
        index, recorded.depth.time, ros::depth_of(stored.image, name, parts_.float_unit), info().depth_scale, {}};
    check_size(frame.depth.width, frame.depth.height, name);
    undistorter_.apply(frame.depth);
    if (recorded.color) read_color(*recorded.color, &frame);
    return frame;
  }

  ImuRecording read_imu(std::vector<std::string>* notes) const override {
    return ros::read_imu(*parts_.store, parts_.imu, notes);
  }

 private:
  void read_color(const StampedMessage& message, Frame* frame) const {
    const MessageTopic& topic = *parts_.color.topic;
    const std::string name = fmt::format("{} of frame {}", ros::name_of(*parts_.store, topic), frame->index);
    const ros::StoredImage stored = ros::read_image(*parts_.store, topic, message.message);
    ColorImage color = ros::color_of(stored.image, name);
    if (parts_.color.registration) {
      frame->color = parts_.color.registration->apply(frame->depth, frame->depth_scale, color);
      return;
    }
    check_size(color.width, color.height, name);
    undistorter_.apply(color);
    frame->color = std::move(color);
  }

  void check_size(int width, int height, const std::string& name) const {
    const Pinhole& camera = info().camera;
    if (width != camera.width || height != camera.height)
      throw Error(
          fmt::format("is {}x{}, but the sequence's images are {}x{}", width, height, camera.width, camera.height),
          name, "choose a topic whose images are of one size");
  }

  Parts parts_;
  Undistorter undistorter_;
};

/// Whether two cameras of one size see the same pixels.
bool same_camera(const Pinhole& a, const Pinhole& b) {
  constexpr float kTolerance = 0.005f;
  const float limit = kTolerance * a.fx;
  return a.width == b.width && a.height == b.height && std::abs(a.fx - b.fx) < limit && std::abs(a.fy - b.fy) < limit &&
         std::abs(a.cx - b.cx) < limit && std::abs(a.cy - b.cy) < limit;
}

bool is_moved(const SE3& motion) {
  return motion.translation().norm() > 1e-4 || (motion.rotation() - Eigen::Matrix3d::Identity()).norm() > 1e-4;
}

/// The first message of a topic of images, and its camera.
struct Seen {
  const MessageTopic* topic = nullptr;
  ros::StoredImage first = {};
  int width = 0, height = 0;
  std::optional<ros::CameraOfTopic> camera = {};
  std::string camera_refusal = {};  ///< what is wrong with the camera_infos where none serves
};

/// Decides how colour comes to the depth's pixels. What is left out, and what is guessed, is told.
class ColorChoice {
 public:
  ColorChoice(const MessageStore& store, const SequenceOptions& options, const Seen& depth, const Pinhole& camera,
              const ros::Mountings& mountings, std::vector<std::string>* notes)
      : store_(store), options_(options), depth_(depth), camera_(camera), mountings_(mountings), notes_(notes) {}

  Color choose() {
    const MessageTopic* topic =
        options_.color ? ros::choose_color(store_, options_.color_topic, *depth_.topic) : nullptr;
    if (topic == nullptr) return {};
    try {
      return choose(*topic);
    } catch (const Error& error) {
      leave_out(*topic, error.what());
      return {};
    }
  }

 private:
  void leave_out(const MessageTopic& topic, const std::string& why) {
    notes_->push_back(fmt::format("colour ({}): not used, because {}", topic.name, why));
  }

  Color choose(const MessageTopic& topic) {
    Seen color{&topic, ros::read_image(store_, topic, topic.messages.front())};
    const ColorImage image = ros::color_of(color.first.image, ros::name_of(store_, topic));
    color.width = image.width;
    color.height = image.height;
    color.camera = ros::camera_of(store_, topic, color.first.image, image.width, image.height);
    const bool same_size = image.width == depth_.width && image.height == depth_.height;
    if (same_size && ros::is_registered_by_name(depth_.topic->name, topic.name)) return {&topic};
    return color.camera && depth_.camera ? of_two_cameras(color, same_size) : of_unknown_camera(color, same_size);
  }

  Color of_two_cameras(const Seen& color, bool same_size) {
    const auto mounting =
        mountings_.between(*depth_.topic, depth_.first.image.frame, *color.topic, color.first.image.frame);
    const bool same = same_size && same_camera(depth_.camera->camera, color.camera->camera);
    if (same && (!mounting || !is_moved(mounting->second_from_first))) {
      if (!mounting && depth_.first.image.frame != color.first.image.frame) return of_equal_cameras(color);
      return {color.topic};
    }
    if (!mounting) {
      leave_out(*color.topic, fmt::format("it is another camera's (fx {:.1f}, {}x{}; depth: fx {:.1f}, {}x{}) and the "
                                          "recording has no extrinsics between the two (tf_static or extrinsics)",
                                          color.camera->camera.fx, color.width, color.height, depth_.camera->camera.fx,
                                          depth_.width, depth_.height));
      return {};
    }
    Pinhole camera = color.camera->camera;
    if (camera.width != color.width && camera.width > 0) {  // a camera_info of the full size beside smaller images
      leave_out(*color.topic, "its camera_info is of images of another size");
      return {};
    }
    camera.width = color.width;
    camera.height = color.height;
    notes_->push_back(fmt::format("colour ({}) is brought to depth through {} and {}", color.topic->name,
                                  color.camera->topic, mounting->source));
    return {color.topic, ColorRegistration{camera_, camera, color.camera->distortion, mounting->second_from_first}};
  }

  /// Drivers give both cameras the same default intrinsics, calibrated or not.
  Color of_equal_cameras(const Seen& color) {
    const auto parts = [](const std::string& name) { return std::count(name.begin(), name.end(), '/'); };
    if (parts(depth_.topic->name) > 2 && parts(color.topic->name) > 2 &&
        !ros::share_namespace(depth_.topic->name, color.topic->name)) {
      leave_out(*color.topic, fmt::format("it is in another frame than depth ({} and {}), under another name, and the "
                                          "recording has no extrinsics between the two",
                                          color.first.image.frame, depth_.first.image.frame));
      return {};
    }
    notes_->push_back(fmt::format(
        "colour ({}) has the intrinsics of depth, though another frame of reference ({} and {}): it is taken "
        "for registered, a guess",
        color.topic->name, color.first.image.frame, depth_.first.image.frame));
    return {color.topic};
  }

  Color of_unknown_camera(const Seen& color, bool same_size) {
    if (!same_size) {
      leave_out(*color.topic,
                fmt::format("the colour images are {}x{} and depth is {}x{}, and {} has no camera_info", color.width,
                            color.height, depth_.width, depth_.height, color.camera ? "depth" : "colour"));
      return {};
    }
    if (depth_.first.image.frame != color.first.image.frame || depth_.first.image.frame.empty())
      notes_->push_back(
          fmt::format("colour ({}) has the depth's size and is taken for registered to it, a guess: one of "
                      "the two has no camera_info",
                      color.topic->name));
    return {color.topic};
  }

  const MessageStore& store_;
  const SequenceOptions& options_;
  const Seen& depth_;
  const Pinhole& camera_;
  const ros::Mountings& mountings_;
  std::vector<std::string>* notes_;
};

Seen look_at_depth(const MessageStore& store, const SequenceOptions& options) {
  Seen depth{ros::choose_depth(store, options.depth_topic)};
  if (depth.topic == nullptr)
    throw Error("has no topic with depth images that can be read" + ros::list_unread_depth(store) + "; its topics are" +
                    ros::list_topics(store),
                store.path(), "give a recording with 16UC1, mono16, 32FC1 or compressedDepth images");
  depth.first = ros::read_image(store, *depth.topic, depth.topic->messages.front());
  const DepthImage image = ros::depth_of(depth.first.image, ros::name_of(store, *depth.topic));
  depth.width = image.width;
  depth.height = image.height;
  depth.camera =
      ros::camera_of(store, *depth.topic, depth.first.image, image.width, image.height, &depth.camera_refusal);
  return depth;
}

/// The camera_info at the size of the images, which filters make smaller.
CameraChoice calibration_of(const Seen& depth) {
  CameraChoice choice{depth.camera->camera, depth.camera->distortion, "the bag's " + depth.camera->topic, false};
  const Pinhole& camera = choice.camera;
  if (camera.width == depth.width && camera.height == depth.height) return choice;
  const auto scaled = scaled_to(camera, depth.width, depth.height);
  if (!scaled) return choice;
  choice.source +=
      fmt::format(", scaled from {}x{} to the depth's {}x{}", camera.width, camera.height, depth.width, depth.height);
  choice.camera = *scaled;
  return choice;
}

void set_camera(const MessageStore& store, const SequenceOptions& options, const Seen& depth, SequenceInfo* info) {
  CameraClues clues{store.path(), "kinect", true, depth.width, depth.height, {}};
  if (depth.camera) clues.calibration = calibration_of(depth);
  const bool is_given = options.intrinsics || !options.camera.empty();
  if (!depth.camera && !is_given && (depth.width != 640 || depth.height != 480))
    throw Error(fmt::format("has no camera_info for its depth ({}, {}x{}){}", depth.topic->name, depth.width,
                            depth.height, depth.camera_refusal),
                store.path(), "give the intrinsics of the depth images with --intrinsics fx,fy,cx,cy");
  const CameraChoice choice = choose_camera(options, clues);
  info->camera = choice.camera;
  info->distortion = choice.distortion;
  info->camera_source = choice.source;
  if (choice.is_guess)
    info->notes.push_back(
        "the recording has no camera_info for its depth; the Kinect's default intrinsics are used, a "
        "guess" +
        depth.camera_refusal);
  info->camera_is_guess = choice.is_guess;
}

bool is_float(const Seen& depth) { return depth.first.image.encoding == "32FC1" && !depth.first.image.compressed; }

double share_read(const Seen& depth, double float_unit) {
  const DepthImage image = ros::depth_of(depth.first.image, "", float_unit);
  const auto read = std::count_if(image.pixels.begin(), image.pixels.end(), [](std::uint16_t v) { return v > 0; });
  return static_cast<double>(read) / static_cast<double>(image.pixels.size());
}

/// Real numbers are metres; a scale that is given says what number one metre is.
void set_float_scale(const SequenceOptions& options, const Seen& depth, double by_encoding, SequenceInfo* info) {
  info->depth_scale = by_encoding;
  info->depth_scale_source = "the encoding of " + depth.topic->name;
  if (options.depth_scale)
    info->depth_scale_source =
        fmt::format("given: {:g} in the messages is a metre, kept as {:g} readings", *options.depth_scale, by_encoding);
  else if (share_read(depth, 1) < 0.1 * share_read(depth, 1e-3))
    info->warnings.push_back(
        {fmt::format("the real numbers of {} seem to be millimetres where metres are the rule", depth.topic->name),
         "Give --depth-scale 1000 if that is right."});
}

void set_scale(const MessageStore& store, const SequenceOptions& options, const Seen& depth, double by_encoding,
               SequenceInfo* info) {
  if (is_float(depth)) return set_float_scale(options, depth, by_encoding, info);
  const auto units = ros::realsense_depth_scale(store, *depth.topic);
  info->depth_scale = options.depth_scale.value_or(units.value_or(by_encoding));
  info->depth_scale_source = options.depth_scale ? "given"
                             : units             ? "the recording's option \"Depth Units\""
                                                 : "the encoding of " + depth.topic->name;
}

/// The axes of a RealSense's inertial sensor are those of its depth camera, in librealsense and in its wrapper.
bool is_realsense(const MessageTopic& imu) {
  return imu.name.starts_with("/device_") || imu.name.ends_with("/gyro/sample") || imu.name.ends_with("/accel/sample");
}

void set_mounting(const Seen& depth, const ros::ImuTopics& imu, const ros::Mountings& mountings, SequenceInfo* info) {
  const MessageTopic* topic = imu.gyroscope != nullptr ? imu.gyroscope : imu.accelerometer;
  if (topic == nullptr) return;
  const std::string_view frame = depth.first.image.frame;
  if (const auto found = mountings.between(*depth.topic, frame, *topic, imu.frame)) {
    info->body_from_camera = found->second_from_first.rotation();
  } else if (is_realsense(*topic)) {
    info->body_from_camera = Eigen::Matrix3d::Identity();
  } else if (!frame.empty() && frame == imu.frame) {
    info->body_from_camera = Eigen::Matrix3d::Identity();
  }
}

/// Colour that no depth image has near it in time.
void note_missing_colors(const std::vector<StampedMessage>& colors, const std::vector<Nanoseconds>& times, int paired,
                         double seconds, std::vector<std::string>* notes) {
  if (colors.empty() || paired == static_cast<int>(times.size())) return;
  std::string text = fmt::format("{} of {} depth images have no colour image within {:.3g} s",
                                 static_cast<int>(times.size()) - paired, times.size(), seconds);
  if (paired == 0)
    text =
        fmt::format("colour is not used, because {}: its stamps are {:.3f} to {:.3f} s, the depth's {:.3f} to {:.3f} s",
                    text, to_seconds(colors.front().time), to_seconds(colors.back().time), to_seconds(times.front()),
                    to_seconds(times.back()));
  notes->push_back(text);
}

}  // namespace

std::unique_ptr<Sequence> open_ros_recording(const std::string& path, const SequenceOptions& options) {
  SequenceInfo info;
  info.path = path;
  Parts parts;
  parts.store = open_message_store(path, &info.notes);
  const MessageStore& store = *parts.store;
  info.format = store.format();
  const Seen depth = look_at_depth(store, options);
  if (depth.topic->name.starts_with("/device_")) info.format = "RealSense recording";
  const ros::Mountings mountings(store);
  parts.depth = depth.topic;
  parts.encoding_scale = *ros::depth_scale(depth.first.image);
  parts.undistort = options.undistort;
  set_camera(store, options, depth, &info);
  set_scale(store, options, depth, parts.encoding_scale, &info);
  if (is_float(depth)) parts.float_unit = 1 / options.depth_scale.value_or(1);
  for (const std::string& other : ros::other_depth_topics(store, *depth.topic))
    if (options.depth_topic.empty())
      info.notes.push_back(
          fmt::format("depth on {} is not used: {} was chosen; --depth-topic names another", other, depth.topic->name));
  parts.color = ColorChoice(store, options, depth, info.camera, mountings, &info.notes).choose();
  parts.imu = ros::imu_topics(store);
  set_mounting(depth, parts.imu, mountings, &info);

  std::vector<StampedMessage> colors;
  if (parts.color.topic != nullptr) colors = list_messages(store, *parts.color.topic, &info.notes);
  std::vector<Nanoseconds> times;
  for (const StampedMessage& message : list_messages(store, *depth.topic, &info.notes)) {
    parts.frames.push_back({message, nearest_in_time(colors, message.time, from_seconds(options.max_time_difference))});
    times.push_back(message.time);
    info.color_frames += parts.frames.back().color ? 1 : 0;
  }
  note_missing_colors(colors, times, info.color_frames, options.max_time_difference, &info.notes);
  return std::make_unique<RosSequence>(std::move(info), std::move(times), std::move(parts));
}

}  // namespace plumbline
