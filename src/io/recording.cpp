#include "io/recording.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "io/containers/matroska.h"
#include "io/containers/message_store.h"
#include "io/containers/rosbag.h"
#include "io/containers/sens.h"
#include "io/known_formats.h"
#include "plumbline/error.h"

namespace plumbline {

RandomAccessFile::RandomAccessFile(const std::string& path)
    : path_(path), fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (fd_ < 0 || fstat(fd_, &status) != 0) {
    const int error = errno;
    if (fd_ >= 0) close(fd_);
    throw Error(std::string("cannot be read: ") + std::strerror(error), path, "check the path");
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
}

RandomAccessFile::~RandomAccessFile() { close(fd_); }

std::string RandomAccessFile::read(std::uint64_t offset, std::size_t size) const {
  if (offset > size_ || size > size_ - offset) throw Error("ends early", path_, "copy the file again");
  std::string bytes(size, '\0');
  for (std::size_t done = 0; done < size;) {
    const ssize_t n = pread(fd_, bytes.data() + done, size - done, static_cast<off_t>(offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw Error("ends early or cannot be read", path_, "copy the file again");
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

namespace {

[[noreturn]] void refuse(const std::string& path, std::string_view first_bytes) {
  if (first_bytes.starts_with("\x89PNG") || first_bytes.starts_with("\xFF\xD8\xFF") || first_bytes.starts_with("P5"))
    throw Error("is a single image, not a recording", path, "give the folder that holds the images");
  if (const auto known = known_unread_format(path))
    throw Error("is " + known->what + ", which is not read", path, known->how_to_convert);
  if (first_bytes.starts_with("#ROSBAG V1"))
    throw Error("is no recording that can be read: a bag of the old format 1", path, "convert it with `rosbag fix`");
  throw Error("is no recording that can be read", path,
              "give a folder of depth images, a recording of an Azure Kinect (.mkv), a bag of ROS 1 or a RealSense "
              "(.bag), a recording of ROS 2 (.db3, .mcap, or its folder), or of ScanNet (.sens)");
}

}  // namespace

bool is_recording(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error) || is_ros2_folder(path);
}

bool holds_recording(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return is_ros2_folder(path);
  const RandomAccessFile file(path);
  const std::string first = file.read(0, std::min<std::uint64_t>(file.size(), 16));
  return is_matroska(first) || is_rosbag(first) || is_sqlite(first) || is_mcap(first) || is_sens(first);
}

std::unique_ptr<Sequence> open_recording(const std::string& path, const SequenceOptions& options) {
  if (std::error_code error; std::filesystem::is_directory(path, error)) return open_ros_recording(path, options);
  const RandomAccessFile file(path);
  const std::string first = file.read(0, std::min<std::uint64_t>(file.size(), 16));
  if (is_matroska(first)) return open_kinect_recording(path, options);
  if (is_rosbag(first) || is_sqlite(first) || is_mcap(first)) return open_ros_recording(path, options);
  if (is_sens(first)) return open_sens_recording(path, options);
  refuse(path, first);
}

}  // namespace plumbline
