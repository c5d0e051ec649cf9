#include "io/recording.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "io/containers/matroska.h"
#include "io/containers/message_store.h"
#include "io/containers/rosbag.h"
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

/// Formats that are known and not read.
struct Foreign {
  std::string_view extension, what, advice;
};
constexpr std::array<Foreign, 8> kForeign = {{
    {".oni", "a recording of OpenNI",
     "play it with OpenNI2's tools and record depth and colour as PNG files, or play it through `plumbline record`"},
    {".klg", "a log of Kintinuous or ElasticFusion", "unpack it with klg2png or klg_to_png into depth/ and rgb/"},
    {".r3d", "a recording of Record3D", "unpack it (it is a zip file), or export it in the app as RGBD + intrinsics"},
    {".xef", "a recording of the Kinect for Windows 2",
     "unpack it with KinectXEFTools (xef2mat, xefextract) into images"},
    {".svo", "a recording of a ZED camera", "export depth and colour as PNG files with ZED_SVO_Export"},
    {".svo2", "a recording of a ZED camera", "export depth and colour as PNG files with ZED_SVO_Export"},
    {".zstd", "packed as a whole", "unpack it with `zstd -d`"},
    {".active", "a bag that was not closed", "rename it to .bag, or repair it with `rosbag reindex`"},
}};

[[noreturn]] void refuse(const std::string& path, std::string_view first_bytes) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const Foreign& format : kForeign)
    if (extension == format.extension)
      throw Error(fmt::format("is {}, which is not read", format.what), path, std::string(format.advice));
  if (first_bytes.starts_with("#ROSBAG V1"))
    throw Error("is no recording that can be read: a bag of the old format 1", path, "convert it with `rosbag fix`");
  throw Error("is no recording that can be read", path,
              "give a folder of depth images, a recording of an Azure Kinect (.mkv), a bag of ROS 1 or a RealSense "
              "(.bag), or a recording of ROS 2 (.db3, .mcap, or its folder)");
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
  return is_matroska(first) || is_rosbag(first) || is_sqlite(first) || is_mcap(first);
}

std::unique_ptr<Sequence> open_recording(const std::string& path, const SequenceOptions& options) {
  if (std::error_code error; std::filesystem::is_directory(path, error)) return open_ros_recording(path, options);
  const RandomAccessFile file(path);
  const std::string first = file.read(0, std::min<std::uint64_t>(file.size(), 16));
  if (is_matroska(first)) return open_kinect_recording(path, options);
  if (is_rosbag(first) || is_sqlite(first) || is_mcap(first)) return open_ros_recording(path, options);
  refuse(path, first);
}

}  // namespace plumbline
