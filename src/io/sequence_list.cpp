#include "io/sequence_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/images/image_file.h"
#include "io/known_formats.h"
#include "io/recording.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

std::string checked_folder(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw Error("there is no such folder", path, "check the path");
  if (!fs::is_directory(path, error)) throw Error("is a file, not the folder of a sequence", path, "give the folder");
  entries_of(path);
  return path;
}

/// The files of one frame are listed for any pictures; whether they are depth is told by the first that can be read.
bool has_depth(const SequenceList& list) {
  for (std::size_t i = 0; i < list.entries.size() && i < 3; ++i) try {
      return read_image_header(list.entries[i].depth).is_depth;
    } catch (const Error&) {  // its frame would tell
    }
  return false;
}

bool is_listed(const std::string& folder, const SequenceOptions& options, SequenceList* list) {
  list->folder = folder;
  for (const FolderFormat& format : folder_formats())
    if (format.list(options, list)) return true;
  return false;
}

/// Folders in `path` that are sequences, and files that are recordings.
std::vector<fs::path> recordings_in(const std::string& path, const SequenceOptions& options) {
  constexpr std::size_t kLooks = 50;
  std::vector<fs::path> found;
  std::size_t looks = 0;
  for (const fs::directory_entry& entry : entries_of(path)) {
    const std::string kind = lower(entry.path().filename().string());
    if (kind.starts_with("disparit")) continue;
    if (++looks > kLooks) break;
    try {
      SequenceList inside;
      const std::string name = entry.path().string();
      if (is_file(entry.path()) ? holds_recording(name) : is_listed(name, options, &inside) && has_depth(inside))
        found.push_back(entry.path());
    } catch (const Error&) {  // none that could be given
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

void refuse_unread(const std::string& path) {
  for (const char* folder : {".", "depth", "disparity"})
    for (const fs::directory_entry& entry : entries_of(fs::path(path) / folder)) {
      const std::string name = lower(entry.path().filename().string());
      if (name == "disparity" || name == "disparities")
        throw Error(
            "the folder holds disparity images, which are not depth", entry.path().lexically_normal().string(),
            "convert them to depth in millimetres: 1000 · focal length · baseline / disparity (pixels and metres)");
      if (const auto unread = known_unread_format(name))
        throw Error(fmt::format("the folder holds {}, which is not read", unread->what), entry.path().string(),
                    unread->how_to_convert);
    }
}

}  // namespace

SequenceList list_sequence(const std::string& path, const SequenceOptions& options) {
  SequenceList list;
  if (is_listed(checked_folder(path), options, &list)) {
    note_unused_files(&list);
    return list;
  }
  const std::vector<fs::path> inside = recordings_in(path, options);
  if (inside.size() == 1 && is_folder(inside.front())) {
    SequenceList only;
    is_listed(inside.front().string(), options, &only);
    only.notes.push_back("reading the only recording in the folder, " + inside.front().filename().string());
    note_unused_files(&only);
    return only;
  }
  if (!inside.empty()) {
    std::string names;
    for (const fs::path& one : inside) names += (names.empty() ? "" : ", ") + one.filename().string();
    throw Error(fmt::format("the folder holds {} recording{}: {}", inside.size(), inside.size() == 1 ? "" : "s", names),
                path, inside.size() == 1 ? "give the file" : "give one of them");
  }
  refuse_unread(path);
  std::string known;
  for (const FolderFormat& format : folder_formats())
    known += fmt::format("{}{} ({})", known.empty() ? "" : ", ", format.told_by, format.name);
  throw Error("the folder holds no sequence that is known", path, "give a folder with one of: " + known);
}

}  // namespace plumbline
