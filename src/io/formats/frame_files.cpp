#include "io/formats/frame_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "io/camera.h"
#include "io/columns.h"
#include "io/imu_file.h"
#include "io/recorded_camera.h"
#include "io/seven_scenes.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kListAdvice = "write each line as: seconds file-name";

bool by_time(const StampedFile& a, const StampedFile& b) { return a.time < b.time; }
bool same_time(const StampedFile& a, const StampedFile& b) { return a.time == b.time; }

/// Leaves out files that are not there; returns how many.
std::size_t drop_missing(std::vector<StampedFile>* files) {
  const auto is_missing = [](const StampedFile& f) { return !is_file(f.path); };
  const std::size_t before = files->size();
  files->erase(std::remove_if(files->begin(), files->end(), is_missing), files->end());
  return before - files->size();
}

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

/// Whether two cameras see the same pixels, to a thousandth; sizes that are not told do not count.
bool same_pixels(const Pinhole& a, const Pinhole& b) {
  const float limit = 1e-3f * b.fx;
  const bool same_size = a.width == 0 || b.width == 0 || (a.width == b.width && a.height == b.height);
  return same_size && std::abs(a.fx - b.fx) < limit && std::abs(a.fy - b.fy) < limit && std::abs(a.cx - b.cx) < limit &&
         std::abs(a.cy - b.cy) < limit;
}

}  // namespace

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool is_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

std::vector<fs::directory_entry> entries_of(const fs::path& folder) {
  std::vector<fs::directory_entry> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) entries.push_back(*it);
  if (error && error != std::errc::no_such_file_or_directory)
    throw Error("the folder cannot be listed: " + error.message(), folder.string(), "check that you may read it");
  return entries;
}

std::string listed_file(const fs::path& folder, std::string_view name) {
  fs::path path = folder / name;
  if (is_file(path)) return path.string();
  std::string slashes(name);
  std::replace(slashes.begin(), slashes.end(), '\\', '/');
  const fs::path listed(slashes);
  for (const fs::path& place :
       {folder / listed, folder / listed.parent_path().filename() / listed.filename(), folder / listed.filename()})
    if (is_file(place)) return place.string();
  return path.string();
}

int decimals_of_list(const TextFile& file) {
  if (file.lines().empty()) return 0;
  const int by_size = decimals_by_size(first_field(file.lines().front()));
  if (by_size > 0) return by_size;
  std::vector<double> stamps;
  for (const TextLine& line : file.lines()) {
    const auto whole = parse_unsigned(first_field(line));
    if (!whole) return 0;
    stamps.push_back(static_cast<double>(*whole));
  }
  return decimals_by_interval(std::move(stamps));
}

std::vector<StampedFile> read_list(const std::string& name, SequenceList* list) {
  const TextFile file((fs::path(list->folder) / name).string());
  std::vector<StampedFile> files;
  const int decimals = decimals_of_list(file);
  read_lines(file, 2, &list->notes, [&](const TextLine& line) {
    const std::string_view stamp = first_field(line);
    std::string_view path = trim(line.text.substr(std::min(line.text.find(stamp) + stamp.size(), line.text.size())));
    if (path.starts_with(',') || path.starts_with(';')) path = trim(path.substr(1));
    if (path.empty()) file.fail(line, "has no file name after the time", kListAdvice);
    files.push_back({stamp_of(file, line, stamp, kListAdvice, decimals), listed_file(list->folder, path)});
  });
  if (decimals > 0)
    list->warnings.push_back(
        {fmt::format("the stamps of {} are taken for {}, by their size or interval, where seconds are expected", name,
                     unit_of_decimals(decimals)),
         "Write each image's time in seconds, or check that this is so."});
  return files;
}

bool spread_equal_stamps(std::vector<StampedFile>* files) {
  if (files->size() < 3) return false;
  std::map<Nanoseconds, std::size_t> counts;
  for (const StampedFile& file : *files) ++counts[file.time];
  if (2 * counts.size() > files->size()) return false;
  for (std::size_t i = 0; i < files->size(); ++i) (*files)[i].time = time_at_30_hz(static_cast<long long>(i));
  return true;
}

bool spread_counted_stamps(std::vector<StampedFile>* files) {
  if (files->size() < 3 || files->front().time < 0 || files->front().time > kNanosecondsPerSecond) return false;
  for (std::size_t i = 1; i < files->size(); ++i)
    if ((*files)[i].time != (*files)[i - 1].time + kNanosecondsPerSecond) return false;
  for (StampedFile& file : *files) file.time = time_at_30_hz(file.time / kNanosecondsPerSecond);
  return true;
}

void sort_and_thin(const std::string& what, std::vector<StampedFile>* files, std::vector<std::string>* notes) {
  if (!std::is_sorted(files->begin(), files->end(), by_time)) {
    std::stable_sort(files->begin(), files->end(), by_time);
    notes->push_back(fmt::format("the {} images were not listed in order of time and have been sorted", what));
  }
  const std::size_t before = files->size();
  files->erase(std::unique(files->begin(), files->end(), same_time), files->end());
  if (files->size() < before)
    notes->push_back(
        fmt::format("{} {} images with the stamp of an earlier one were left out", before - files->size(), what));
}

