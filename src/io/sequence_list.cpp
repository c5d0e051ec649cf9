#include "io/sequence_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "io/camera.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "plumbline/error.h"
#include "plumbline/time.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

/// File tests that call an unreadable path a missing one, where std::filesystem's would throw.
bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

/// What a folder holds, in no order. Throws Error if it cannot be listed; a missing folder holds nothing.
std::vector<fs::directory_entry> entries_of(const fs::path& folder) {
  std::vector<fs::directory_entry> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) entries.push_back(*it);
  if (error && error != std::errc::no_such_file_or_directory)
    throw Error("the folder cannot be listed: " + error.message(), folder.string(), "check that you may read it");
  return entries;
}

constexpr const char* kListAdvice = "write each line as: seconds file-name";
constexpr const char* kAssociationsAdvice = "write each line as: seconds depth-file seconds colour-file";

// ---- Lists of stamped files
// ------------------------------------------------------------------------------------------

struct StampedFile {
  Nanoseconds time = 0;
  std::string path;
};

bool by_time(const StampedFile& a, const StampedFile& b) { return a.time < b.time; }

/// Lines that are read one by one with `read_line(line)`; a half-written last one is noted and left out.
template <class ReadLine>
void read_lines(const TextFile& file, std::size_t fields_needed, std::vector<std::string>* notes,
                ReadLine&& read_line) {
  for (const TextLine& line : file.lines()) {
    const bool lacks_fields = split_fields(line.text).size() < fields_needed;
    if (line.is_last && lacks_fields) {
      notes->push_back(fmt::format("the last line of {} ({}) is half-written and was left out",
                                   fs::path(file.path()).filename().string(), line.number));
      continue;
    }
    read_line(line);
  }
}

/// "seconds file", where the file's name may hold blanks.
std::vector<StampedFile> read_list(const fs::path& folder, const std::string& name, std::vector<std::string>* notes) {
  const TextFile file((folder / name).string());
  std::vector<StampedFile> files;
  read_lines(file, 2, notes, [&](const TextLine& line) {
    const std::string_view stamp = split_fields(line.text).front();
    const std::string_view path = trim(line.text.substr(stamp.size()));
    if (path.empty()) file.fail(line, "has no file name after the time", kListAdvice);
    files.push_back({stamp_of(file, line, stamp, kListAdvice), (folder / path).string()});
  });
  return files;
}

/// Leaves out files that are not there; returns how many.
std::size_t drop_missing(std::vector<StampedFile>* files) {
  const auto is_missing = [](const StampedFile& f) { return !is_file(f.path); };
  const std::size_t before = files->size();
  files->erase(std::remove_if(files->begin(), files->end(), is_missing), files->end());
  return before - files->size();
}

/// Order of time, one file a stamp. `what` names the files in notes.
void sort_and_thin(const std::string& what, std::vector<StampedFile>* files, std::vector<std::string>* notes) {
  if (!std::is_sorted(files->begin(), files->end(), by_time)) {
    std::stable_sort(files->begin(), files->end(), by_time);
    notes->push_back(fmt::format("the {} images were not listed in order of time and have been sorted", what));
  }
  const std::size_t before = files->size();
  files->erase(std::unique(files->begin(), files->end(),
                           [](const StampedFile& a, const StampedFile& b) { return a.time == b.time; }),
               files->end());
  if (files->size() < before)
    notes->push_back(
        fmt::format("{} {} images with the stamp of an earlier one were left out", before - files->size(), what));
}

/// The existing depth images of a list. Throws if there is none.
void keep_depth(const std::string& list, std::vector<StampedFile>* depth, std::vector<std::string>* notes) {
  if (depth->empty()) throw Error("lists no depth images", list, kListAdvice);
  const std::size_t listed = depth->size(), missing = drop_missing(depth);
  if (depth->empty())
    throw Error(fmt::format("none of the {} listed depth images is there", listed), list,
                "unpack the whole sequence, the folder of depth images included");
  if (missing > 0)
    notes->push_back(fmt::format("{} of the {} listed depth images are missing and were left out", missing, listed));
  sort_and_thin("depth", depth, notes);
}

void keep_color(std::vector<StampedFile>* color, std::vector<std::string>* notes) {
  const std::size_t listed = color->size(), missing = drop_missing(color);
  if (missing > 0 && color->empty()) {
    notes->push_back(fmt::format("none of the {} listed colour images is there; going on without colour", listed));
  } else if (missing > 0) {
    notes->push_back(fmt::format("{} of the {} listed colour images are missing and were left out", missing, listed));
  }
  sort_and_thin("colour", color, notes);
}

// ---- Association
// -----------------------------------------------------------------------------------------------------

