#include "fuzz/targets.h"

#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "io/camera.h"
#include "io/containers/kinect_calibration.h"
#include "io/containers/ros_messages.h"
#include "io/images/exr.h"
#include "io/images/jpeg.h"
#include "io/images/plain_depth.h"
#include "io/images/png.h"
#include "io/images/rvl.h"
#include "io/images/tiff.h"
#include "io/imu_file.h"
#include "io/mesh.h"
#include "io/recorded_camera.h"
#include "io/sequence_list.h"
#include "io/trajectory.h"
#include "plumbline/calibration.h"
#include "plumbline/config.h"
#include "plumbline/error.h"
#include "plumbline/files.h"
#include "plumbline/orientation_calibration.h"
#include "plumbline/sequence.h"
#include "support/temp_folder.h"
#include "view/request.h"

namespace plumbline::fuzz {
namespace {

namespace fs = std::filesystem;

/// Bytes as a file in memory.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes) : fd_(memfd_create("input", MFD_CLOEXEC)) {
    if (fd_ < 0 || write(fd_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      throw std::runtime_error("no file in memory could be made");
  }
  ~MemoryFile() { close(fd_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

/// A folder with one file of these bytes, and a few empty ones beside it for lists to name.
class Folder {
 public:
  Folder() {
    for (const char* file : {"depth/1.png", "depth/2.png", "rgb/1.png"}) test::write_text(folder_ / file, "");
  }

  const fs::path& path() const { return folder_.path(); }
  std::string with(const char* name, std::string_view bytes) const {
    test::write_text(folder_ / name, bytes);
    return folder_.path().string();
  }

 private:
  test::TempFolder folder_;
};

void open_and_read(std::string_view bytes) {
  const MemoryFile file(bytes);
  const auto sequence = open_sequence(file.path());
  try {
    sequence->read_imu();
  } catch (const Error&) {  // the frames may still be good
  }
  if (sequence->size() > 0) sequence->read(sequence->size() - 1);
}

void list_folder(const char* name, std::string_view bytes) {
  static const Folder folder;
  list_sequence(folder.with(name, bytes), {});
}

/// A folder of a layout that is told by this file and an image.
void list_layout(const char* image, const char* name, std::string_view bytes) {
  const Folder folder;
  for (const char* part : {"depth", "rgb", "aligned_depth", "cameras"}) fs::create_directories(folder.path() / part);
  folder.with(image, "");
  list_sequence(folder.with(name, bytes), {});
}

void exr(std::string_view bytes) {
  if (!is_exr(bytes)) return;
  read_exr_header(bytes, "x");
  decode_depth_exr(bytes, "x");
}

void camera(std::string_view bytes) {
  static const Folder folder;
  choose_camera({}, {folder.with("camera-intrinsics.txt", bytes), "", false, 640, 480, {}});
}

void tiff(std::string_view bytes) {
  read_tiff_header(bytes, "x");
  decode_depth_tiff(bytes, "x");
}

void plain_depth(std::string_view bytes) {
  if (is_pgm(bytes)) decode_depth_pgm(bytes, "x");
  if (is_ppm(bytes)) decode_color_ppm(bytes, "x");
  if (is_npy(bytes)) decode_depth_npy(bytes, "x");
}

void png(std::string_view bytes) {
  read_png_header(bytes, "x");
  try {
    decode_depth_png(bytes, "x");
  } catch (const Error&) {  // most PNG files are no depth
  }
  decode_color_png(bytes, "x");
}

void jpeg(std::string_view bytes) {
  read_jpeg_header(bytes, "x");
  decode_jpeg(bytes, "x");
}

void toml(std::string_view bytes) {
  Parameters parameters;
  parse_parameters(bytes, "x", &parameters);
}

/// SQLite opens files by their name alone.
void db3(std::string_view bytes) {
  static const Folder folder;
  folder.with("bag.db3", bytes);
  const auto sequence = open_sequence((folder.path() / "bag.db3").string());
  sequence->read(sequence->size() - 1);
}

/// Every message in both encodings.
void cdr(std::string_view bytes) {
  using Parse = void (*)(std::string_view, Wire);
  constexpr std::array<Parse, 7> kParsers = {[](std::string_view b, Wire w) {
                                               const ros::Image image = ros::parse_image(b, w, false, "x");
                                               if (ros::depth_scale(image)) ros::depth_of(image, "x");
                                               if (ros::is_color(image)) ros::color_of(image, "x");
                                             },
                                             [](std::string_view b, Wire w) {
                                               const ros::Image image = ros::parse_image(b, w, true, "x");
                                               if (ros::depth_scale(image)) ros::depth_of(image, "x");
                                             },
                                             [](std::string_view b, Wire w) { ros::parse_camera_info(b, w, "x"); },
                                             [](std::string_view b, Wire w) { ros::parse_imu(b, w, "x"); },
                                             [](std::string_view b, Wire w) { ros::parse_transforms(b, w, "x"); },
                                             [](std::string_view b, Wire w) { ros::parse_transform(b, w, "x"); },
                                             [](std::string_view b, Wire w) { ros::parse_extrinsics(b, w, "x"); }};
  for (const Wire wire : {Wire::ros1, Wire::cdr})
    for (const Parse parse : kParsers) {
      try {
        parse(bytes, wire);
      } catch (const Error&) {  // a message is of one kind
      }
    }
}

/// What a page may ask for is within its bounds, whatever was sent.
void request(std::string_view bytes) {
  const auto read = app::parse_request(bytes);
  if (!read) return;
  const bool is_box_sound = !read->box || (read->box->half.minCoeff() > 0 && read->box->half.allFinite() &&
                                           read->box->world_from_box.translation().allFinite());
  const bool is_undo_sound = read->kind != app::RequestKind::undo || (read->seconds > 0 && read->seconds <= 3600);
  if (!is_box_sound || !is_undo_sound || bytes.size() > app::kMaxRequestBytes) std::abort();
}

struct Target {
  const char* name;
  std::function<void(std::string_view)> run;
};

std::function<void(std::string_view)> on_file(void (*read)(const std::string&)) {
  return [read](std::string_view bytes) { read(MemoryFile(bytes).path()); };
}

const std::vector<Target>& targets() {
  static const std::vector<Target> list = {
      {"bag", open_and_read},
      {"calibration",
       [](std::string_view bytes) { parse_kinect_calibration(bytes, "NFOV_UNBINNED", 640, 576, 1280, 720, "x"); }},
      {"camera", camera},
      {"cdr", cdr},
      {"db3", db3},
      {"depth_calibration", on_file([](const std::string& path) { read_depth_calibration(path); })},
      {"exr", exr},
      {"imu", on_file([](const std::string& path) { read_imu(path); })},
      {"info_camera", on_file([](const std::string& path) { read_info_camera(path); })},
      {"jpeg", jpeg},
      {"json_camera", on_file([](const std::string& path) { read_json_camera(path); })},
      {"list", [](std::string_view bytes) { list_folder("depth.txt", bytes); }},
      {"mcap", open_and_read},
      {"mkv", open_and_read},
      {"mounting", on_file([](const std::string& path) { read_orientation_calibration(path); })},
      {"obj", on_file([](const std::string& path) { read_obj(path); })},
      {"open_loris",
       [](std::string_view bytes) {
         const Folder folder;
         folder.with("aligned_depth.txt", "1 depth/1.png\n");
         list_sequence(folder.with("sensors.yaml", bytes), {});
       }},
      {"orientation", on_file([](const std::string& path) { read_orientations(path, {}); })},
      {"ply", on_file([](const std::string& path) { read_ply(path); })},
      {"plain_depth", plain_depth},
      {"png", png},
      {"polycam",
       [](std::string_view bytes) { list_layout("depth/1.png", "cameras/1.json", bytes); }},
      {"record3d", [](std::string_view bytes) { list_layout("depth/0.exr", "metadata.json", bytes); }},
      {"request", request},
      {"rvl", [](std::string_view bytes) { decode_rvl(bytes, 640 * 480, "x"); }},
      {"scanner_app", [](std::string_view bytes) { list_layout("depth_0.png", "frame_0.json", bytes); }},
      {"sens", open_and_read},
      {"text_camera", on_file([](const std::string& path) { read_text_camera(path); })},
      {"tiff", tiff},
      {"toml", toml},
      {"trans_matrix",
       [](std::string_view bytes) {
         const Folder folder;
         folder.with("aligned_depth.txt", "1 depth/1.png\n");
         folder.with("groundtruth.txt", "1 0 0 0 0 0 0 1\n");
         folder.with("sensors.yaml", "d400_color:\n   intrinsics:\n      data: [ 5, 3, 5, 2 ]\n");
         list_sequence(folder.with("trans_matrix.yaml", bytes), {});
       }},
      {"trajectory", on_file([](const std::string& path) { read_trajectory(path); })},
      {"yaml_camera", on_file([](const std::string& path) { read_yaml_camera(path); })}};
  return list;
}

}  // namespace

std::vector<std::string> target_names() {
  std::vector<std::string> names;
  for (const Target& target : targets()) names.emplace_back(target.name);
  return names;
}

bool run_target(std::string_view name, std::string_view bytes) {
  for (const Target& target : targets()) {
    if (name != target.name) continue;
    try {
      target.run(bytes);
    } catch (const Error&) {
    }
    return true;
  }
  return false;
}

}  // namespace plumbline::fuzz
