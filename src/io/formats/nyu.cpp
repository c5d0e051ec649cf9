// NYU Depth v1 and v2, raw: d-STAMP-TICKS.pgm with the Kinect's 11-bit readings, r-STAMP-TICKS.ppm, neither registered.
// Formula and calibration are those of the data set's toolbox (Silberman et al. 2012): depth_rel2depth_abs.m and
// camera_params.m.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/images/image_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr int kNoReading = 2047;
constexpr double kScale = 5000, kMaxNyuDepth = 10;  // readings a metre; m, as the toolbox cuts off

/// d-1294886362.665769-2143162612.pgm
std::vector<StampedFile> files_of(const fs::path& folder, std::string_view prefix, std::string_view extension) {
  std::vector<StampedFile> files;
  for (const fs::directory_entry& entry : entries_of(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(extension)) continue;
    const std::string rest = name.substr(prefix.size());
    const auto time = parse_seconds(rest.substr(0, rest.find('-')));
    if (time && rest.find('-') != std::string::npos) files.push_back({*time, entry.path().string()});
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return files;
}

/// The Kinect's 11 bits as a distance: z = 351.3 / (1092.5 − raw). 0 where there is none.
std::uint16_t reading_of_raw(int raw) {
  const double metres = 351.3 / (1092.5 - raw);
  if (raw <= 0 || raw >= kNoReading || !(metres > 0 && metres <= kMaxNyuDepth)) return 0;
  return static_cast<std::uint16_t>(std::lround(metres * kScale));
}

/// The recorder wrote the lower byte first, against PGM's rule: then readings of 11 bits do not fit into 11.
bool is_swapped(const std::vector<StampedFile>& files) {
  constexpr std::size_t kLooks = 5;
  for (std::size_t i = 0; i < files.size(); i += files.size() / kLooks + 1) try {
      const DepthImage depth = read_depth_image(files[i].path);
      const auto fits = [](std::uint16_t v) { return v <= kNoReading; };
      if (!std::all_of(depth.pixels.begin(), depth.pixels.end(), fits)) return true;
    } catch (const Error&) {  // its frame will tell
    }
  return false;
}

void set_readings(const std::vector<StampedFile>& files, SequenceList* list) {
  const bool swapped = is_swapped(files);
  for (int value = 0; value < 65536; ++value)
    list->reading_of.push_back(reading_of_raw(swapped ? (value & 255) << 8 | value >> 8 : value));
  list->depth_scale = kScale;
  list->depth_scale_source = "the data set's own (NYU Depth, 351.3 / (1092.5 - raw) metres)";
}

void set_cameras(SequenceList* list) {
  list->camera = CameraChoice{{582.62448f, 582.69103f, 313.04476f, 238.44390f, 640, 480},
                              {-9.9897236553084481e-02, 3.9065324602765344e-01, 1.9290592870229277e-03,
                               -1.9422022475975055e-03, -5.1031725053400578e-01},
                              "the data set's own (NYU Depth v2, camera_params.m)",
                              false};
  list->color_camera = Pinhole{518.85790f, 519.46961f, 325.58245f, 253.73617f, 640, 480};
  // The colour camera 2.5 cm to the right. The toolbox writes both with the opposite sign, which cancels.
  Eigen::Matrix3d rotation;
  rotation << 9.9997798940829263e-01, -5.0359919480810989e-03, -4.3196624923060242e-03,  //
      5.0518419386157446e-03, 9.9998051861143999e-01, 3.6662365748484798e-03,            //
      4.3011152014118693e-03, -3.6879781309514218e-03, 9.9998394948385538e-01;
  list->color_from_depth =
      SE3(Eigen::Quaterniond(rotation),
          -Eigen::Vector3d(2.5031875059141302e-02, 6.6238747008330102e-04, -2.9342312935846411e-04));
}

}  // namespace

bool list_nyu(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  std::vector<StampedFile> depth = files_of(folder, "d-", ".pgm");
  if (depth.empty()) return false;
  std::vector<StampedFile> color = options.color ? files_of(folder, "r-", ".ppm") : std::vector<StampedFile>{};
  order_depth(&depth, &list->warnings);
  sort_and_thin("colour", &color, &list->notes);
  list->entries = join(depth, color, max_difference(options), &list->notes);
  list->format = "NYU Depth, raw";
  set_readings(depth, list);
  set_cameras(list);
  if (!files_of(folder, "a-", ".dump").empty())
    list->notes.emplace_back("the accelerometer (a-*.dump) is not used, because it gives the tilt alone");
  return true;
}

}  // namespace plumbline
