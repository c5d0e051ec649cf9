#include "io/known_formats.h"

#include <array>
#include <filesystem>

#include "io/camera.h"

namespace plumbline {
namespace {

struct Entry {
  const char *extension, *what, *how;
};

constexpr std::array<Entry, 21> kEntries = {{
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
    {".mov", "a video", "give the folder with the depth images beside it"},
    {".zip", "a packed folder (.zip)", "unpack it, and give the folder"},
    {".tar", "a packed folder (.tar)", "unpack it with `tar xf`, and give the folder"},
    {".tgz", "a packed folder (.tgz)", "unpack it with `tar xf`, and give the folder"},
    {".gz", "packed (.gz)", "unpack it with `tar xf` or `gunzip`, and give what it holds"},
    {".7z", "a packed folder (.7z)", "unpack it, and give the folder"},
    {".npz", "an archive of NumPy (.npz)", "write each depth image as an .npy or a 16-bit PNG file"},
    {".h5", "an HDF5 file (.h5)", "write its depth images as 16-bit PNG files"},
    {".mat", "a file of MATLAB (.mat)", "write its depth images as 16-bit PNG files"},
    {".ply", "a mesh or point cloud", "give the depth images that it was made from"},
    {".pcd", "a point cloud", "give the depth images that it was made from"},
}};

}  // namespace

std::optional<KnownFormat> known_unread_format(const std::string& path) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  for (const Entry& entry : kEntries)
    if (extension == entry.extension) return KnownFormat{entry.what, entry.how};
  return std::nullopt;
}

}  // namespace plumbline
