// Folders of images that need no list: depth/ beside color/ (Open3D's recorder, Redwood, ScanNet, SUN3D and many),
// depth and colour side by side in one folder, and depth alone. What is depth is told by the names, else by the files.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <set>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/images/image_file.h"
#include "io/seven_scenes.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

enum class Kind { depth, color, confidence, other };

constexpr std::array<std::string_view, 5> kCameraWords = {"cam", "camera", "kinect", "sensor", "device"};

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

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// A name with its digits left out, but for those that number a camera ("cam1_depth_0007.png"): what all files of one
/// kind share.
std::string pattern_of(const fs::path& path) {
  std::string pattern;
  for (const char c : path.filename().string()) {
    const std::string before = lower(pattern);
    const bool names_camera = std::any_of(kCameraWords.begin(), kCameraWords.end(),
                                          [&](std::string_view word) { return before.ends_with(word); });
    if (!is_digit(c) || names_camera) pattern += c;
  }
  return pattern;
}

using Images = std::map<Kind, std::vector<fs::path>>;

/// The final run of digits in a name.
std::string number_of(const fs::path& path) {
  const std::string stem = path.stem().string();
  const std::size_t end = stem.find_last_of("0123456789");
  if (end == std::string::npos) return stem;
  std::size_t begin = end;
  while (begin > 0 && is_digit(stem[begin - 1])) --begin;
  return stem.substr(begin, end + 1 - begin);
}

/// Of several kinds of depth images with the same numbers (two cameras, or raw and painted ones) the first that is
/// depth is taken; the others are told.
std::vector<fs::path> one_depth(std::vector<std::vector<fs::path>> groups, std::vector<std::string>* notes) {
  if (groups.empty()) return {};
  std::stable_partition(groups.begin(), groups.end(),
                        [](const auto& paths) { return kind_by_content(paths) == Kind::depth; });
  std::vector<fs::path> taken = groups.front();
  std::set<std::string> keys;
  for (const fs::path& path : taken) keys.insert(number_of(path));
  for (std::size_t i = 1; i < groups.size(); ++i) {
    const auto doubled = std::count_if(groups[i].begin(), groups[i].end(),
                                       [&](const fs::path& path) { return keys.contains(number_of(path)); });
    if (2 * static_cast<std::size_t>(doubled) < groups[i].size() && kind_by_content(groups[i]) == Kind::depth) {
      taken.insert(taken.end(), groups[i].begin(), groups[i].end());
      continue;
    }
    notes->push_back(fmt::format("{} and the like are not used, because {} is depth of the same number",
                                 groups[i].front().filename().string(), groups.front().front().filename().string()));
  }
  return taken;
}

/// The images of one folder by their kinds.
Images images_of(const fs::path& folder, std::vector<std::string>* notes) {
  std::map<std::string, std::vector<fs::path>> by_pattern;
  for (const fs::directory_entry& entry : entries_of(folder))
    if (is_image(entry.path()) && is_file(entry.path())) by_pattern[pattern_of(entry.path())].push_back(entry.path());
  Images images;
  std::vector<std::vector<fs::path>> depth;
  // With one kind alone, names such as frame000000.png say nothing.
  const bool mixed = std::any_of(by_pattern.begin(), by_pattern.end(), [](const auto& group) {
    return kind_by_name(fs::path(group.first).stem().string()) == Kind::depth;
  });
  for (auto& [pattern, paths] : by_pattern) {
    std::sort(paths.begin(), paths.end());
    const std::optional<Kind> named = kind_by_name(fs::path(pattern).stem().string());
    const bool trust = named && (mixed || *named != Kind::color);
    const Kind kind = trust ? *named : kind_by_content(paths);
    if (kind == Kind::depth)
      depth.push_back(paths);
    else
      images[kind].insert(images[kind].end(), paths.begin(), paths.end());
  }
  if (auto taken = one_depth(std::move(depth), notes); !taken.empty()) images[Kind::depth] = std::move(taken);
  return images;
}

/// The runs of digits in a name without leading zeros: what depth and colour of one frame share; the name without them.
std::string key_of(const fs::path& path) {
  std::string key;
  bool inside = false;
  for (const char c : path.stem().string()) {
    const bool digit = is_digit(c);
    if (digit && !inside) key += '-';
    inside = digit;
    if (digit && !(c == '0' && key.back() == '-')) key += c;
  }
  return key.empty() ? path.stem().string() : key;
}

