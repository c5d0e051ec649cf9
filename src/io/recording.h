// Sequences that lie in one file: what their readers have in common.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/sequence.h"
#include "plumbline/time.h"

namespace plumbline {

/// A recording in one file, told apart by its first bytes, or a folder of ROS 2. Throws Error as open_sequence does,
/// and for a file that is no recording; for those of other programs it says how to convert them.
std::unique_ptr<Sequence> open_recording(const std::string& path, const SequenceOptions& options);

/// An Azure Kinect's .mkv, as k4arecorder writes it: depth in millimetres, colour as MJPEG, the IMU, the calibration.
/// Colour is registered to depth through the calibration.
std::unique_ptr<Sequence> open_kinect_recording(const std::string& path, const SequenceOptions& options);

/// A recording of ROS 1 (.bag, also librealsense's), of ROS 2 (.db3, .mcap, or a folder of those): depth, and colour,
/// from the topics that `options` names or that fit best; gyroscope and accelerometer. The camera is that of the
/// camera_info that belongs to the depth. Colour of another camera is brought to depth where the recording tells how
/// the two are mounted; else it is left out, which the notes tell.
std::unique_ptr<Sequence> open_ros_recording(const std::string& path, const SequenceOptions& options);

/// Whether open_recording is for this path: a file, or a folder of ROS 2.
bool is_recording(const std::string& path);

/// Whether the path is a recording by its content, and no text file or folder of images.
bool holds_recording(const std::string& path);

/// Of items ordered by their member `time` the nearest one, if it is within `limit`.
template <class Stamped>
std::optional<Stamped> nearest_in_time(const std::vector<Stamped>& sorted, Nanoseconds time, Nanoseconds limit) {
  const auto after = std::lower_bound(sorted.begin(), sorted.end(), time,
                                      [](const Stamped& item, Nanoseconds t) { return item.time < t; });
  const auto distance = [&](const Stamped& item) { return item.time < time ? time - item.time : item.time - time; };
  std::optional<Stamped> best;
  for (const auto it : {after, after == sorted.begin() ? after : after - 1})
    if (it != sorted.end() && distance(*it) <= limit && (!best || distance(*it) < distance(*best))) best = *it;
  return best;
}

/// An open file whose parts can be read from several threads at once.
class RandomAccessFile {
 public:
  /// Throws Error if the file cannot be opened.
  explicit RandomAccessFile(const std::string& path);
  ~RandomAccessFile();
  RandomAccessFile(const RandomAccessFile&) = delete;
  RandomAccessFile& operator=(const RandomAccessFile&) = delete;

  /// Throws Error if the file ends before the part does.
  std::string read(std::uint64_t offset, std::size_t size) const;
  std::uint64_t size() const { return size_; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace plumbline
