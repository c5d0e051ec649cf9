// Azure Kinect recordings. The format is that of k4arecord 1.x
// (https://learn.microsoft.com/azure/kinect-dk/record-file-format).
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/undistort.h"
#include "io/camera.h"
#include "io/containers/kinect_calibration.h"
#include "io/containers/matroska.h"
#include "io/images/jpeg.h"
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

static_assert(std::endian::native == std::endian::little);

constexpr const char* kKinectRecordingAdvice = "give a recording of an Azure Kinect with depth (k4arecorder)";
constexpr double kMillimetres = 1000;
constexpr std::size_t kImuBytes = 40;

const MatroskaTrack* track_named(const MatroskaFile& file, std::string_view name) {
  for (const MatroskaTrack& track : file.tracks)
    if (track.name == name) return &track;
  return nullptr;
}

/// The four characters that name a video's encoding, in the BITMAPINFOHEADER of its track.
std::string four_characters(const MatroskaTrack& track) {
  constexpr std::size_t kOffset = 16, kSize = 4;
  return track.codec_private.size() < kOffset + kSize ? "" : track.codec_private.substr(kOffset, kSize);
}

std::string tag(const MatroskaFile& file, const std::string& name) {
  const auto found = file.tags.find(name);
  return found == file.tags.end() ? "" : found->second;
}

/// Stamps of the device's clock at the start of the recording; the frames' count from there.
Nanoseconds start_of(const MatroskaFile& file) { return parse_unsigned(tag(file, "K4A_START_OFFSET_NS")).value_or(0); }

struct KinectFrame {
  Nanoseconds time = 0;
  MatroskaFrame depth;
  std::optional<MatroskaFrame> color = {};
};

std::vector<KinectFrame> list_frames(const MatroskaTrack& depth, const MatroskaTrack* color, Nanoseconds start,
                                     double max_time_difference, std::vector<std::string>* notes) {
  std::vector<MatroskaFrame> depth_frames = depth.frames, color_frames;
  sort_and_thin(&depth_frames, "depth frames", notes);
  if (color != nullptr) color_frames = color->frames;
  sort_and_thin(&color_frames, "colour frames", notes);
  std::vector<KinectFrame> frames;
  frames.reserve(depth_frames.size());
  for (const MatroskaFrame& frame : depth_frames)
    frames.push_back(
        {frame.time + start, frame, nearest_in_time(color_frames, frame.time, from_seconds(max_time_difference))});
  return frames;
}

class KinectSequence : public Sequence {
 public:
  KinectSequence(SequenceInfo found, const std::string& path, std::vector<KinectFrame> frames,
                 std::vector<Nanoseconds> times, std::optional<ColorRegistration> registration,
                 std::vector<MatroskaFrame> imu, bool undistort)
      : Sequence(std::move(found), std::move(times)),
        file_(path),
        frames_(std::move(frames)),
        registration_(std::move(registration)),
        imu_(std::move(imu)),
        undistorter_(info().camera, undistort ? info().distortion : Distortion{}) {}

  Frame read(int index) const override {
    if (index < 0 || index >= size())
      throw Error(fmt::format("there is no frame {} among {}", index, size()), info().path, "count frames from 0");
    const KinectFrame& recorded = frames_[static_cast<std::size_t>(index)];
    Frame frame{index, recorded.time, read_depth(recorded.depth, index), info().depth_scale, {}};
    undistorter_.apply(frame.depth);
    if (!recorded.color || !registration_) return frame;
    const std::string jpeg = file_.read(recorded.color->offset, recorded.color->size);
    frame.color = registration_->apply(frame.depth, frame.depth_scale, decode_jpeg(jpeg, frame_name("colour", index)));
    return frame;
  }

  ImuRecording read_imu(std::vector<std::string>* notes) const override {
    ImuRecording recording;
    for (const MatroskaFrame& frame : imu_) {
      if (frame.size != kImuBytes)
        throw Error("has a reading of the IMU of another size", info().path, kKinectRecordingAdvice);
      const ImuSample sample = imu_sample(file_.read(frame.offset, frame.size));
      if (sample.specific_force.allFinite() && sample.angular_rate.allFinite()) recording.samples.push_back(sample);
    }
    sort_and_thin(&recording.samples, "samples", notes);
    return recording;
  }

 private:
  std::string frame_name(const char* what, int index) const {
    return fmt::format("{} ({} of frame {})", info().path, what, index);
  }

