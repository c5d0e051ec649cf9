#include "io/sequence_list.h"

#include <fmt/format.h>

#include <filesystem>

#include "io/formats/formats.h"
#include "io/formats/frame_files.h"
#include "io/known_formats.h"
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

}  // namespace

SequenceList list_sequence(const std::string& path, const SequenceOptions& options) {
  SequenceList list;
  list.folder = checked_folder(path);
  for (const FolderFormat& format : folder_formats())
    if (format.list(options, &list)) return list;
  for (const fs::directory_entry& entry : entries_of(path))
    if (const auto unread = known_unread_format(entry.path().string()))
      throw Error(fmt::format("the folder holds {}, which is not read", unread->what), entry.path().string(),
                  unread->how_to_convert);
  std::string known;
  for (const FolderFormat& format : folder_formats())
    known += fmt::format("{}{} ({})", known.empty() ? "" : ", ", format.told_by, format.name);
  throw Error("the folder holds no sequence that is known", path, "give a folder with one of: " + known);
}

}  // namespace plumbline
