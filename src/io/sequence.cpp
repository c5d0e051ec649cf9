#include "plumbline/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/undistort.h"
#include "io/camera.h"
#include "io/image_file.h"
#include "io/imu_file.h"
#include "io/recording.h"
#include "io/sequence_list.h"
#include "plumbline/error.h"
#include "plumbline/frame.h"
#include "plumbline/pinhole.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

constexpr Nanoseconds kLongGap = kNanosecondsPerSecond / 2;

/// Frames in files, of any layout: these differ only in how the list and the camera are found.
class FileSequence : public Sequence {
 public:
  FileSequence(SequenceInfo found, const SequenceList& list, std::vector<Nanoseconds> times, bool undistort)
      : Sequence(std::move(found), std::move(times)),
        folder_(list.folder),
        entries_(list.entries),
        saturated_is_invalid_(list.saturated_is_invalid),
        undistorter_(info().camera, undistort ? info().distortion : Distortion{}) {}

  Frame read(int index) const override {
    if (index < 0 || index >= size())
      throw Error(fmt::format("there is no frame {} among {}", index, size()), info().path, "count frames from 0");
    const SequenceEntry& entry = entries_[static_cast<std::size_t>(index)];
    Frame frame{index, entry.time, read_depth_image(entry.depth), info().depth_scale, {}};
    check_size(frame.depth.width, frame.depth.height, entry.depth);
    if (saturated_is_invalid_) std::replace(frame.depth.pixels.begin(), frame.depth.pixels.end(), kSaturated, kNone);
    undistorter_.apply(frame.depth);
    if (entry.color.empty()) return frame;
    frame.color = read_color_image(entry.color);
    check_size(frame.color.width, frame.color.height, entry.color);
    undistorter_.apply(frame.color);
    return frame;
  }

  ImuRecording read_imu(std::vector<std::string>* notes) const override {
    for (const char* name : {"imu.csv", "accelerometer.txt"}) {
      const std::filesystem::path file = std::filesystem::path(folder_) / name;
      if (std::error_code error; std::filesystem::is_regular_file(file, error))
        return plumbline::read_imu(file.string(), notes);
    }
    return {};
  }

 private:
  static constexpr std::uint16_t kSaturated = 65535, kNone = 0;

  void check_size(int width, int height, const std::string& file) const {
    const Pinhole& camera = info().camera;
    if (width != camera.width || height != camera.height)
      throw Error(
          fmt::format("is {}x{}, but the sequence's images are {}x{}", width, height, camera.width, camera.height),
          file, "give images of one camera and one size");
  }

  std::string folder_;
  std::vector<SequenceEntry> entries_;
  bool saturated_is_invalid_;
  Undistorter undistorter_;
};

ImageHeader first_depth_header(const SequenceList& list) {
  const std::string& path = list.entries.front().depth;
  ImageHeader header = read_image_header(path);
  if (!header.is_depth)
    throw Error("16-bit grey depth is expected, but the file is: " + header.description, path,
                "give the depth images themselves, not colour images or pictures made from depth");
  return header;
}

/// Colour of another size cannot be registered to depth.
void drop_unfit_color(const ImageHeader& depth, SequenceList* list) {
  const auto first = std::find_if(list->entries.begin(), list->entries.end(),
                                  [](const SequenceEntry& entry) { return !entry.color.empty(); });
  if (first == list->entries.end()) return;
  const ImageHeader color = read_image_header(first->color);
  if (color.width == depth.width && color.height == depth.height) return;
  for (SequenceEntry& entry : list->entries) entry.color.clear();
  list->notes.push_back(fmt::format("the colour images are {}x{} and depth is {}x{}; going on without colour",
                                    color.width, color.height, depth.width, depth.height));
}

void note_gaps(const SequenceList& list, std::vector<std::string>* notes) {
  int gaps = 0;
  Nanoseconds longest = 0;
  std::size_t after = 0;
  for (std::size_t i = 1; i < list.entries.size(); ++i) {
    const Nanoseconds gap = list.entries[i].time - list.entries[i - 1].time;
    if (gap > kLongGap) ++gaps;
    if (gap > longest) longest = gap, after = i - 1;
  }
  if (gaps > 0 && !list.stamps_are_frame_numbers)
    notes->push_back(fmt::format("{} gap{} longer than 0.5 s, the longest of {:.2f} s after frame {}", gaps,
                                 gaps == 1 ? "" : "s", to_seconds(longest), after));
}