/// A run of digits from `begin` on that is a time since 1970 (of the years 2001 to 2033): 13, 16 or 19 digits of ms, µs
/// or ns, or ten of seconds, one other character, and six or nine of the fraction.
std::optional<Nanoseconds> time_since_1970(std::string_view stem, std::size_t begin) {
  const auto run = [&](std::size_t from) {
    return std::min(stem.find_first_not_of("0123456789", from), stem.size()) - from;
  };
  const std::size_t digits = run(begin);
  if (stem[begin] != '1') return std::nullopt;
  const auto nanoseconds = [&](std::string text) {
    text.resize(19, '0');
    return parse_unsigned(text);
  };
  if (digits == 13 || digits == 16 || digits == 19) return nanoseconds(std::string(stem.substr(begin, digits)));
  if (digits != 10 || begin + digits + 1 >= stem.size()) return std::nullopt;
  const std::size_t fraction = run(begin + digits + 1);
  if (fraction != 6 && fraction != 9) return std::nullopt;
  return nanoseconds(std::string(stem.substr(begin, 10)) + std::string(stem.substr(begin + 11, fraction)));
}

/// The time that a name holds: since 1970, decimal seconds, or the microseconds after a count
/// (0000001-000000033369.png).
std::optional<Nanoseconds> stamp_in_name(const fs::path& path) {
  const std::string stem = path.stem().string();
  for (std::size_t i = 0; i < stem.size(); ++i)
    if (is_digit(stem[i]) && (i == 0 || !is_digit(stem[i - 1])))
      if (const auto time = time_since_1970(stem, i)) return time;
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

/// The first number, if the files are numbered without a gap.
std::optional<long long> run_of_numbers(const std::vector<fs::path>& files) {
  std::vector<long long> numbers;
  for (const fs::path& path : files) {
    const std::string key = key_of(path);
    const auto number = key == "-" ? 0 : parse_unsigned(std::string_view(key).substr(1));
    if (!key.starts_with('-') || !number) return std::nullopt;
    numbers.push_back(*number);
  }
  std::sort(numbers.begin(), numbers.end());
  const bool gapless = !numbers.empty() &&
                       numbers.back() - numbers.front() + 1 == static_cast<long long>(numbers.size()) &&
                       std::adjacent_find(numbers.begin(), numbers.end()) == numbers.end();
  return gapless ? std::optional(numbers.front()) : std::nullopt;
}

/// As many of each, numbered without a gap from another number on: video tools count from 1, recorders from 0.
bool pair_in_order(std::vector<fs::path> colors, SequenceList* list) {
  std::vector<fs::path> depths;
  for (const SequenceEntry& entry : list->entries) depths.emplace_back(entry.depth);
  const auto first_depth = run_of_numbers(depths), first_color = run_of_numbers(colors);
  if (colors.size() != depths.size() || !first_depth || !first_color) return false;
  std::sort(colors.begin(), colors.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  for (std::size_t i = 0; i < colors.size(); ++i) list->entries[i].color = colors[i].string();
  list->notes.push_back(
      fmt::format("depth images are numbered from {} and colour from {}: they are paired in order, a guess",
                  *first_depth, *first_color));
  return true;
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
  if (paired == static_cast<int>(list->entries.size()) || pair_in_order(files, list)) return;
  list->notes.push_back(fmt::format("{} of {} depth images have no colour image of the same number",
                                    static_cast<int>(list->entries.size()) - paired, list->entries.size()));
  if (10 * files.size() < 9 * list->entries.size() && run_of_numbers(files) && paired == static_cast<int>(files.size()))
    list->warnings.push_back(
        {fmt::format(
             "there are {} colour images, numbered without a gap, for {} of depth: those of one number need not "
             "be of one moment",
             files.size(), list->entries.size()),
         "Check that both have the same rate, or name the images by their times in seconds."});
}

/// Whether a file is named as SUN3D's are: a count of seven digits and microseconds of twelve.
bool is_named_as_sun3d(const fs::path& path) {
  const std::string stem = path.stem().string();
  return stem.size() == 20 && stem[7] == '-' && parse_unsigned(stem.substr(0, 7)) && parse_unsigned(stem.substr(8));
}

/// How much neighbours in a row differ, a pair of readings.
double roughness(const DepthImage& depth, bool swapped) {
  double sum = 0, pairs = 0;
  for (std::size_t i = 1; i < depth.pixels.size(); ++i) {
    std::uint16_t a = depth.pixels[i - 1], b = depth.pixels[i];
    if (a == 0 || b == 0) continue;
    if (swapped) a = std::rotr(a, 8), b = std::rotr(b, 8);
    sum += std::abs(a - b);
    ++pairs;
  }
  return pairs > 0 ? sum / pairs : 0;
}

/// Whether the two bytes of each reading stand in the other order: surfaces are smooth only then.
bool has_swapped_bytes(const SequenceList& list) {
  for (const std::size_t i : {std::size_t{0}, list.entries.size() / 2, list.entries.size() - 1}) try {
      const std::string& path = list.entries[i].depth;
      if (read_image_header(path).is_float) return false;
      const DepthImage depth = read_depth_image(path);
      const double as_it_is = roughness(depth, false);
      if (as_it_is > 0) return as_it_is > 5 * roughness(depth, true) && as_it_is > 256;
    } catch (const Error&) {  // its frame will tell
    }
  return false;
}

/// SUN3D turns its readings' bits by three places: all of a hand's reach are multiples of eight.
bool has_rotated_bits(const SequenceList& list) {
  const bool sun3d = is_folder(fs::path(list.folder) / "extrinsics") || is_named_as_sun3d(list.entries.front().depth);
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
void describe_by_files(const SequenceOptions& options, SequenceList* list) {
  list->depth_scale = 1000;
  list->depth_scale_source = "millimetres";
  list->depth_scale_is_guess = true;
  take_recorded_camera(options, list);
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
  describe_by_files(options, list);
  const bool swapped = has_swapped_bytes(*list), rotated = !swapped && has_rotated_bits(*list);
  if (swapped || rotated)
    for (std::uint32_t value = 0; value < 65536; ++value)
      list->reading_of.push_back(std::rotr(static_cast<std::uint16_t>(value), swapped ? 8 : 3));
  if (swapped)
    list->warnings.push_back(
        {"the bytes of the depth's readings stand in the wrong order and are swapped, a guess: as "
         "they are, neighbours differ by many times as much",
         "Write 16-bit images in their format's own order of bytes."});
  if (rotated) {
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

/// The images of the first of the folders named for depth whose images are depth; of the first at all if none's are.
std::vector<fs::path> images_of_depth_folder(const fs::path& parent, std::vector<std::string>* notes) {
  std::vector<fs::path> first;
  std::string passed;
  for (const char* name : {"depth", "depths", "Depth", "aligned_depth", "depth_aligned", "depth_images", "depth_raw",
                           "raw_depth", "depth_png", "depth_16bit"}) {
    if (!is_folder(parent / name)) continue;
    Images images = images_of(parent / name, notes);
    std::vector<fs::path> all = images[Kind::depth];
    if (all.empty()) all = images[Kind::color];
    if (all.empty()) continue;
    if (kind_by_content(all) == Kind::depth) {
      if (!passed.empty())
        notes->push_back(fmt::format("{}/ is not used, because its images are not depth; {}/ is", passed, name));
      return all;
    }
    if (first.empty()) first = all, passed = name;
  }
  return first;
}

}  // namespace

bool list_depth_images(const SequenceOptions& options, SequenceList* list) {
  const fs::path folder = list->folder;
  Images here = images_of(folder, &list->notes);
  if (!here[Kind::depth].empty()) {
    list->format = here[Kind::color].empty() ? "depth images" : "depth and colour images in one folder";
    fill(options, here, here[Kind::depth], list);
    return true;
  }
  const std::vector<fs::path> all = images_of_depth_folder(folder, &list->notes);
  if (!all.empty()) {
    const fs::path color_folder =
        first_folder(folder, {"color", "colour", "rgb", "image", "images", "Color", "RGB", "colors", "color_images"});
    const fs::path confidence_folder = first_folder(folder, {"confidence", "conf"});
    Images images;
    if (!color_folder.empty())
      for (const auto& [kind, paths] : images_of(color_folder, &list->notes))
        images[Kind::color].insert(images[Kind::color].end(), paths.begin(), paths.end());
    if (!confidence_folder.empty())
      for (const auto& [kind, paths] : images_of(confidence_folder, &list->notes))
        images[Kind::confidence].insert(images[Kind::confidence].end(), paths.begin(), paths.end());
    list->format = color_folder.empty() ? "depth images" : "depth and colour folders";
    fill(options, images, all, list);
    return true;
  }
  if (here[Kind::color].empty()) return false;
  // Pictures alone: the reader of the first says what is wrong with them.
  list->format = "depth images";
  fill(options, {}, here[Kind::color], list);
  return true;
}

}  // namespace plumbline
