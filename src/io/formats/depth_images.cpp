// Folders of images that need no list: depth/ beside color/ (Open3D's recorder, Redwood, ScanNet, SUN3D and many),
// depth and colour side by side in one folder, and depth alone. What is depth is told by the names, else by the files.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/images/image_file.h"
#include "io/seven_scenes.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

enum class Kind { depth, color, confidence, other };

bool is_image(const fs::path& path) {
  static constexpr std::array kExtensions = {".png", ".jpg", ".jpeg", ".pgm", ".ppm", ".tif", ".tiff", ".exr", ".npy"};
  const std::string extension = lower(path.extension().string());
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

bool has_word(const std::string& name, std::initializer_list<std::string_view> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](std::string_view word) { return name.find(word) != std::string::npos; });
}

/// By the words in a name; empty if it has none of them.
std::optional<Kind> kind_by_name(const std::string& stem) {
  const std::string name = lower(stem);
  if (has_word(name, {"conf", "amplitude"})) return Kind::confidence;
  if (has_word(name, {"infra", "mask", "label", "normal", "semantic", "instance"}) || contains_word(name, "ir"))
    return Kind::other;
  if (has_word(name, {"depth"})) return Kind::depth;
  if (has_word(name, {"rgb", "color", "colour", "image", "frame", "img"})) return Kind::color;
  return std::nullopt;
}

/// By what the first of the files that can be read is. Where none can, they count as depth, and cost their frames.
Kind kind_by_content(const std::vector<fs::path>& paths) {
  for (const std::size_t i : {std::size_t{0}, paths.size() / 2, paths.size() - 1}) try {
      return read_image_header(paths[i].string()).is_depth ? Kind::depth : Kind::color;
    } catch (const Error&) {  // its frame will tell
    }
  return lower(paths.front().extension().string()).starts_with(".jp") ? Kind::color : Kind::depth;
}

/// A name with its digits left out: what all files of one kind share.
std::string pattern_of(const fs::path& path) {
  std::string pattern;
  for (const char c : path.filename().string())
    if (c < '0' || c > '9') pattern += c;
  return pattern;
}

using Images = std::map<Kind, std::vector<fs::path>>;

/// The images of one folder by their kinds.
Images images_of(const fs::path& folder) {
  std::map<std::string, std::vector<fs::path>> by_pattern;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (is_image(entry.path()) && is_file(entry.path())) by_pattern[pattern_of(entry.path())].push_back(entry.path());
  Images images;
  // With one kind alone, names such as frame000000.png say nothing.
  const bool mixed = std::any_of(by_pattern.begin(), by_pattern.end(), [](const auto& group) {
    return kind_by_name(fs::path(group.first).stem().string()) == Kind::depth;
  });
  for (auto& [pattern, paths] : by_pattern) {
    std::sort(paths.begin(), paths.end());
    const std::optional<Kind> named = kind_by_name(fs::path(pattern).stem().string());
    const bool trust = named && (mixed || *named != Kind::color);
    std::vector<fs::path>& of_kind = images[trust ? *named : kind_by_content(paths)];
    of_kind.insert(of_kind.end(), paths.begin(), paths.end());
  }
  return images;
}

/// The runs of digits in a name without leading zeros: what depth and colour of one frame share; the name without them.
std::string key_of(const fs::path& path) {
  std::string key;
  bool inside = false;
  for (const char c : path.stem().string()) {
    const bool digit = c >= '0' && c <= '9';
    if (digit && !inside) key += '-';
    inside = digit;
    if (digit && !(c == '0' && key.back() == '-')) key += c;
  }
  return key.empty() ? path.stem().string() : key;
}

/// The time that a name holds: decimal seconds, or the microseconds after a count (0000001-000000033369.png).
std::optional<Nanoseconds> stamp_in_name(const fs::path& path) {
  const std::string stem = path.stem().string();
  const std::size_t end = stem.find_first_not_of("0123456789.-+");
  const std::string number = stem.substr(0, end);
  if (number.find('.') != std::string::npos) {
    const std::size_t cut = number.find_last_of("0123456789");
    return cut == std::string::npos ? std::nullopt : parse_seconds(number.substr(0, cut + 1));
  }
  const std::size_t dash = stem.find('-');
  if (dash == std::string::npos || stem.size() - dash - 1 < 12) return std::nullopt;
  const auto microseconds = parse_unsigned(std::string_view(stem).substr(dash + 1));
  if (!microseconds || !parse_unsigned(std::string_view(stem).substr(0, dash)) || *microseconds > 4'000'000'000'000'000)
    return std::nullopt;
  return *microseconds * 1000;
}

std::vector<StampedFile> stamped(std::vector<fs::path> paths, bool* by_name) {
  std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  *by_name = std::all_of(paths.begin(), paths.end(), [](const fs::path& p) { return stamp_in_name(p).has_value(); });
  std::vector<StampedFile> files;
  for (const fs::path& path : paths)
    files.push_back(
        {*by_name ? *stamp_in_name(path) : time_at_30_hz(static_cast<long long>(files.size())), path.string()});
  std::stable_sort(files.begin(), files.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });  // negative ones run backwards
  return files;
}