  /// 16 bits a reading, the upper byte first.
  DepthImage read_depth(const MatroskaFrame& where, int index) const {
    const Pinhole& camera = info().camera;
    const std::size_t expected = 2 * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    if (where.size != expected)
      throw Error(fmt::format("holds {} bytes, where {}x{} readings take {}", where.size, camera.width, camera.height,
                              expected),
                  frame_name("depth", index), "copy the file again");
    DepthImage depth(camera.width, camera.height);
    const std::string bytes = file_.read(where.offset, where.size);
    const auto byte = [&](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(bytes[i])); };
    for (std::size_t i = 0; i < depth.pixels.size(); ++i)
      depth.pixels[i] = static_cast<std::uint16_t>(byte(2 * i) << 8 | byte(2 * i + 1));
    return depth;
  }

  /// Stamp (ns of the device's clock) and vector of the accelerometer, then of the gyroscope.
  static ImuSample imu_sample(const std::string& bytes) {
    std::uint64_t time = 0;
    std::array<float, 3> force{}, rate{};
    std::memcpy(&time, bytes.data(), 8);
    std::memcpy(force.data(), bytes.data() + 8, 12);
    std::memcpy(rate.data(), bytes.data() + 28, 12);
    ImuSample sample;
    sample.time = static_cast<Nanoseconds>(time);
    for (int i = 0; i < 3; ++i) {
      sample.specific_force[i] = static_cast<double>(force[static_cast<std::size_t>(i)]);
      sample.angular_rate[i] = static_cast<double>(rate[static_cast<std::size_t>(i)]);
    }
    return sample;
  }

  RandomAccessFile file_;
  std::vector<KinectFrame> frames_;
  std::optional<ColorRegistration> registration_;
  std::vector<MatroskaFrame> imu_;
  Undistorter undistorter_;
};

const MatroskaTrack& depth_track(const MatroskaFile& file, const std::string& path) {
  const MatroskaTrack* depth = track_named(file, "DEPTH");
  if (depth == nullptr) throw Error("has no track named DEPTH", path, kKinectRecordingAdvice);
  if (four_characters(*depth) != "b16g")
    throw Error(fmt::format("its depth is encoded as '{}', where 'b16g' is expected", four_characters(*depth)), path,
                kKinectRecordingAdvice);
  if (depth->width < 2 || depth->height < 2)
    throw Error("does not tell the size of its depth images", path, kKinectRecordingAdvice);
  if (depth->frames.empty()) throw Error("has no depth frames", path, kKinectRecordingAdvice);
  return *depth;
}

/// The colour track, if it can be read and is wanted.
const MatroskaTrack* color_track(const MatroskaFile& file, const SequenceOptions& options,
                                 std::vector<std::string>* notes) {
  const MatroskaTrack* color = options.color ? track_named(file, "COLOR") : nullptr;
  if (color == nullptr || four_characters(*color) == "MJPG") return color;
  notes->push_back(fmt::format("the colour is encoded as '{}', which is not read (MJPG is); going on without colour",
                               four_characters(*color)));
  return nullptr;
}

}  // namespace

std::unique_ptr<Sequence> open_kinect_recording(const std::string& path, const SequenceOptions& options) {
  SequenceInfo info;
  info.path = path;
  info.format = "Azure Kinect recording";
  const MatroskaFile file = index_matroska(path, &info.notes);
  const MatroskaTrack& depth = depth_track(file, path);
  const MatroskaTrack* color = color_track(file, options, &info.notes);

  CameraClues clues{path, "", false, depth.width, depth.height, {}};
  std::optional<ColorRegistration> registration;
  if (const auto json = file.attachments.find("calibration.json"); json != file.attachments.end()) {
    const KinectCalibration calibration =
        parse_kinect_calibration(json->second, tag(file, "K4A_DEPTH_MODE"), depth.width, depth.height,
                                 color != nullptr ? color->width : 0, color != nullptr ? color->height : 0, path);
    clues.calibration = {calibration.depth, calibration.depth_distortion, "the recording's calibration", false};
    info.body_from_camera = calibration.body_from_depth;
    if (color != nullptr)
      registration = {calibration.depth, calibration.color, calibration.color_distortion, calibration.color_from_depth};
  } else if (color != nullptr) {
    info.notes.emplace_back("the recording has no calibration, so colour cannot be brought to depth");
  }
  const CameraChoice choice = choose_camera(options, clues);
  info.camera = choice.camera;
  info.distortion = choice.distortion;
  info.camera_source = choice.source;
  info.depth_scale = options.depth_scale.value_or(kMillimetres);
  info.depth_scale_source = options.depth_scale ? "given" : "the format (millimetres)";
  if (registration) registration->depth = info.camera;

  std::vector<KinectFrame> frames =
      list_frames(depth, registration ? color : nullptr, start_of(file), options.max_time_difference, &info.notes);
  std::vector<Nanoseconds> times;
  for (const KinectFrame& frame : frames) {
    times.push_back(frame.time);
    info.color_frames += frame.color ? 1 : 0;
  }
  const MatroskaTrack* imu = track_named(file, "IMU");
  return std::make_unique<KinectSequence>(std::move(info), path, std::move(frames), std::move(times), registration,
                                          imu != nullptr ? imu->frames : std::vector<MatroskaFrame>{},
                                          options.undistort);
}

}  // namespace plumbline
