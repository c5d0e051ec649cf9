// TUM RGB-D and ICL-NUIM: lists of stamped files.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/columns.h"
#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAssociationsAdvice = "write each line as: seconds depth-file seconds colour-file";

/// Whether true poses lie there that count frames as well, as ICL-NUIM's do: then both are left as they are.
bool truth_counts_frames(const fs::path& folder) {
  const std::string path = find_groundtruth(folder);
  if (path.empty()) return false;
  const TextFile file(path);
  if (file.lines().size() < 2) return false;
  const auto first = parse_double(first_field(file.lines()[0])), second = parse_double(first_field(file.lines()[1]));
  return first && second && *first == std::floor(*first) && *second == *first + 1;
}

void list_stamped_files(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  std::vector<StampedFile> depth = read_list("depth.txt", list), color;
  const bool counted = !truth_counts_frames(folder) && spread_counted_stamps(&depth);
  if (counted)
    list->warnings.push_back({"the stamps in depth.txt count frames; the images are taken to be 1/30 s apart, a guess",
                              "Write each image's time in seconds into depth.txt."});
  const bool equal = spread_equal_stamps(&depth);
  if (equal)
    list->warnings.push_back(
        {"most images in depth.txt have the same stamp; they are taken to be 1/30 s apart, a guess",
         "Write each image's time in seconds into depth.txt."});
  keep_depth((folder / "depth.txt").string(), &depth, list);
  if (options.color && is_file(folder / "rgb.txt")) {
    color = read_list("rgb.txt", list);
    if (equal) spread_equal_stamps(&color);
    if (counted) spread_counted_stamps(&color);
    keep_color(&color, &list->notes);
  }
  list->entries = join(depth, color, max_difference(options), &list->notes);
}

/// Whether the first file of an association line is the depth image, by its folder or name.
bool depth_is_first(const TextFile& file, const TextLine& line, std::string_view first, std::string_view second) {
  const bool in_first = first.find("depth") != std::string_view::npos;
  const bool in_second = second.find("depth") != std::string_view::npos;
  if (in_first == in_second) file.fail(line, "cannot be told which of the two files is depth", kAssociationsAdvice);
  return in_first;
}

/// associations.txt, or what people call it (associate.txt, association.txt, rgbd_assoc.txt) if its files are there;
/// empty without one.
std::string associations_file(const fs::path& folder) {
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : entries_of(folder)) {
    const std::string name = lower(entry.path().filename().string());
    if (name == "associations.txt") return entry.path().string();
    if (name.find("assoc") != std::string::npos && name.ends_with(".txt") && is_file(entry.path()))
      files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  for (const std::string& path : files) {
    const TextFile file(path);
    const auto fields =
        file.lines().empty() ? std::vector<std::string_view>() : split_fields(file.lines().front().text, true);
    const auto is_there = [&](std::size_t i) { return is_file(listed_file(folder, fields[i])); };
    if (fields.size() == 4 && is_there(1) && is_there(3)) return path;
  }
  return {};
}

struct Associations {
  std::vector<StampedFile> depth;
  std::vector<std::string> color;  // of depth[i]
  bool integer_stamps = true;
};

Associations read_associations(const fs::path& folder, std::vector<std::string>* notes) {
  const TextFile file(associations_file(folder));
  Associations result;
  read_lines(file, 4, notes, [&](const TextLine& line) {
    std::vector<std::string_view> fields = split_fields(line.text);
    if (fields.size() != 4) fields = split_fields(line.text, true);
    if (fields.size() != 4) file.fail(line, fmt::format("has {} fields, not 4", fields.size()), kAssociationsAdvice);
    const std::size_t at = depth_is_first(file, line, fields[1], fields[3]) ? 0 : 2;
    stamp_of(file, line, fields[2 - at], kAssociationsAdvice);
    result.depth.push_back(
        {stamp_of(file, line, fields[at], kAssociationsAdvice), listed_file(folder, fields[at + 1])});
    result.color.push_back(listed_file(folder, fields[3 - at]));
    result.integer_stamps = result.integer_stamps && parse_unsigned(fields[at]).has_value();
  });
  return result;
}

