#include "io/containers/sens.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "io/camera.h"
#include "io/images/image_size.h"
#include "io/images/jpeg.h"
#include "io/images/png.h"
#include "io/pose_matrix.h"
#include "io/recording.h"
#include "io/registration.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"

namespace plumbline {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr const char* kSensAdvice = "copy or download the file again";
constexpr std::uint32_t kVersion = 4;
constexpr std::uint64_t kMaxNameBytes = 1024, kSensImuBytes = 128;
constexpr int kMaxFrames = 10'000'000;

enum class ColorPacking { raw, png, jpeg, unknown };
enum class DepthPacking { raw, zlib, occi, unknown };

/// Values one after the other.
class Cursor {
 public:
  explicit Cursor(const RandomAccessFile& file) : file_(file) {}

  std::string take_bytes(std::size_t size) {
    std::string bytes = file_.read(at_, size);
    at_ += size;
    return bytes;
  }
  template <class T>
  T take() {
    T value;
    std::memcpy(&value, take_bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::array<float, 16> take_matrix() { return take<std::array<float, 16>>(); }
  void skip(std::uint64_t size) {
    if (size > left()) throw Error("ends early", file_.path(), kSensAdvice);
    at_ += size;
  }
  std::uint64_t at() const { return at_; }
  std::uint64_t left() const { return file_.size() - at_; }

 private:
  const RandomAccessFile& file_;
  std::uint64_t at_ = 0;
};

struct SensCamera {
  std::array<float, 16> intrinsic{}, extrinsic{};  ///< 4×4, in rows
};

struct Header {
  std::string sensor;
  SensCamera color, depth;
  ColorPacking color_packing{};
  DepthPacking depth_packing{};
  std::uint32_t color_width = 0, color_height = 0, depth_width = 0, depth_height = 0;
  float depth_shift = 0;  ///< readings a metre
  std::uint64_t frames = 0;
};

/// Where a frame's images lie.
struct Place {
  std::uint64_t offset = 0, size = 0;
};

struct SensFrame {
  Nanoseconds time = 0;
  std::array<float, 16> world_from_camera{};  ///< −∞ where it was not tracked
  Place color, depth;
};

struct Contents {
  Header header;
  std::vector<SensFrame> frames;
  std::uint64_t imu_offset = 0, imu_count = 0;
};

Header read_header(Cursor* cursor, const std::string& path) {
  Header h;
  if (cursor->take<std::uint32_t>() != kVersion) throw Error("is a .sens of another version than 4", path, kSensAdvice);
  const auto length = cursor->take<std::uint64_t>();
  if (length > kMaxNameBytes) throw Error("is no .sens of ScanNet", path, kSensAdvice);
  h.sensor = cursor->take_bytes(length);
  h.color = {cursor->take_matrix(), cursor->take_matrix()};
  h.depth = {cursor->take_matrix(), cursor->take_matrix()};
  const auto color = cursor->take<std::uint32_t>(), depth = cursor->take<std::uint32_t>();
  h.color_packing = static_cast<ColorPacking>(std::min(color, std::uint32_t{3}));
  h.depth_packing = static_cast<DepthPacking>(std::min(depth, std::uint32_t{3}));
  for (std::uint32_t* side : {&h.color_width, &h.color_height, &h.depth_width, &h.depth_height})
    *side = cursor->take<std::uint32_t>();
  h.depth_shift = cursor->take<float>();
  h.frames = cursor->take<std::uint64_t>();
  const bool sizes =
      h.depth_width > 0 && h.depth_height > 0 && h.depth_width <= kMaxImageSide && h.depth_height <= kMaxImageSide;
  if (!sizes || h.color_width > kMaxImageSide || h.color_height > kMaxImageSide)
    throw Error("has images of an impossible size", path, kSensAdvice);
  if (h.depth_packing != DepthPacking::raw && h.depth_packing != DepthPacking::zlib)
    throw Error("packs its depth in a way that is not read (occi)", path,
                "unpack it with ScanNet's SensReader, and give that folder");
  return h;
}

SensFrame read_frame_head(Cursor* cursor, bool* has_stamps) {
  SensFrame frame;
  frame.world_from_camera = cursor->take_matrix();
  const auto color_stamp = cursor->take<std::uint64_t>(), depth_stamp = cursor->take<std::uint64_t>();
  frame.color.size = cursor->take<std::uint64_t>();
  frame.depth.size = cursor->take<std::uint64_t>();
  frame.color.offset = cursor->at();
  cursor->skip(frame.color.size);
  frame.depth.offset = cursor->at();
  cursor->skip(frame.depth.size);
  const std::uint64_t stamp = depth_stamp != 0 ? depth_stamp : color_stamp;
  *has_stamps = *has_stamps && stamp < 9'000'000'000'000'000;
  frame.time = *has_stamps ? static_cast<Nanoseconds>(stamp) * 1000 : 0;
  return frame;
}

/// The stamps are microseconds; those of older recordings are all zero.
void set_times(bool has_stamps, std::vector<SensFrame>* frames, std::vector<std::string>* notes) {
  const bool differ = has_stamps && std::any_of(frames->begin(), frames->end(), [&](const SensFrame& frame) {
                        return frame.time != frames->front().time;
                      });
  if (differ || frames->size() < 2) return sort_and_thin(frames, "frames", notes);
  for (std::size_t i = 0; i < frames->size(); ++i) (*frames)[i].time = time_at_30_hz(static_cast<long long>(i));
  notes->emplace_back("the frames have no stamps and are taken to be 1/30 s apart, a guess");
}

Contents index(const RandomAccessFile& file, std::vector<std::string>* notes) {
  Cursor cursor(file);
  Contents contents;
  contents.header = read_header(&cursor, file.path());
  bool has_stamps = true;
  const std::uint64_t count = std::min<std::uint64_t>(contents.header.frames, kMaxFrames);
  while (contents.frames.size() < count) {
    try {
      contents.frames.push_back(read_frame_head(&cursor, &has_stamps));
    } catch (const Error&) {
      notes->push_back(
          fmt::format("the file ends early: {} of its {} frames are there", contents.frames.size(), count));
      break;
    }
  }
  if (contents.frames.empty()) throw Error("has no frames", file.path(), kSensAdvice);
  if (contents.frames.size() == contents.header.frames && cursor.left() >= sizeof(std::uint64_t)) {
    contents.imu_count = cursor.take<std::uint64_t>();
    contents.imu_offset = cursor.at();
    contents.imu_count = std::min(contents.imu_count, cursor.left() / kSensImuBytes);
  }
  set_times(has_stamps, &contents.frames, notes);
  return contents;
}

Pinhole pinhole(const SensCamera& camera, std::uint32_t width, std::uint32_t height) {
  const std::array<float, 16>& m = camera.intrinsic;
  return {m[0], m[5], m[2], m[6], static_cast<int>(width), static_cast<int>(height)};
}

std::optional<SE3> motion(const std::array<float, 16>& m, const std::string& path) {
  return pose_of_matrix(std::vector<double>(m.begin(), m.end()), path);
}

class SensSequence : public Sequence {
 public:
  SensSequence(SequenceInfo found, std::vector<Nanoseconds> times, Contents contents,
               std::optional<ColorRegistration> registration)
      : Sequence(std::move(found), std::move(times)),
        file_(info().path),
        contents_(std::move(contents)),
        registration_(std::move(registration)) {}

  Frame read(int index) const override {
    if (index < 0 || index >= size())
      throw Error(fmt::format("there is no frame {} among {}", index, size()), info().path, "count frames from 0");
    const SensFrame& stored = contents_.frames[static_cast<std::size_t>(index)];
    Frame frame{index, stored.time, read_depth(stored.depth, index), info().depth_scale, {}};
    if (registration_)
      frame.color = registration_->apply(frame.depth, frame.depth_scale, read_color(stored.color, index));
    return frame;
  }

  /// Samples of CoreMotion: rad/s, and g with the sign of the acceleration, gravity apart.
  ImuRecording read_imu(std::vector<std::string>* notes) const override {
    ImuRecording recording;
    for (std::uint64_t i = 0; i < contents_.imu_count; ++i) {
      const std::string bytes = file_.read(contents_.imu_offset + i * kSensImuBytes, kSensImuBytes);
      const ImuSample sample = imu_sample(bytes);
      if (sample.specific_force.allFinite() && sample.angular_rate.allFinite()) recording.samples.push_back(sample);
    }
    sort_and_thin(&recording.samples, "samples", notes);
    if (!recording.samples.empty())
      add_note(notes,
               "the specific force is acceleration and gravity of CoreMotion, in g, with the opposite sign, a guess");
    return recording;
  }

  Trajectory read_groundtruth(std::vector<std::string>* notes) const override {
    Trajectory poses;
    for (const SensFrame& frame : contents_.frames)
      if (const auto pose = motion(frame.world_from_camera, info().path)) poses.push_back({frame.time, *pose});
    if (const std::size_t lost = contents_.frames.size() - poses.size(); lost > 0)
      add_note(notes, fmt::format("{} poses that are not finite were left out", lost));
    return poses;
  }

 private:
  std::string frame_name(const char* what, int index) const {
    return fmt::format("{} ({} of frame {})", info().path, what, index);
  }

  DepthImage read_depth(const Place& place, int index) const {
    DepthImage depth(info().camera.width, info().camera.height);
    const std::size_t expected = 2 * depth.pixels.size();
    const std::string bytes = file_.read(place.offset, place.size);
    uLongf size = expected;
    auto* out = reinterpret_cast<Bytef*>(depth.pixels.data());
    if (contents_.header.depth_packing == DepthPacking::raw) {
      size = bytes.size();
      if (size == expected) std::memcpy(out, bytes.data(), size);
    } else if (uncompress(out, &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != Z_OK) {
      size = 0;
    }
    if (size != expected)
      throw Error("the depth is damaged or of another size", frame_name("depth", index), kSensAdvice);
    return depth;
  }

  ColorImage read_color(const Place& place, int index) const {
    const Pinhole& camera = registration_->color;
    const std::string bytes = file_.read(place.offset, place.size), name = frame_name("colour", index);
    ColorImage color(camera.width, camera.height, 3);
    if (contents_.header.color_packing == ColorPacking::raw && bytes.size() == color.pixels.size())
      std::memcpy(color.pixels.data(), bytes.data(), bytes.size());
    else
      color = is_jpeg(bytes) ? decode_jpeg(bytes, name) : decode_color_png(bytes, name);
    if (color.width != camera.width || color.height != camera.height)
      throw Error("the colour image is of another size", name, kSensAdvice);
    return color;
  }

  /// Rotation rate, acceleration, magnetic field, attitude, gravity (three doubles each), and microseconds.
  static ImuSample imu_sample(const std::string& bytes) {
    std::array<double, 15> v{};
    std::uint64_t time = 0;
    std::memcpy(v.data(), bytes.data(), sizeof v);
    std::memcpy(&time, bytes.data() + sizeof v, sizeof time);
    constexpr double kGravity = 9.80665;
    ImuSample sample;
    sample.time = static_cast<Nanoseconds>(std::min<std::uint64_t>(time, 9'000'000'000'000'000)) * 1000;
    sample.angular_rate = {v[0], v[1], v[2]};
    sample.specific_force = -kGravity * Eigen::Vector3d(v[3] + v[12], v[4] + v[13], v[5] + v[14]);
    return sample;
  }

  RandomAccessFile file_;
  Contents contents_;
  std::optional<ColorRegistration> registration_;
};

/// Colour through the intrinsics and extrinsics of both cameras; without, a note says why not.
/// color_from_depth; nothing where the extrinsics are no motions.
std::optional<SE3> between_cameras(const Header& header, const std::string& path) {
  try {
    const std::optional<SE3> color = motion(header.color.extrinsic, path), depth = motion(header.depth.extrinsic, path);
    if (color && depth) return color->inverse() * *depth;
  } catch (const Error&) {  // told by the caller
  }
  return std::nullopt;
}

std::optional<ColorRegistration> registration_of(const Header& header, const Pinhole& depth, const std::string& path,
                                                 std::vector<std::string>* notes) {
  const Pinhole color = pinhole(header.color, header.color_width, header.color_height);
  if (!color.is_valid() || header.color_packing == ColorPacking::unknown) {
    notes->emplace_back("colour is not used, because its camera or its packing is not told");
    return std::nullopt;
  }
  const std::optional<SE3> color_from_depth = between_cameras(header, path);
  if (!color_from_depth)
    notes->emplace_back("the cameras' extrinsics are none; colour is taken to be of the depth camera's place, a guess");
  return ColorRegistration{depth, color, {}, color_from_depth.value_or(SE3())};
}

void set_camera_and_scale(const Header& header, const SequenceOptions& options, SequenceInfo* info) {
  CameraClues clues{info->path, "", false, static_cast<int>(header.depth_width), static_cast<int>(header.depth_height),
                    {}};
  clues.calibration = {
      pinhole(header.depth, header.depth_width, header.depth_height), {}, "the recording's header", false};
  const CameraChoice choice = choose_camera(options, clues);
  info->camera = choice.camera;
  info->camera_source = choice.source;
  const bool told = std::isfinite(header.depth_shift) && header.depth_shift > 0;
  info->depth_scale = options.depth_scale.value_or(told ? static_cast<double>(header.depth_shift) : 1000);
  info->depth_scale_source = options.depth_scale ? "given" : told ? "the recording's header" : "millimetres";
  info->depth_scale_is_guess = !options.depth_scale && !told;
}

}  // namespace

bool is_sens(std::string_view bytes) {
  if (bytes.size() < 12) return false;
  std::uint32_t version = 0;
  std::uint64_t length = 0;
  std::memcpy(&version, bytes.data(), 4);
  std::memcpy(&length, bytes.data() + 4, 8);
  return version == kVersion && length <= kMaxNameBytes;
}

std::unique_ptr<Sequence> open_sens_recording(const std::string& path, const SequenceOptions& options) {
  SequenceInfo info;
  info.path = path;
  info.format = "ScanNet .sens";
  const RandomAccessFile file(path);
  Contents contents = index(file, &info.notes);
  set_camera_and_scale(contents.header, options, &info);
  std::optional<ColorRegistration> registration;
  if (options.color) registration = registration_of(contents.header, info.camera, path, &info.notes);
  info.groundtruth = path;
  std::vector<Nanoseconds> times;
  for (const SensFrame& frame : contents.frames) times.push_back(frame.time);
  info.color_frames = registration ? static_cast<int>(times.size()) : 0;
  return std::make_unique<SensSequence>(std::move(info), std::move(times), std::move(contents),
                                        std::move(registration));
}

}  // namespace plumbline