/// One-to-one pairs of depth and colour, nearest first: TUM's associate.py. Both by time. The result has, for each
/// depth image, the index of its colour image or −1.
std::vector<int> associate(const std::vector<StampedFile>& depth, const std::vector<StampedFile>& color,
                           Nanoseconds max_difference) {
  struct Pair {
    Nanoseconds difference;
    int depth, color;
  };
  std::vector<Pair> pairs;
  std::size_t first = 0;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    while (first < color.size() && color[first].time < depth[i].time - max_difference) ++first;
    for (std::size_t j = first; j < color.size() && color[j].time <= depth[i].time + max_difference; ++j)
      pairs.push_back({std::abs(color[j].time - depth[i].time), static_cast<int>(i), static_cast<int>(j)});
  }
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.difference < b.difference; });
  std::vector<int> color_of(depth.size(), -1);
  std::vector<bool> taken(color.size(), false);
  for (const Pair& pair : pairs) {
    if (color_of[pair.depth] >= 0 || taken[pair.color]) continue;
    color_of[pair.depth] = pair.color;
    taken[pair.color] = true;
  }
  return color_of;
}

std::vector<SequenceEntry> join(const std::vector<StampedFile>& depth, const std::vector<StampedFile>& color,
                                Nanoseconds max_difference, std::vector<std::string>* notes) {
  const std::vector<int> color_of = associate(depth, color, max_difference);
  std::vector<SequenceEntry> entries;
  for (std::size_t i = 0; i < depth.size(); ++i)
    entries.push_back({depth[i].time, depth[i].path, color_of[i] < 0 ? std::string() : color[color_of[i]].path});
  const auto without = std::count(color_of.begin(), color_of.end(), -1);
  if (!color.empty() && without > 0)
    notes->push_back(fmt::format("{} of {} depth images have no colour image within {:.3g} s", without, depth.size(),
                                 to_seconds(max_difference)));
  return entries;
}

// ---- TUM and ICL-NUIM
// ------------------------------------------------------------------------------------------------

Nanoseconds max_difference(const SequenceOptions& options) {
  const double seconds = options.max_time_difference;
  if (!(seconds >= 0 && seconds <= 1e6))
    throw Error(fmt::format("the greatest time difference of depth and colour cannot be {} s", seconds),
                "max_time_difference", "give seconds, such as 0.02");
  return from_seconds(seconds);
}

