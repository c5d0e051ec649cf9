#include "io/containers/ros_topics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "io/camera.h"
#include "io/imu/joined_sensors.h"
#include "io/imu_file.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline::ros {
namespace {

enum class Kind { depth, color, infrared, unknown };

bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

/// What a topic's name says that it holds. "aligned_depth_to_color" is depth.
Kind kind_of(std::string_view topic) {
  const std::string name = lower(topic);
  if (has(name, "infra") || contains_word(name, "ir") || contains_word(name, "ir_0")) return Kind::infrared;
  if (has(name, "depth")) return Kind::depth;
  if (has(name, "rgb") || has(name, "color") || has(name, "colour")) return Kind::color;
  return Kind::unknown;
}

/// How much a topic's name says that it is the one: registered and rectified images before raw ones.
int rank(std::string_view topic, bool depth) {
  const std::string name = lower(topic);
  int rank = 8 * (kind_of(name) == (depth ? Kind::depth : Kind::color)) + 2 * has(name, "rect");
  if (depth) rank += 4 * (has(name, "registered") || has(name, "aligned")) - 4 * has(name, "confidence");
  if (!depth) rank -= 4 * has(name, "mono");
  return rank;
}

/// How many parts of their names, between slashes, two topics share from the front.
int common_parts(std::string_view a, std::string_view b) {
  int parts = 0;
  std::size_t i = 1;
  for (; i < a.size() && i < b.size() && a[i] == b[i]; ++i)
    if (a[i] == '/') ++parts;
  return parts;
}

/// `beside`: empty, or the depth topic whose colour is wanted.
const MessageTopic* choose(const MessageStore& store, const std::string& named, bool depth,
                           const std::string& beside = "") {
  const auto rank_of = [&](const MessageTopic& topic) {
    return rank(topic.name, depth) + (beside.empty() ? 0 : 16 * std::min(common_parts(topic.name, beside), 1));
  };
  const MessageTopic* best = nullptr;
  for (const MessageTopic& topic : store.topics()) {
    if (topic.messages.empty() || (topic.type != "sensor_msgs/Image" && !is_compressed(topic))) continue;
    if (named.empty() ? kind_of(topic.name) == Kind::infrared : topic.name != named) continue;
    if (named.empty() && !depth && kind_of(topic.name) == Kind::depth && !has(lower(topic.name), "rgb")) continue;
    const StoredImage first = read_image(store, topic, topic.messages.front());
    if (!(depth ? depth_scale(first.image).has_value() : is_color(first.image))) continue;
    if (best == nullptr || rank_of(topic) > rank_of(*best)) best = &topic;
  }
  if (best == nullptr && !named.empty())
    throw Error(
        fmt::format("has no {} under '{}'; its topics are{}", depth ? "depth" : "colour", named, list_topics(store)),
        store.path(), "name one that holds images");
  return best;
}

/// Negative: not the camera of that image.
int fitness(const MessageTopic& topic, const CameraInfo& info, const MessageTopic& image, std::string_view frame,
            int width, int height) {
  const Kind of_info = kind_of(topic.name), of_image = kind_of(image.name);
  const bool same_frame = !frame.empty() && info.frame == frame;
  const bool registered = of_image == Kind::depth && is_registered_by_name(image.name, "");
  const bool other_kind = of_info != Kind::unknown && of_image != Kind::unknown && of_info != of_image &&
                          !(registered && of_info == Kind::color);
  const int parts = common_parts(topic.name, image.name);
  if (other_kind || (parts == 0 && !same_frame && of_info != of_image)) return -1;
  const bool size_known = info.width > 0 && info.height > 0;
  const bool same_size = info.width == width && info.height == height;
  return 2 * parts + 3 * same_frame + (of_info == of_image ? 4 : 0) + (same_size ? 8 : 0) - (size_known && !same_size);
}

/// The first parts, "/device_0/sensor_1" or "/device_0/sensor_1/Color_0", of a topic in librealsense's recordings;
/// empty for others.
std::string realsense_prefix(std::string_view topic, int parts) {
  if (!topic.starts_with("/device_")) return "";
  std::size_t end = 0;
  for (int i = 0; i < parts && end != std::string_view::npos; ++i) end = topic.find('/', end + 1);
  return std::string(topic.substr(0, end));
}

/// Whether the topic has readings of each sensor: by its name, else by what its messages say.
struct ImuContent {
  bool gyroscope = false, accelerometer = false;
  std::string frame;
};
ImuContent content_of(const MessageStore& store, const MessageTopic& topic) {
  constexpr std::size_t kLookedAt = 50;
  ImuContent content;
  bool turns = false, feels = false;
  for (std::size_t i = 0; i < std::min(kLookedAt, topic.messages.size()); ++i) {
    const MessageBytes bytes = store.read(topic.messages[i]);
    const Imu imu = parse_imu(bytes.bytes, topic.wire, name_of(store, topic));
    if (i == 0) content = {imu.has_gyroscope, imu.has_accelerometer, imu.frame};
    turns = turns || !imu.sample.angular_rate.isZero(0);
    feels = feels || !imu.sample.specific_force.isZero(0);
  }
  const std::string name = lower(topic.name);
  const bool accel = has(name, "accel"), gyro = has(name, "gyro");
  if (accel != gyro) return {gyro, accel, content.frame};  // such topics have zeros for the other sensor
  content.accelerometer = content.accelerometer && feels;
  content.gyroscope = content.gyroscope && (turns || !has(name, "accel"));
  return content;
}

std::vector<ImuSample> samples_of(const MessageStore& store, const MessageTopic& topic,
                                  std::vector<std::string>* notes) {
  std::vector<ImuSample> samples;
  for (const StoredMessage& message : topic.messages) {
    const MessageBytes bytes = store.read(message);
    ImuSample sample = parse_imu(bytes.bytes, topic.wire, name_of(store, topic)).sample;
    if (sample.time == 0) sample.time = message.time;
    if (sample.specific_force.allFinite() && sample.angular_rate.allFinite()) samples.push_back(sample);
  }
  sort_and_thin(&samples, "samples", notes);
  return samples;
}

}  // namespace