void list_associations(const SequenceOptions& options, Associations pairs, SequenceList* list) {
  // The colour paths follow their depth images through sorting by the depth path.
  std::vector<std::pair<std::string, std::string>> color_of;
  for (std::size_t i = 0; i < pairs.depth.size(); ++i) color_of.emplace_back(pairs.depth[i].path, pairs.color[i]);
  std::stable_sort(color_of.begin(), color_of.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  keep_depth(associations_file(list->folder), &pairs.depth, list);

  std::size_t missing = 0;
  for (const StampedFile& depth : pairs.depth) {
    const auto found = std::lower_bound(color_of.begin(), color_of.end(), depth.path,
                                        [](const auto& a, const std::string& path) { return a.first < path; });
    const bool there = options.color && is_file(found->second);
    if (options.color && !there) ++missing;
    list->entries.push_back({depth.time, depth.path, there ? found->second : std::string()});
  }
  if (missing > 0)
    list->notes.push_back(fmt::format("{} of the {} listed colour images are missing", missing, pairs.depth.size()));
}

std::vector<fs::path> png_files(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (lower(entry.path().extension().string()) == ".png" && is_file(entry.path())) files.push_back(entry.path());
  return files;
}

std::string color_beside(const fs::path& folder, const fs::path& depth) {
  for (const char* extension : {".png", ".jpg", ".jpeg"}) {
    const fs::path path = folder / "rgb" / depth.stem().concat(extension);
    if (is_file(path)) return path.string();
  }
  return {};
}

/// ICL-NUIM as it is packed without a list: depth/N.png and rgb/N.png, where N is the stamp in its ground truth.
bool list_numbered_depth(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  for (const fs::path& path : png_files(folder / "depth")) {
    const auto number = parse_unsigned(path.stem().string());
    if (!number || *number > 1'000'000'000) return false;
    list->entries.push_back(
        {*number * kNanosecondsPerSecond, path.string(), options.color ? color_beside(folder, path) : std::string()});
  }
  std::sort(list->entries.begin(), list->entries.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return !list->entries.empty();
}

/// ICL-NUIM's archives keep their poses under a name that no other recording has; a folder's name says nothing.
bool has_icl_poses(const fs::path& folder) {
  const auto entries = entries_of(folder);
  return std::any_of(entries.begin(), entries.end(),
                     [](const auto& entry) { return entry.path().string().ends_with(".gt.freiburg"); });
}

void describe_as_tum(SequenceList* list) {
  list->format = "TUM RGB-D";
  list->format_camera = "kinect";
  list->format_camera_is_guess = true;
  list->depth_scale = 5000;
  list->depth_scale_is_guess = true;
  list->depth_scale_source = "the format's own (TUM RGB-D)";
}

void describe_as_icl(SequenceList* list) {
  list->format = "ICL-NUIM";
  list->format_camera = "icl";
  list->depth_scale = 5000;
  list->depth_scale_source = "the format's own (ICL-NUIM)";
  list->stamps_are_frame_numbers = true;
}

}  // namespace

bool list_tum_or_icl(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  bool is_icl = has_icl_poses(folder);
  if (is_file(folder / "depth.txt")) {
    list_stamped_files(options, list);
  } else if (!associations_file(folder).empty()) {
    Associations pairs = read_associations(folder, &list->notes);
    const bool by_stamps = !is_icl && pairs.integer_stamps && !pairs.depth.empty();
    list_associations(options, std::move(pairs), list);
    if (by_stamps)
      list->notes.emplace_back("taken for ICL-NUIM, a guess, because the associations have whole numbers for stamps");
    is_icl = is_icl || by_stamps;
  } else if (!is_icl || !list_numbered_depth(options, list)) {
    list->entries.clear();
    return false;
  }
  is_icl ? describe_as_icl(list) : describe_as_tum(list);
  take_recorded_camera(options, list);
  list->groundtruth = find_groundtruth(folder);
  return true;
}

}  // namespace plumbline