void set_depth_scale(const SequenceOptions& options, const SequenceList& list, SequenceInfo* info) {
  info->depth_scale = options.depth_scale.value_or(list.depth_scale);
  info->depth_scale_source = options.depth_scale ? "given" : list.depth_scale_source;
  if (!std::isfinite(info->depth_scale) || info->depth_scale <= 0)
    throw Error(fmt::format("a depth scale of {} readings per metre is impossible", info->depth_scale), "depth_scale",
                "give readings per metre, such as 5000 (TUM) or 1000 (millimetres)");
}

void set_camera(const SequenceOptions& options, const CameraClues& clues, SequenceInfo* info) {
  const CameraChoice choice = choose_camera(options, clues);
  info->camera = choice.camera;
  info->distortion = choice.distortion;
  info->camera_source = choice.source;
  if (choice.is_guess)
    info->notes.emplace_back(
        "the camera is not known; the Kinect's default intrinsics are used, which may cost accuracy");
}

SequenceInfo describe(const std::string& path, const SequenceOptions& options, const SequenceList& list,
                      const ImageHeader& depth) {
  SequenceInfo info;
  info.path = path;
  info.format = list.format;
  info.groundtruth = list.groundtruth;
  info.notes = list.notes;
  info.color_frames = static_cast<int>(std::count_if(list.entries.begin(), list.entries.end(),
                                                     [](const SequenceEntry& entry) { return !entry.color.empty(); }));
  set_depth_scale(options, list, &info);
  set_camera(options, {list.folder, list.format_camera, list.format_camera_is_guess, depth.width, depth.height, {}},
             &info);
  note_gaps(list, &info.notes);
  return info;
}

/// Another sequence, without the distortion of its depth.
class UndistortedDepthSequence : public Sequence {
 public:
  UndistortedDepthSequence(std::unique_ptr<Sequence> measured, DepthDistortion distortion)
      : Sequence(noted(*measured, distortion), times_of(*measured)),
        measured_(std::move(measured)),
        distortion_(std::move(distortion)) {}

  Frame read(int index) const override {
    Frame frame = measured_->read(index);
    distortion_.correct(frame.depth_scale, &frame.depth);
    return frame;
  }

  ImuRecording read_imu(std::vector<std::string>* notes) const override { return measured_->read_imu(notes); }

 private:
  static SequenceInfo noted(const Sequence& measured, const DepthDistortion& distortion) {
    SequenceInfo info = measured.info();
    distortion.check_size(info.camera.width, info.camera.height);
    info.notes.push_back(distortion.describe() + " is taken out");
    return info;
  }
  static std::vector<Nanoseconds> times_of(const Sequence& measured) {
    std::vector<Nanoseconds> times;
    for (int i = 0; i < measured.size(); ++i) times.push_back(measured.time(i));
    return times;
  }

  std::unique_ptr<Sequence> measured_;
  DepthDistortion distortion_;
};

std::unique_ptr<Sequence> open_as_measured(const std::string& path, const SequenceOptions& options) {
  if (is_recording(path)) return open_recording(path, options);
  SequenceList list = list_sequence(path, options);
  const ImageHeader depth = first_depth_header(list);
  drop_unfit_color(depth, &list);
  SequenceInfo info = describe(path, options, list, depth);
  std::vector<Nanoseconds> times;
  for (const SequenceEntry& entry : list.entries) times.push_back(entry.time);
  return std::make_unique<FileSequence>(std::move(info), list, std::move(times), options.undistort);
}

}  // namespace

Sequence::Sequence(SequenceInfo info, std::vector<Nanoseconds> times)
    : info_(std::move(info)), times_(std::move(times)) {
  info_.frames = size();
  info_.first_time = times_.empty() ? 0 : times_.front();
  info_.last_time = times_.empty() ? 0 : times_.back();
}

std::unique_ptr<Sequence> open_sequence(const std::string& path, const SequenceOptions& options) {
  std::unique_ptr<Sequence> sequence = open_as_measured(path, options);
  if (options.depth_distortion.empty()) return sequence;
  return without_depth_distortion(std::move(sequence), options.depth_distortion);
}

std::unique_ptr<Sequence> without_depth_distortion(std::unique_ptr<Sequence> measured, DepthDistortion distortion) {
  return std::make_unique<UndistortedDepthSequence>(std::move(measured), std::move(distortion));
}

}  // namespace plumbline