std::string name_of(const MessageStore& store, const MessageTopic& topic) { return store.path() + " " + topic.name; }

bool is_compressed(const MessageTopic& topic) { return topic.type == "sensor_msgs/CompressedImage"; }

StoredImage read_image(const MessageStore& store, const MessageTopic& topic, const StoredMessage& message) {
  StoredImage result;
  result.bytes = store.read(message);
  result.image = parse_image(result.bytes.bytes, topic.wire, is_compressed(topic), name_of(store, topic));
  return result;
}

std::string list_topics(const MessageStore& store) {
  std::string text;
  for (const MessageTopic& topic : store.topics())
    text += fmt::format("\n  {} ({}, {} messages)", topic.name, topic.type, topic.messages.size());
  return text.empty() ? "\n  none" : text;
}

const MessageTopic* choose_depth(const MessageStore& store, const std::string& named) {
  return choose(store, named, true);
}

const MessageTopic* choose_color(const MessageStore& store, const std::string& named, const MessageTopic& depth) {
  return choose(store, named, false, depth.name);
}

std::vector<std::string> other_depth_topics(const MessageStore& store, const MessageTopic& taken) {
  std::vector<std::string> names;
  for (const MessageTopic& topic : store.topics()) {
    if (&topic == &taken || topic.messages.empty() || kind_of(topic.name) != Kind::depth ||
        (topic.type != "sensor_msgs/Image" && !is_compressed(topic)))
      continue;
    if (depth_scale(read_image(store, topic, topic.messages.front()).image)) names.push_back(topic.name);
  }
  return names;
}

std::string list_unread_depth(const MessageStore& store) {
  std::string text;
  for (const MessageTopic& topic : store.topics())
    if (!topic.messages.empty() && kind_of(topic.name) == Kind::depth && topic.type == "sensor_msgs/Image")
      text += fmt::format("; {} holds {}", topic.name, read_image(store, topic, topic.messages.front()).image.encoding);
  return text;
}