/// Puts to each depth image the file of the same number.
int pair_by_number(const std::vector<fs::path>& files, std::string SequenceEntry::*member, SequenceList* list) {
  std::map<std::string, std::string> by_key;
  for (const fs::path& path : files) by_key.emplace(key_of(path), path.string());
  int paired = 0;
  for (SequenceEntry& entry : list->entries) {
    const auto found = by_key.find(key_of(entry.depth));
    if (found == by_key.end()) continue;
    entry.*member = found->second;
    ++paired;
  }
  return paired;
}

void pair_color(const SequenceOptions& options, const std::vector<fs::path>& files, bool depth_stamped,
                SequenceList* list) {
  if (files.empty() || !options.color) return;
  int paired = pair_by_number(files, &SequenceEntry::color, list);
  bool color_stamped = false;
  std::vector<StampedFile> colors = stamped(files, &color_stamped);
  if (2 * paired < static_cast<int>(list->entries.size()) && depth_stamped && color_stamped) {
    std::vector<StampedFile> depths;
    for (const SequenceEntry& entry : list->entries) depths.push_back({entry.time, entry.depth});
    list->entries = join(depths, colors, max_difference(options), &list->notes);
    return;
  }
  if (paired < static_cast<int>(list->entries.size()))
    list->notes.push_back(fmt::format("{} of {} depth images have no colour image of the same number",
                                      static_cast<int>(list->entries.size()) - paired, list->entries.size()));
}

/// SUN3D turns its readings' bits by three places: all of a hand's reach are multiples of eight.
bool has_rotated_bits(const SequenceList& list) {
  const bool sun3d = is_folder(fs::path(list.folder) / "extrinsics");
  try {
    const DepthImage depth = read_depth_image(list.entries.front().depth);
    const bool any = std::any_of(depth.pixels.begin(), depth.pixels.end(), [](std::uint16_t v) { return v != 0; });
    return sun3d && any &&
           std::all_of(depth.pixels.begin(), depth.pixels.end(), [](std::uint16_t v) { return v % 8 == 0; });
  } catch (const Error&) {
    return false;
  }
}

/// What the recording's own files say of the camera and the unit.
void describe_by_files(SequenceList* list) {
  list->depth_scale = 1000;
  list->depth_scale_source = "millimetres";
  list->depth_scale_is_guess = true;
  take_recorded_camera(list);
}

void fill(const SequenceOptions& options, const Images& images, const std::vector<fs::path>& depth,
          SequenceList* list) {
  bool by_name = false;
  std::vector<StampedFile> files = stamped(depth, &by_name);
  order_depth(&files, &list->warnings);
  for (const StampedFile& file : files) list->entries.push_back({file.time, file.path});
  const auto of = [&](Kind kind) { return images.contains(kind) ? images.at(kind) : std::vector<fs::path>{}; };
  pair_by_number(of(Kind::confidence), &SequenceEntry::confidence, list);
  pair_color(options, of(Kind::color), by_name, list);
  if (!of(Kind::other).empty())
    list->notes.push_back(fmt::format("{} is not used, because its name says neither depth nor colour",
                                      of(Kind::other).front().filename().string()));
  take_truth(list);
  describe_by_files(list);
  if (has_rotated_bits(*list)) {
    for (std::uint32_t value = 0; value < 65536; ++value)
      list->reading_of.push_back(std::rotr(static_cast<std::uint16_t>(value), 3));
    list->depth_scale_source = "SUN3D's own (millimetres, bits turned back by 3)";
    list->depth_scale_is_guess = false;
  }
  list->notes.emplace_back(by_name ? "the files' names are taken for their time in seconds"
                                   : "without stamps, the images are taken to be 1/30 s apart, a guess");
}

fs::path first_folder(const fs::path& parent, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (is_folder(parent / name)) return parent / name;
  return {};
}

}  // namespace

bool list_depth_images(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  Images here = images_of(folder);
  if (!here[Kind::depth].empty()) {
    list->format = here[Kind::color].empty() ? "depth images" : "depth and colour images in one folder";
    fill(options, here, here[Kind::depth], list);
    return true;
  }
  const fs::path depth_folder =
      first_folder(folder, {"depth", "depths", "Depth", "aligned_depth", "depth_images", "depth_raw"});
  if (!depth_folder.empty()) {
    Images depth = images_of(depth_folder);
    std::vector<fs::path> all = depth[Kind::depth];
    if (all.empty()) all = depth[Kind::color];
    const fs::path color_folder =
        first_folder(folder, {"color", "colour", "rgb", "image", "images", "Color", "RGB", "colors", "color_images"});
    const fs::path confidence_folder = first_folder(folder, {"confidence", "conf"});
    Images images;
    if (!color_folder.empty())
      for (const auto& [kind, paths] : images_of(color_folder))
        images[Kind::color].insert(images[Kind::color].end(), paths.begin(), paths.end());
    if (!confidence_folder.empty())
      for (const auto& [kind, paths] : images_of(confidence_folder))
        images[Kind::confidence].insert(images[Kind::confidence].end(), paths.begin(), paths.end());
    if (!all.empty()) {
      list->format = color_folder.empty() ? "depth images" : "depth and colour folders";
      fill(options, images, all, list);
      return true;
    }
  }
  if (here[Kind::color].empty()) return false;
  // Pictures alone: the reader of the first says what is wrong with them.
  list->format = "depth images";
  fill(options, {}, here[Kind::color], list);
  return true;
}

}  // namespace plumbline