void list_stamped_files(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  std::vector<StampedFile> depth = read_list(folder, "depth.txt", &list->notes), color;
  keep_depth((folder / "depth.txt").string(), &depth, &list->notes);
  if (options.color && is_file(folder / "rgb.txt")) {
    color = read_list(folder, "rgb.txt", &list->notes);
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

struct Associations {
  std::vector<StampedFile> depth;
  std::vector<std::string> color;  // of depth[i]
  bool integer_stamps = true;
};

Associations read_associations(const fs::path& folder, std::vector<std::string>* notes) {
  const TextFile file((folder / "associations.txt").string());
  Associations result;
  read_lines(file, 4, notes, [&](const TextLine& line) {
    const std::vector<std::string_view> fields = split_fields(line.text);
    if (fields.size() != 4) file.fail(line, fmt::format("has {} fields, not 4", fields.size()), kAssociationsAdvice);
    const std::size_t at = depth_is_first(file, line, fields[1], fields[3]) ? 0 : 2;
    stamp_of(file, line, fields[2 - at], kAssociationsAdvice);
    result.depth.push_back({stamp_of(file, line, fields[at], kAssociationsAdvice), (folder / fields[at + 1]).string()});
    result.color.push_back((folder / fields[3 - at]).string());
    result.integer_stamps = result.integer_stamps && parse_unsigned(fields[at]).has_value();
  });
  return result;
}

void list_associations(const SequenceOptions& options, Associations pairs, SequenceList* list) {
  // The colour paths follow their depth images through sorting by the depth path.
  std::vector<std::pair<std::string, std::string>> color_of;
  for (std::size_t i = 0; i < pairs.depth.size(); ++i) color_of.emplace_back(pairs.depth[i].path, pairs.color[i]);
  std::stable_sort(color_of.begin(), color_of.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  keep_depth((fs::path(list->folder) / "associations.txt").string(), &pairs.depth, &list->notes);

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

/// The words by which ICL-NUIM's own archives are named.
bool is_named_like_icl(const std::string& folder) {
  for (const std::string& given : folder_names(folder)) {
    const std::string name = lower(given);
    if (contains_word(name, "icl") || contains_word(name, "icl_nuim") ||
        name.find("living_room") != std::string::npos || name.find("office_kt") != std::string::npos)
      return true;
    const std::size_t traj = name.find("traj");  // traj0 … traj3, but not "trajectory"
    if (traj != std::string::npos && traj + 4 < name.size() && name[traj + 4] >= '0' && name[traj + 4] <= '3')
      return true;
  }
  return false;
}

void describe_as_tum(SequenceList* list) {
  list->format = "TUM RGB-D";
  list->format_camera = "kinect";
  list->format_camera_is_guess = true;
  list->depth_scale = 5000;
  list->depth_scale_source = "the format's own (TUM RGB-D)";
}

void describe_as_icl(SequenceList* list) {
  list->format = "ICL-NUIM";
  list->format_camera = "icl";
  list->depth_scale = 5000;
  list->depth_scale_source = "the format's own (ICL-NUIM)";
  list->stamps_are_frame_numbers = true;
}

/// groundtruth.txt, or ICL-NUIM's traj3.gt.freiburg.
std::string find_groundtruth(const fs::path& folder) {
  if (is_file(folder / "groundtruth.txt")) return (folder / "groundtruth.txt").string();
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (entry.path().string().ends_with(".gt.freiburg")) found.push_back(entry.path().string());
  return found.size() == 1 ? found.front() : std::string();
}

bool list_tum_or_icl(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  const bool named_icl = is_named_like_icl(list->folder);
  bool is_icl = named_icl;
  if (is_file(folder / "depth.txt")) {
    list_stamped_files(options, list);
  } else if (is_file(folder / "associations.txt")) {
    Associations pairs = read_associations(folder, &list->notes);
    is_icl = is_icl || (pairs.integer_stamps && !pairs.depth.empty());
    list_associations(options, std::move(pairs), list);
  } else if (!named_icl || !list_numbered_depth(options, list)) {
    list->entries.clear();
    return false;
  }
  is_icl ? describe_as_icl(list) : describe_as_tum(list);
  list->groundtruth = find_groundtruth(folder);
  return true;
}

// ---- 7-Scenes
// --------------------------------------------------------------------------------------------------------

bool list_seven_scenes(const SequenceOptions& options, SequenceList* list) {
  const std::vector<NumberedFile> depth = seven_scenes_files(list->folder, ".depth.png");
  if (depth.empty()) return false;
  bool has_color = false;
  for (const NumberedFile& file : depth) {
    std::string color = file.path.substr(0, file.path.size() - std::string_view("depth.png").size()) + "color.png";
    if (!options.color || !is_file(color)) color.clear();
    has_color = has_color || !color.empty();
    list->entries.push_back({time_at_30_hz(file.number), file.path, color});
  }
  list->format = "7-Scenes";
  list->format_camera = "7scenes";
  list->depth_scale = 1000;
  list->depth_scale_source = "the format's own (7-Scenes, millimetres)";
  list->saturated_is_invalid = true;
  if (has_color)
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
  if (!list_seven_scenes(options, list)) return false;
  list->notes.push_back("reading its only sequence, " + sequences.front());
  return true;
}

// ---- Plain folders
// ---------------------------------------------------------------------------------------------------

/// Order in which people count: runs of digits compare as numbers, so 2 comes before 10.
bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto run = [&](const std::string& s, std::size_t* at) {
    while (*at < s.size() && s[*at] == '0') ++*at;
    const std::size_t begin = *at;
    while (*at < s.size() && digit(s[*at])) ++*at;
    return std::string_view(s).substr(begin, *at - begin);
  };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      const std::string_view x = run(a, &i), y = run(b, &j);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i, ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // 01 and 1
}

/// The name as decimal seconds; whole numbers are taken for a count.
std::optional<Nanoseconds> stamp_in_name(const fs::path& path) {
  const std::string stem = path.stem().string();
  return stem.find('.') == std::string::npos ? std::nullopt : parse_seconds(stem);
}

bool list_depth_images(const fs::path& folder, SequenceList* list) {
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
  std::stable_sort(files.begin(), files.end(), by_time);  // negative stamps run backwards by name
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

std::string checked_folder(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw Error("there is no such folder", path, "check the path");
  if (!fs::is_directory(path, error)) throw Error("is a file, not the folder of a sequence", path, "give the folder");
  entries_of(path);
  return path;
}

}  // namespace

SequenceList list_sequence(const std::string& path, const SequenceOptions& options) {
  SequenceList list;
  list.folder = checked_folder(path);
  if (list_tum_or_icl(options, &list) || list_seven_scenes(options, &list) || list_scene(options, &list) ||
      list_depth_images(list.folder, &list) || list_depth_images(fs::path(list.folder) / "depth", &list))
    return list;
  throw Error(
      "the folder holds no sequence that is known", path,
      "give a folder with depth.txt (TUM RGB-D), associations.txt (ICL-NUIM), frame-000000.depth.png (7-Scenes) "
      "or 16-bit depth PNG files");
}

}  // namespace plumbline
