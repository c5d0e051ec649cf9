// 7-Scenes (Shotton et al. 2013): frames named frame-000000.depth.png with their poses beside them.
#include <fmt/format.h>

#include <algorithm>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/seven_scenes.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// PNG in 7-Scenes and 3DMatch, JPEG in 12-Scenes and BundleFusion.
std::string color_beside(const std::string& stem) {
  for (const char* extension : {"color.png", "color.jpg"})
    if (is_file(stem + extension)) return stem + extension;
  return {};
}

bool list_sequence_folder(const SequenceOptions& options, SequenceList* list) {
  const std::vector<NumberedFile> depth = seven_scenes_files(list->folder, ".depth.png");
  if (depth.empty()) return false;
  bool has_color = false;
  for (const NumberedFile& file : depth) {
    const std::string stem = file.path.substr(0, file.path.size() - std::string_view("depth.png").size());
    const std::string color = options.color ? color_beside(stem) : std::string();
    has_color = has_color || !color.empty();
    list->entries.push_back({time_at_30_hz(file.number), file.path, color});
  }
  list->format = "7-Scenes";
  list->format_camera = "7scenes";
  list->depth_scale = 1000;
  list->depth_scale_source = "the format's own (7-Scenes, millimetres)";
  for (std::uint32_t value = 0; value < 65536; ++value)
    list->reading_of.push_back(value == 65535 ? std::uint16_t{0} : static_cast<std::uint16_t>(value));
  take_recorded_camera(options, list);
  if (has_color && !list->camera)
    list->notes.emplace_back("7-Scenes' colour images are not registered to depth; colours lie a few pixels off");
  if (!seven_scenes_files(list->folder, ".pose.txt").empty()) list->groundtruth = list->folder;
  return true;
}

/// The seq-* folders of a scene.
std::vector<std::string> sub_sequences(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : entries_of(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory(error) && name.starts_with("seq-")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool list_scene(const SequenceOptions& options, SequenceList* list) {
  const std::vector<std::string> sequences = sub_sequences(list->folder);
  if (sequences.empty()) return false;
  if (sequences.size() > 1)
    throw Error(fmt::format("holds {} sequences: {}", sequences.size(), fmt::join(sequences, ", ")), list->folder,
                "give the folder of one of them");
  list->folder = (fs::path(list->folder) / sequences.front()).string();
  if (!list_sequence_folder(options, list)) return false;
  list->notes.push_back("reading its only sequence, " + sequences.front());
  return true;
}

}  // namespace

bool list_seven_scenes(const SequenceOptions& options, SequenceList* list) {
  return list_sequence_folder(options, list) || list_scene(options, list);
}

}  // namespace plumbline