bool share_namespace(std::string_view a, std::string_view b) { return common_parts(a, b) > 0; }

bool is_registered_by_name(std::string_view depth, std::string_view color) {
  const std::string d = lower(depth), c = lower(color);
  return has(d, "registered") || has(d, "aligned") || has(d, "depth_to_rgb") || has(d, "depth_to_color") ||
         has(c, "to_depth") || has(c, "aligned");
}

std::optional<CameraOfTopic> camera_of(const MessageStore& store, const MessageTopic& image, const Image& first,
                                       int width, int height, std::string* refusal) {
  std::optional<CameraOfTopic> best;
  const auto refuse = [&](const MessageTopic& topic, const std::string& why) {
    if (refusal != nullptr) *refusal += fmt::format("; {} {}", topic.name, why);
  };
  int best_fitness = -1;
  for (const MessageTopic& topic : store.topics()) {
    if (topic.type != "sensor_msgs/CameraInfo" || topic.messages.empty()) continue;
    CameraInfo info;
    try {
      const MessageBytes bytes = store.read(topic.messages.front());
      info = parse_camera_info(bytes.bytes, topic.wire, name_of(store, topic));
    } catch (const Error& error) {  // another camera's, perhaps
      const std::string_view text = error.what();
      refuse(topic, "cannot be used: " + std::string(text.substr(0, text.find('\n'))));
      continue;
    }
    const bool rectified = has(lower(image.name), "rect") && info.rectified.is_valid();
    if (!rectified && !info.camera.is_valid()) {
      refuse(topic, "is not calibrated: its matrix K is zero");
      continue;
    }
    const int fit = fitness(topic, info, image, first.frame, width, height);
    if (fit <= best_fitness) continue;
    best_fitness = fit;
    best = {topic.name, rectified ? info.rectified : info.camera, rectified ? Distortion{} : info.distortion};
  }
  return best;
}

std::optional<double> realsense_depth_scale(const MessageStore& store, const MessageTopic& depth) {
  const std::string sensor = realsense_prefix(depth.name, 2);
  if (sensor.empty()) return std::nullopt;
  for (const MessageTopic& topic : store.topics()) {
    std::string name = topic.name;
    std::replace(name.begin(), name.end(), ' ', '_');
    if (topic.type != "std_msgs/Float32" || topic.messages.empty() || name != sensor + "/option/Depth_Units/value")
      continue;
    const MessageBytes bytes = store.read(topic.messages.front());
    const double metres = parse_float(bytes.bytes, topic.wire, name_of(store, topic));
    if (metres > 1e-6 && metres < 1) return std::round(1e3 / metres) / 1e3;
  }
  return std::nullopt;
}

Mountings::Mountings(const MessageStore& store) {
  for (const MessageTopic& topic : store.topics()) {
    if (topic.messages.empty()) continue;
    const std::string name = name_of(store, topic);
    const auto first = [&] { return store.read(topic.messages.front()); };
    try {
      if (topic.type == "geometry_msgs/Transform" && has(topic.name, "/tf/"))
        streams_.push_back({realsense_prefix(topic.name, 3), parse_transform(first().bytes, topic.wire, name)});
      if (topic.type.ends_with("/Extrinsics"))
        extrinsics_.push_back({lower(topic.name), parse_extrinsics(first().bytes, topic.wire, name)});
      if (topic.type != "tf2_msgs/TFMessage" && topic.type != "tf/tfMessage") continue;
      std::set<std::pair<std::string, std::string>> known;
      for (const StoredMessage& message : topic.messages)
        for (Transform& transform : parse_transforms(store.read(message).bytes, topic.wire, name))
          if (known.insert({transform.parent, transform.child}).second) tree_.push_back(std::move(transform));
    } catch (const Error&) {  // what connects nothing else: the colour is then left out, which is told
    }
  }
}