void order_depth(std::vector<StampedFile>* depth, std::vector<Warning>* warnings) {
  int backwards = 0;
  std::string first;
  for (std::size_t i = 1; i < depth->size(); ++i)
    if (const StampedFile& before = (*depth)[i - 1], &file = (*depth)[i]; file.time < before.time && backwards++ == 0)
      first = fmt::format("{} is {:.3g} s before the one listed before it", fs::path(file.path).filename().string(),
                          to_seconds(before.time - file.time));
  if (backwards > 0)
    warnings->push_back({fmt::format("the depth images' stamps run backwards in {} place{} ({}); the images have been "
                                     "sorted by their stamps",
                                     backwards, backwards == 1 ? "" : "s", first),
                         "Check that the stamps are of one clock, and the images of one recording."});
  const std::size_t listed = depth->size();
  std::stable_sort(depth->begin(), depth->end(), by_time);
  const auto doubled = std::adjacent_find(depth->begin(), depth->end(), same_time);
  if (doubled == depth->end()) return;
  const std::string where = fmt::format("{:.6f} s", to_seconds(doubled->time));
  depth->erase(std::unique(depth->begin(), depth->end(), same_time), depth->end());
  warnings->push_back({fmt::format("{} of the {} depth images have the stamp of an earlier one and were left out, the "
                                   "first at {}",
                                   listed - depth->size(), listed, where),
                       "Give each image its own time."});
}

void keep_depth(const std::string& list_file, std::vector<StampedFile>* depth, SequenceList* list) {
  if (depth->empty()) throw Error("lists no depth images", list_file, kListAdvice);
  const std::size_t listed = depth->size(), missing = drop_missing(depth);
  if (depth->empty())
    throw Error(fmt::format("none of the {} listed depth images is there", listed), list_file,
                "unpack the whole sequence, the folder of depth images included");
  if (missing > 0)
    list->notes.push_back(
        fmt::format("{} of the {} listed depth images are missing and were left out", missing, listed));
  order_depth(depth, &list->warnings);
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

Nanoseconds max_difference(const SequenceOptions& options) {
  const double seconds = options.max_time_difference;
  if (!(seconds >= 0 && seconds <= 1e6))
    throw Error(fmt::format("the greatest time difference of depth and colour cannot be {} s", seconds),
                "max_time_difference", "give seconds, such as 0.02");
  return from_seconds(seconds);
}

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

void take_recorded_camera(const SequenceOptions& options, SequenceList* list) {
  std::vector<Warning> warnings;
  const auto recorded = find_recorded_camera(list->folder, &warnings);
  const bool is_given = options.intrinsics || !options.camera.empty();
  if (!is_given) list->warnings.insert(list->warnings.end(), warnings.begin(), warnings.end());
  if (!recorded && !warnings.empty()) list->camera_refusal = "; " + warnings.front().what;
  if (!recorded) return;
  list->camera = recorded->choice;
  const SE3& moved = recorded->color_from_depth;
  const bool is_moved = !moved.rotation().isIdentity(1e-6) || !moved.translation().isZero(1e-6);
  if (recorded->color && (is_moved || !same_pixels(*recorded->color, recorded->choice.camera))) {
    list->color_camera = recorded->color;
    list->color_from_depth = moved;
  }
  if (recorded->body_from_camera) list->body_from_camera = recorded->body_from_camera;
  if (recorded->depth_scale <= 0) return;
  list->depth_scale = recorded->depth_scale;
  list->depth_scale_source = recorded->choice.source;
  list->depth_scale_is_guess = false;
}

void note_unused_files(SequenceList* list) {
  const bool has_color = std::any_of(list->entries.begin(), list->entries.end(),
                                     [](const SequenceEntry& entry) { return !entry.color.empty(); });
  const bool has_sensor = list->read_imu || !find_imu_file(list->folder).empty();
  for (const fs::directory_entry& entry : entries_of(list->folder)) {
    const std::string name = entry.path().filename().string(), small = lower(name);
    const std::string extension = lower(entry.path().extension().string());
    const auto has = [&](std::string_view word) { return small.find(word) != std::string::npos; };
    const bool is_text = extension == ".txt" || extension == ".csv";
    if (!is_file(entry.path())) continue;
    if (is_text && !has_sensor && (has("orient") || has("quat")))
      list->notes.push_back(fmt::format("{} is not used: --orientation {} names it as an orientation sensor's", name,
                                        entry.path().string()));
    else if (is_text && list->groundtruth.empty() && (has("pose") || has("traj") || has("truth")))
      list->notes.push_back(
          fmt::format("{} is not used: --groundtruth {} names it as true poses", name, entry.path().string()));
    else if (!has_color && (extension == ".mp4" || extension == ".mov" || extension == ".avi" || extension == ".mkv") &&
             list->format != "StrayScanner")
      list->notes.push_back(
          fmt::format("{} is not used, because colour is read from images: unpack it into rgb/", name));
  }
}

std::string find_groundtruth(const fs::path& folder) {
  if (is_file(folder / "groundtruth.txt")) return (folder / "groundtruth.txt").string();
  std::vector<std::string> found;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (entry.path().string().ends_with(".gt.freiburg")) found.push_back(entry.path().string());
  return found.size() == 1 ? found.front() : std::string();
}

}  // namespace plumbline
