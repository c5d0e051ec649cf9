// A plain folder of depth images.
#include <algorithm>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/seven_scenes.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> png_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (lower(entry.path().extension().string()) == ".png" && is_file(entry.path())) files.push_back(entry.path());
  return files;
}

/// The name as decimal seconds; whole numbers are taken for a count.
std::optional<Nanoseconds> stamp_in_name(const fs::path& path) {
  const std::string stem = path.stem().string();
  return stem.find('.') == std::string::npos ? std::nullopt : parse_seconds(stem);
}

bool list_images_in(const fs::path& folder, SequenceList* list) {
  std::vector<fs::path> paths = png_files(folder);
  if (paths.empty()) return false;
  std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  const bool stamped =
      std::all_of(paths.begin(), paths.end(), [](const fs::path& p) { return stamp_in_name(p).has_value(); });
  std::vector<StampedFile> files;
  files.reserve(paths.size());
  for (const fs::path& path : paths)
    files.push_back(
        {stamped ? *stamp_in_name(path) : time_at_30_hz(static_cast<long long>(files.size())), path.string()});
  std::stable_sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
    return a.time < b.time;
  });  // negative stamps run backwards by name
  sort_and_thin("depth", &files, &list->notes);
  for (const StampedFile& file : files) list->entries.push_back({file.time, file.path, {}});
  list->format = "depth images";
  list->groundtruth = find_groundtruth(list->folder);
  list->depth_scale = 1000;
  list->depth_scale_source = "millimetres, assumed";
  list->notes.emplace_back(stamped ? "the files' names are taken for their time in seconds"
                                   : "without stamps, the images are taken to be 1/30 s apart");
  return true;
}

}  // namespace

bool list_depth_images(const SequenceOptions&, SequenceList* list) {
  const fs::path folder = list->folder;
  return list_images_in(folder, list) || list_images_in(folder / "depth", list);
}

}  // namespace plumbline
