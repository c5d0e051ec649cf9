// What the layouts share: lists of stamped files, the pairs of depth and colour, and the order of numbered names.
#pragma once

#include <fmt/format.h>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/sequence_list.h"
#include "io/text_file.h"
#include "plumbline/time.h"

namespace plumbline {

/// File tests that call an unreadable path a missing one, where std::filesystem's would throw.
bool is_file(const std::filesystem::path& path);
bool is_folder(const std::filesystem::path& path);

/// What a folder holds, in no order. Throws Error if it cannot be listed; a missing folder holds nothing.
std::vector<std::filesystem::directory_entry> entries_of(const std::filesystem::path& folder);

struct StampedFile {
  Nanoseconds time = 0;
  std::string path;
};

/// Lines that are read one by one with `read_line(line)`; a half-written last one is noted and left out.
template <class ReadLine>
void read_lines(const TextFile& file, std::size_t fields_needed, std::vector<std::string>* notes,
                ReadLine&& read_line) {
  for (const TextLine& line : file.lines()) {
    const bool lacks_fields = split_fields(line.text, true).size() < fields_needed;
    if (line.is_last && lacks_fields) {
      notes->push_back(fmt::format("the last line of {} ({}) is half-written and was left out",
                                   std::filesystem::path(file.path()).filename().string(), line.number));
      continue;
    }
    read_line(line);
  }
}

/// The listed file: as it is written, with a Windows path's slashes, or, of a path of another machine, its final parts
/// in `folder`. As it is written if none of these is there.
std::string listed_file(const std::filesystem::path& folder, std::string_view name);

/// "seconds file", where the file's name may hold blanks. Stamps of more digits than seconds since 1970 have, or too
/// far apart for a camera's, are taken for milliseconds, microseconds or nanoseconds, which is warned of.
std::vector<StampedFile> read_list(const std::string& name, SequenceList* list);

/// Where most files have one and the same stamp, that says nothing: they are taken to be 1/30 s apart as they are
/// listed. Returns whether that was so.
bool spread_equal_stamps(std::vector<StampedFile>* files);

/// Stamps 0, 1, 2, … or 1, 2, 3, … count frames: they are taken to be 1/30 s apart. Returns whether that was so.
bool spread_counted_stamps(std::vector<StampedFile>* files);

/// Order of time, one file a stamp. `what` names the files in notes.
void sort_and_thin(const std::string& what, std::vector<StampedFile>* files, std::vector<std::string>* notes);

/// Depth in order of time, one image a stamp. Stamps that run backwards or are doubled are warned of: a clock was set,
/// or the list is made of two.
void order_depth(std::vector<StampedFile>* depth, std::vector<Warning>* warnings);

/// The existing depth images of `list_file`, ordered. Throws if there is none.
void keep_depth(const std::string& list_file, std::vector<StampedFile>* depth, SequenceList* list);
void keep_color(std::vector<StampedFile>* color, std::vector<std::string>* notes);

/// Depth with the colour nearest in time, one to one. Both by time.
std::vector<SequenceEntry> join(const std::vector<StampedFile>& depth, const std::vector<StampedFile>& color,
                                Nanoseconds max_difference, std::vector<std::string>* notes);

/// Of the user's options. Throws Error if it is none.
Nanoseconds max_difference(const SequenceOptions& options);

/// Order in which people count: runs of digits compare as numbers, so 2 comes before 10.
bool natural_less(const std::string& a, const std::string& b);

/// The camera and the unit of depth that the recording's own files tell; they replace the format's.
void take_recorded_camera(const SequenceOptions& options, SequenceList* list);

/// Poses that lie beside the listed frames: those of find_groundtruth(), else ScanNet's folder `pose` (pose/7.txt is of
/// the depth image numbered 7), SUN3D's newest extrinsics/*.txt, or Redwood's .log (its frame k is the k-th image).
void take_truth(SequenceList* list);

/// Notes files in the folder that look like an orientation sensor's, true poses or a video of colour where nothing of
/// the kind was found, with the option that names them.
void note_unused_files(SequenceList* list);

/// groundtruth.txt, or ICL-NUIM's traj3.gt.freiburg; else empty.
std::string find_groundtruth(const std::filesystem::path& folder);

}  // namespace plumbline
