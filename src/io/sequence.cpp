#include "plumbline/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <functional>
#include <optional>

#include "core/undistort.h"
#include "io/camera.h"
#include "io/checks/color_check.h"
#include "io/checks/plausibility.h"
#include "io/images/image_file.h"
#include "io/imu_file.h"
#include "io/recorded_camera.h"
#include "io/recording.h"
#include "io/registration.h"
#include "io/sequence_list.h"
#include "io/trajectory.h"
#include "io/wrapped_sequence.h"
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
  FileSequence(SequenceInfo found, const SequenceList& list, std::vector<Nanoseconds> times,
               const SequenceOptions& options, double float_unit)
      : Sequence(std::move(found), std::move(times)),
        folder_(list.folder),
        entries_(list.entries),
        read_truth_(list.read_truth),
        read_imu_(list.read_imu),
        float_unit_(float_unit),
        min_confidence_(options.min_confidence),
        one_camera_(options.intrinsics || !options.camera.empty()),
        reading_of_(list.reading_of),
        undistorter_(info().camera, options.undistort ? info().distortion : Distortion{}) {
    const SE3& color_from_depth = list.color_from_depth;
    const bool moved = !color_from_depth.rotation().isIdentity(0) || !color_from_depth.translation().isZero(0);
    if (list.color_camera && (*list.color_camera != info().camera || moved))
      registration_ = ColorRegistration{info().camera, *list.color_camera, {}, list.color_from_depth};
  }

  Frame read(int index) const override {
    if (index < 0 || index >= size())
      throw Error(fmt::format("there is no frame {} among {}", index, size()), info().path, "count frames from 0");
    const SequenceEntry& entry = entries_[static_cast<std::size_t>(index)];
    Frame frame{index, entry.time, read_depth(entry), info().depth_scale, {}};
    undistorter_.apply(frame.depth);
    if (entry.camera && !one_camera_)
      if (const auto own = scaled_to(*entry.camera, frame.depth.width, frame.depth.height))
        frame.depth = seen_through(*own, info().camera, frame.depth);
    if (!entry.color.empty()) frame.color = read_color(entry, frame);
    return frame;
  }

  ImuRecording read_imu(std::vector<std::string>* notes) const override {
    if (read_imu_) return read_imu_(notes);
    const std::string file = find_imu_file(folder_);
    return file.empty() ? ImuRecording{} : plumbline::read_imu(file, notes);
  }

  Trajectory read_groundtruth(std::vector<std::string>* notes) const override {
    return read_truth_ ? read_truth_(notes) : Sequence::read_groundtruth(notes);
  }

 private:
  DepthImage read_depth(const SequenceEntry& entry) const {
    DepthImage depth = read_depth_image(entry.depth, float_unit_);
    check_size(depth.width, depth.height, entry.depth);
    if (!reading_of_.empty())
      for (std::uint16_t& reading : depth.pixels) reading = reading_of_[reading];
    if (!entry.confidence.empty() && min_confidence_ > 0) drop_doubtful(entry.confidence, &depth);
    return depth;
  }

  /// Leaves out readings below the level. A confidence image that cannot be read costs the frame.
  void drop_doubtful(const std::string& file, DepthImage* depth) const {
    const ColorImage confidence = read_color_image(file);
    if (static_cast<long long>(confidence.width) * depth->height !=
        static_cast<long long>(confidence.height) * depth->width)
      check_size(confidence.width, confidence.height, file);
    for (int y = 0; y < depth->height; ++y)
      for (int x = 0; x < depth->width; ++x)
        if (confidence.at(x * confidence.width / depth->width, y * confidence.height / depth->height, 0) <
            min_confidence_)
          depth->at(x, y) = 0;
  }

  ColorImage read_color(const SequenceEntry& entry, const Frame& frame) const {
    ColorImage color = read_color_image(entry.color);
    if (registration_) {
      check_size(color.width, color.height, entry.color, registration_->color);
      ColorRegistration registration = *registration_;
      if (entry.camera && !one_camera_)
        registration.color = scaled_to(*entry.camera, color.width, color.height).value_or(registration.color);
      return registration.apply(frame.depth, frame.depth_scale, color);
    }
    check_size(color.width, color.height, entry.color);
    undistorter_.apply(color);
    return color;
  }

  void check_size(int width, int height, const std::string& file) const {
    check_size(width, height, file, info().camera);
  }

  static void check_size(int width, int height, const std::string& file, const Pinhole& camera) {
    if (width != camera.width || height != camera.height)
      throw Error(
          fmt::format("is {}x{}, but the sequence's images are {}x{}", width, height, camera.width, camera.height),
          file, "give images of one camera and one size");
  }

  std::string folder_;
  std::vector<SequenceEntry> entries_;
  std::function<Trajectory(std::vector<std::string>* notes)> read_truth_;
  std::function<ImuRecording(std::vector<std::string>* notes)> read_imu_;
  double float_unit_;
  int min_confidence_;
  bool one_camera_;                                ///< whatever the frames tell of theirs
  std::vector<std::uint16_t> reading_of_;          ///< see SequenceList
  std::optional<ColorRegistration> registration_;  ///< of colour with its own camera
  Undistorter undistorter_;
};

