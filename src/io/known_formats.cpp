#include "io/known_formats.h"

#include <array>
#include <filesystem>

#include "io/camera.h"

namespace plumbline {
namespace {

struct Entry {
  const char *extension, *what, *how;
};

constexpr std::array<Entry, 10> kEntries = {{
    {".oni", "an OpenNI recording (.oni)", "export its depth as 16-bit PNG files, for example with oni2png"},
    {".klg", "a Kintinuous or ElasticFusion log (.klg)",
     "unpack and export it as 16-bit PNG files, depth in millimetres"},
    {".r3d", "a Record3D recording (.r3d, whose depth is packed by LZFSE)",
     "export it in the app as 'EXR + RGB' or 'PNG sequence', and give that folder"},
    {".xef", "a Kinect Studio recording (.xef)", "export its depth as 16-bit PNG files with KinectXEFTools"},
    {".xrf", "a Kinect Studio recording (.xrf)", "export its depth as 16-bit PNG files"},
    {".svo", "a ZED recording (.svo)", "export its depth as 16-bit PNG files with the SDK's SVO export (mode 4)"},
    {".svo2", "a ZED recording (.svo2)", "export its depth as 16-bit PNG files with the SDK's SVO export (mode 4)"},
    {".zstd", "packed as a whole (.zstd)", "unpack it with `zstd -d`"},
    {".active", "a bag that was not closed (.active)", "rename it to .bag, or repair it with `rosbag reindex`"},
    {".mp4", "a video", "give the folder with the depth images beside it"},
}};

}  // namespace

std::optional<KnownFormat> known_unread_format(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  for (const Entry& entry : kEntries)
    if (extension == entry.extension) return KnownFormat{entry.what, entry.how};
  return std::nullopt;
}

}  // namespace plumbline