std::optional<SE3> Mountings::through_tree(std::string_view first, std::string_view second) const {
  const auto bare = [](std::string_view frame) {
    return std::string(frame.starts_with('/') ? frame.substr(1) : frame);
  };
  std::map<std::string, SE3> reached = {{bare(first), SE3()}};  // frame_from_first
  std::vector<std::string> next = {bare(first)};
  while (!next.empty()) {
    const std::string frame = next.back();
    next.pop_back();
    for (const Transform& edge : tree_) {
      const std::string parent = bare(edge.parent), child = bare(edge.child);
      const bool up = child == frame, down = parent == frame;
      const std::string& other = up ? parent : child;
      if ((!up && !down) || reached.contains(other)) continue;
      reached[other] = (up ? edge.parent_from_child : edge.parent_from_child.inverse()) * reached[frame];
      next.push_back(other);
    }
  }
  const auto found = reached.find(bare(second));
  return found == reached.end() ? std::nullopt : std::optional<SE3>(found->second);
}

std::optional<Mountings::Found> Mountings::between(const MessageTopic& first, std::string_view first_frame,
                                                   const MessageTopic& second, std::string_view second_frame) const {
  const auto stream = [&](const MessageTopic& topic) {
    const std::string prefix = realsense_prefix(topic.name, 3);
    return std::find_if(streams_.begin(), streams_.end(),
                        [&](const OfStream& s) { return !prefix.empty() && s.prefix == prefix; });
  };
  if (const auto a = stream(first), b = stream(second); a != streams_.end() && b != streams_.end())
    return Found{b->stream_from_reference * a->stream_from_reference.inverse(), "the recording's stream extrinsics"};
  for (const Extrinsics& e : extrinsics_)
    if (e.topic.ends_with("/depth_to_color") && kind_of(first.name) == Kind::depth &&
        kind_of(second.name) == Kind::color)
      return Found{e.second_from_first, "the topic " + e.topic};
  if (first_frame.empty() || second_frame.empty() || first_frame == second_frame) return std::nullopt;
  if (const auto path = through_tree(first_frame, second_frame)) return Found{*path, "the recording's tf"};
  return std::nullopt;
}

ImuTopics imu_topics(const MessageStore& store) {
  ImuTopics apart;
  for (const MessageTopic& topic : store.topics()) {
    if (topic.type != "sensor_msgs/Imu" || topic.messages.empty()) continue;
    const ImuContent content = content_of(store, topic);
    if (content.gyroscope && content.accelerometer) return {&topic, &topic, content.frame};
    if (content.gyroscope && apart.gyroscope == nullptr) apart.gyroscope = &topic, apart.frame = content.frame;
    if (content.accelerometer && apart.accelerometer == nullptr) apart.accelerometer = &topic;
    if (apart.frame.empty()) apart.frame = content.frame;
  }
  return apart;
}

namespace {

ImuRecording read_samples(const MessageStore& store, const ImuTopics& topics, std::vector<std::string>* notes) {
  ImuRecording recording;
  recording.has_gyroscope = topics.gyroscope != nullptr;
  recording.has_accelerometer = topics.accelerometer != nullptr;
  if (topics.accelerometer == nullptr) {
    if (topics.gyroscope != nullptr) recording.samples = samples_of(store, *topics.gyroscope, notes);
    return recording;
  }
  const std::vector<ImuSample> forces = samples_of(store, *topics.accelerometer, notes);
  if (topics.gyroscope == nullptr || topics.gyroscope == topics.accelerometer || forces.empty()) {
    recording.samples = forces;
    return recording;
  }
  recording.samples = join_sensors(samples_of(store, *topics.gyroscope, notes), forces);
  add_note(notes, fmt::format("gyroscope and accelerometer come on topics apart ({} and {}) and were joined",
                              topics.gyroscope->name, topics.accelerometer->name));
  return recording;
}

}  // namespace

ImuRecording read_imu(const MessageStore& store, const ImuTopics& topics, std::vector<std::string>* notes) {
  ImuRecording recording = read_samples(store, topics, notes);
  settle_units(&recording, notes);
  return recording;
}

}  // namespace plumbline::ros