/// What most of a dozen depth images are, so that a bad one costs only its frame. Throws what is wrong with the first
/// if none is depth.
ImageHeader common_depth_header(const SequenceList& list) {
  constexpr std::size_t kLooks = 12, kUneven = 5;  // so that no rhythm of the frames meets that of the looks
  std::vector<std::pair<ImageHeader, int>> kinds;
  std::exception_ptr failure;
  const std::size_t count = list.entries.size(), step = std::max<std::size_t>(count / kLooks, 1);
  // Those in between are looked at only where none of the dozen can be read.
  for (std::size_t pass = 0; pass < step && kinds.empty(); ++pass)
    for (std::size_t k = 0; k * step < count; ++k) try {
        const std::size_t i = std::min(count - 1, k * step + (pass + kUneven * k) % step);
        const ImageHeader header = read_image_header(list.entries[i].depth);
        if (!header.is_depth)
          throw Error("16-bit grey depth is expected, but the file is: " + header.description, list.entries[i].depth,
                      "give the depth images themselves, not colour images or pictures made from depth");
        const auto known = std::find_if(kinds.begin(), kinds.end(), [&](const auto& kind) {
          return kind.first.width == header.width && kind.first.height == header.height;
        });
        if (known != kinds.end())
          ++known->second;
        else
          kinds.emplace_back(header, 1);
      } catch (const Error&) {
        if (!failure) failure = std::current_exception();
      }
  if (kinds.empty()) std::rethrow_exception(failure);
  return std::max_element(kinds.begin(), kinds.end(), [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Whole numbers of a few images.
std::vector<std::uint16_t> sampled_numbers(const SequenceList& list) {
  constexpr std::size_t kLooks = 5;
  std::vector<std::uint16_t> numbers;
  for (std::size_t i = 0; i < list.entries.size(); i += list.entries.size() / kLooks + 1) try {
      const DepthImage depth = read_depth_image(list.entries[i].depth, 1);
      std::copy_if(depth.pixels.begin(), depth.pixels.end(), std::back_inserter(numbers), [](auto v) { return v > 0; });
    } catch (const Error&) {  // its frame will tell
    }
  return numbers;
}

/// What one metre is in files of real numbers: given, else 1, unless most of the numbers are too large for a room, and
/// the recording tells a scale with which they are not.
double float_scale(const SequenceOptions& options, const SequenceList& list, std::vector<Warning>* warnings) {
  constexpr std::uint16_t kCentimetres = 30, kMillimetres = 400;
  if (options.depth_scale) return *options.depth_scale;
  std::vector<std::uint16_t> numbers = sampled_numbers(list);
  if (numbers.empty()) return 1;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  if (*middle < kCentimetres) return 1;
  if (!list.depth_scale_is_guess && *middle / list.depth_scale > 0.2 && *middle / list.depth_scale < 20)
    return list.depth_scale;
  const bool millimetres = *middle >= kMillimetres;
  warnings->push_back({fmt::format("the files hold real numbers, {} in the median: they seem to be {} where metres are "
                                   "expected",
                                   *middle, millimetres ? "millimetres" : "centimetres"),
                       fmt::format("Give --depth-scale {} if that is right.", millimetres ? 1000 : 100)});
  return 1;
}

void drop_color(SequenceList* list, const std::string& reason) {
  for (SequenceEntry& entry : list->entries) entry.color.clear();
  list->color_camera.reset();
  list->notes.push_back("colour is not used, because " + reason);
}

/// The header of the first colour image that can be read; all zero if none of the first dozen can.
ImageHeader first_color_header(const SequenceList& list) {
  int looks = 0;
  for (const SequenceEntry& entry : list.entries) {
    if (entry.color.empty() || ++looks > 12) continue;
    try {
      return read_image_header(entry.color);
    } catch (const Error&) {  // its frame will tell
    }
  }
  return {};
}

/// The camera at the size of its images. One whose size is not told is theirs if its principal point lies near their
/// centre, else that of the usual size around it. Empty if the images are of another shape.
std::optional<Pinhole> of_images(Pinhole camera, int width, int height) {
  constexpr float kNearCentre = 0.2f;
  if (camera.width == 0) {
    const float off_x = std::abs((camera.cx + 0.5f) / static_cast<float>(width) - 0.5f),
                off_y = std::abs((camera.cy + 0.5f) / static_cast<float>(height) - 0.5f);
    if (off_x < kNearCentre && off_y < kNearCentre) {
      camera.width = width;
      camera.height = height;
      return camera;
    }
    const auto sized = sized_by_centre(camera, static_cast<double>(width) / height);
    if (!sized) return std::nullopt;
    camera = *sized;
  }
  return scaled_to(camera, width, height);
}

/// Phones write videos that lie on their side, which tools that unpack them turn upright.
std::string turned_advice(const ImageHeader& color, const ImageHeader& depth) {
  const bool turned = (color.width > color.height) != (depth.width > depth.height);
  return turned ? ": they are turned by 90 degrees against depth; unpack videos with `ffmpeg -noautorotate`" : "";
}

/// A confidence image of another size is sampled if it has the depth's shape, else left out.
void settle_confidence(const ImageHeader& depth, SequenceList* list) {
  for (const SequenceEntry& entry : list->entries) try {
      if (entry.confidence.empty()) continue;
      const ImageHeader header = read_image_header(entry.confidence);
      if (static_cast<long long>(header.width) * depth.height == static_cast<long long>(header.height) * depth.width)
        return;
      list->notes.push_back(
          fmt::format("confidence is not used, because its images are {}x{} and depth is {}x{}, of "
                      "another shape",
                      header.width, header.height, depth.width, depth.height));
      for (SequenceEntry& one : list->entries) one.confidence.clear();
      return;
    } catch (const Error&) {  // its frame will tell
    }
}

/// Intrinsics of the colour images' size, where depth has another, are those of colour: of one camera only on phones.
void call_camera_of_color_a_guess(const ImageHeader& color, SequenceList* list) {
  if (!list->camera || list->camera->camera.width != color.width || list->camera->camera.height != color.height) return;
  list->camera->is_guess = true;
  list->camera->source += ", of colour's size and perhaps colour's";
}

/// Colour of another size is registered where both cameras are known and share their place, else left out.
void settle_color(const ImageHeader& depth, SequenceList* list) {
  const ImageHeader color = first_color_header(*list);
  if (color.width == 0) return;
  const bool same_size = color.width == depth.width && color.height == depth.height;
  if (list->color_camera) {
    list->color_camera = of_images(*list->color_camera, color.width, color.height);
    if (list->color_camera && same_size) return;
    if (list->color_camera)
      list->notes.push_back(
          fmt::format("colour of {}x{} is sampled at the depth's {}x{} pixels, by the intrinsics of both", color.width,
                      color.height, depth.width, depth.height));
    if (!list->color_camera)
      drop_color(list, fmt::format("its {}x{} images are not of the shape that its intrinsics belong to{}", color.width,
                                   color.height, turned_advice(color, depth)));
    return;
  }
  if (!same_size) call_camera_of_color_a_guess(color, list);
  if (!same_size)
    drop_color(list,
               fmt::format("the colour images are {}x{} and depth is {}x{}, and how the two cameras stand to each "
                           "other is not known{}",
                           color.width, color.height, depth.width, depth.height, turned_advice(color, depth)));
}

void note_gaps(const SequenceList& list, std::vector<std::string>* notes) {
  std::vector<Nanoseconds> times;
  for (const SequenceEntry& entry : list.entries) times.push_back(entry.time);
  int gaps = 0;
  Nanoseconds longest = 0;
  std::size_t after = 0;
  for (std::size_t i = 1; i < list.entries.size(); ++i) {
    const Nanoseconds gap = list.entries[i].time - list.entries[i - 1].time;
    if (gap > kLongGap) ++gaps;
    if (gap > longest) longest = gap, after = i - 1;
  }
  // Longer ones are warned of as jumps.
  if (gaps > 0 && !list.stamps_are_frame_numbers && longest <= jump_limit(times))
    notes->push_back(fmt::format("{} gap{} longer than 0.5 s, the longest of {:.2f} s after frame {}", gaps,
                                 gaps == 1 ? "" : "s", to_seconds(longest), after));
}

void set_depth_scale(const SequenceOptions& options, const SequenceList& list, const ImageHeader& depth,
                     double of_float, SequenceInfo* info) {
  info->depth_scale = depth.is_float ? of_float : options.depth_scale.value_or(list.depth_scale);
  info->depth_scale_source = options.depth_scale ? "given" : list.depth_scale_source;
  info->depth_scale_is_guess = !options.depth_scale && list.depth_scale_is_guess && !depth.is_float;
  if (!std::isfinite(info->depth_scale) || info->depth_scale <= 0)
    throw Error(fmt::format("a depth scale of {} readings per metre is impossible", info->depth_scale), "depth_scale",
                "give readings per metre, such as 5000 (TUM) or 1000 (millimetres)");
  if (!depth.is_float) return;
  const std::string by = info->depth_scale == 1 && !options.depth_scale ? "" : info->depth_scale_source + ": ";
  info->depth_scale_source = fmt::format("{}{:g} in the files is a metre ({}), kept as {:g} readings", by,
                                         info->depth_scale, depth.description, kReadingsOfFloat);
  info->depth_scale = kReadingsOfFloat;
}

/// The camera that came with the frames, at the depth's size. Throws Error if it is one of images of another shape.
std::optional<CameraChoice> fitting_camera(const SequenceList& list, const ImageHeader& depth) {
  if (!list.camera) return std::nullopt;
  CameraChoice choice = *list.camera;
  if (choice.camera.width == 0) {
    const auto sized = of_images(choice.camera, depth.width, depth.height);
    if (!sized) return choice;
    choice.is_guess = choice.camera.fx != sized->fx;
    if (choice.is_guess) choice.source += ", scaled to the depth's size, a guess by its principal point";
    choice.camera = *sized;
    return choice;
  }
  const Pinhole& known = choice.camera;
  if (known.width == depth.width && known.height == depth.height) return choice;
  const auto scaled = scaled_to(known, depth.width, depth.height);
  if (!scaled)
    throw Error(fmt::format("the camera ({}) is one of {}x{} images, but depth is {}x{}, of another shape",
                            choice.source, known.width, known.height, depth.width, depth.height),
                list.folder, "give the intrinsics of the depth images with --intrinsics fx,fy,cx,cy");
  choice.source +=
      fmt::format(", scaled from {}x{} to the depth's {}x{}", known.width, known.height, depth.width, depth.height);
  choice.camera = *scaled;
  return choice;
}

void set_camera(const SequenceOptions& options, const CameraClues& clues, SequenceInfo* info) {
  const CameraChoice choice = choose_camera(options, clues);
  info->camera = choice.camera;
  info->distortion = choice.distortion;
  info->camera_source = choice.source;
  info->camera_is_guess = choice.is_guess;
  if (choice.is_guess)
    info->notes.push_back(fmt::format("the camera is not known; {} are used, a guess which may cost accuracy",
                                      clues.format_camera == "kinect" && choice.source.starts_with("the format's own")
                                          ? "the Kinect's default intrinsics"
                                          : "intrinsics by " + choice.source));
}

void note_confidence(const SequenceOptions& options, const SequenceList& list, std::vector<std::string>* notes) {
  const auto with = std::count_if(list.entries.begin(), list.entries.end(),
                                  [](const SequenceEntry& entry) { return !entry.confidence.empty(); });
  if (with == 0) return;
  notes->push_back(
      options.min_confidence > 0
          ? fmt::format("readings of a confidence below {} are left out ({} frames have a confidence image)",
                        options.min_confidence, with)
          : "the confidence images are not used, because the lowest level is 0");
}

/// Where hardly anything is left, the level is likely wrong, or the images mean something else.
void check_confidence(const SequenceList& list, int level, std::vector<Warning>* warnings) {
  constexpr std::size_t kLooks = 5;
  double all = 0, low = 0;
  for (std::size_t i = 0; i < list.entries.size(); i += list.entries.size() / kLooks + 1) try {
      if (list.entries[i].confidence.empty()) continue;
      const ColorImage confidence = read_color_image(list.entries[i].confidence);
      for (std::size_t p = 0; p < confidence.pixels.size(); p += 3) low += confidence.pixels[p] < level;
      all += static_cast<double>(confidence.pixels.size() / 3);
    } catch (const Error&) {  // its frame will tell
    }
  if (all == 0 || low < 0.7 * all) return;
  warnings->push_back(
      {fmt::format("{:.0f} % of the readings have a confidence below {} and are left out", 100 * low / all, level),
       "Give --min-confidence 0 if the confidence images mean something else."});
}

SequenceInfo describe(const std::string& path, const SequenceOptions& options, const SequenceList& list,
                      const ImageHeader& depth, double of_float) {
  SequenceInfo info;
  info.path = path;
  info.format = list.format;
  info.groundtruth = list.groundtruth;
  info.notes = list.notes;
  info.warnings = list.warnings;
  info.color_frames = static_cast<int>(std::count_if(list.entries.begin(), list.entries.end(),
                                                     [](const SequenceEntry& entry) { return !entry.color.empty(); }));
  info.body_from_camera = list.body_from_camera;
  set_depth_scale(options, list, depth, of_float, &info);
  set_camera(options,
             {list.folder, list.format_camera, list.format_camera_is_guess, depth.width, depth.height,
              fitting_camera(list, depth), list.camera_refusal},
             &info);
  note_gaps(list, &info.notes);
  note_confidence(options, list, &info.notes);
  return info;
}

/// Another sequence, without the distortion of its depth.
class UndistortedDepthSequence : public WrappedSequence {
 public:
  UndistortedDepthSequence(std::shared_ptr<const Sequence> measured, DepthDistortion distortion)
      : WrappedSequence(measured, noted(measured->info(), distortion)), distortion_(std::move(distortion)) {}

  Frame read(int index) const override {
    Frame frame = WrappedSequence::read(index);
    distortion_.correct(frame.depth_scale, &frame.depth);
    return frame;
  }

 private:
  static SequenceInfo noted(SequenceInfo info, const DepthDistortion& distortion) {
    distortion.check_size(info.camera.width, info.camera.height);
    info.notes.push_back(distortion.describe() + " is taken out");
    // Of the first Kinects it is 3 to 4 cm at 2 m.
    constexpr double kMaxAtTwoMetres = 0.07;
    if (4 * distortion.rms() > kMaxAtTwoMetres)
      info.warnings.push_back({distortion.describe() +
                                   " is more than a depth camera's: the readings may be distances along "
                                   "the rays (of a simulator) where depth along the axis is expected, "
                                   "or the intrinsics another camera's",
                               "Write depth along the optical axis, and check the intrinsics."});
    return info;
  }

  DepthDistortion distortion_;
};

std::unique_ptr<Sequence> open_as_measured(const std::string& path, const SequenceOptions& options) {
  if (is_recording(path)) return open_recording(path, options);
  SequenceList list = list_sequence(path, options);
  const ImageHeader depth = common_depth_header(list);
  settle_color(depth, &list);
  settle_confidence(depth, &list);
  const double of_float = depth.is_float ? float_scale(options, list, &list.warnings) : 1;
  SequenceInfo info = describe(path, options, list, depth, of_float);
  if (options.min_confidence > 0) check_confidence(list, options.min_confidence, &info.warnings);
  std::vector<Nanoseconds> times;
  for (const SequenceEntry& entry : list.entries) times.push_back(entry.time);
  const double float_unit = kReadingsOfFloat / of_float;
  return std::make_unique<FileSequence>(std::move(info), list, std::move(times), options, float_unit);
}

}  // namespace

Sequence::Sequence(SequenceInfo info, std::vector<Nanoseconds> times)
    : info_(std::move(info)), times_(std::move(times)) {
  info_.frames = size();
  info_.first_time = times_.empty() ? 0 : times_.front();
  info_.last_time = times_.empty() ? 0 : times_.back();
}

Trajectory Sequence::read_groundtruth(std::vector<std::string>* notes) const {
  return info_.groundtruth.empty() ? Trajectory{} : read_trajectory(info_.groundtruth, notes);
}

std::unique_ptr<Sequence> open_sequence(const std::string& path, const SequenceOptions& options) {
  std::unique_ptr<Sequence> sequence = open_as_measured(path, options);
  std::vector<Warning> warnings = check_plausibility(*sequence);
  if (auto warning = check_color_registration(*sequence)) warnings.push_back(std::move(*warning));
  sequence->info_.warnings.insert(sequence->info_.warnings.end(), warnings.begin(), warnings.end());
  if (options.strict && !sequence->info_.warnings.empty())
    throw Error(sequence->info_.warnings.front().what, path, sequence->info_.warnings.front().what_to_do);
  if (options.depth_distortion.empty()) return sequence;
  return without_depth_distortion(std::move(sequence), options.depth_distortion);
}

std::unique_ptr<Sequence> without_depth_distortion(std::unique_ptr<Sequence> measured, DepthDistortion distortion) {
  return std::make_unique<UndistortedDepthSequence>(std::move(measured), std::move(distortion));
}

}  // namespace plumbline
