// The layouts of folders that are read: a new one is one new file here and one line in the table.
#pragma once

#include <span>

#include "io/sequence_list.h"

namespace plumbline {

/// Fills `list`, whose `folder` is set, if that folder is of this layout; else leaves it as it is and returns false.
/// Throws Error if it is of this layout but cannot be read.
using ListFolder = bool (*)(const SequenceOptions& options, SequenceList* list);

struct FolderFormat {
  const char* name;
  const char* told_by;  ///< for people: what in the folder tells the layout
  ListFolder list;
};

/// In the order in which they are tried: what says the most of itself comes first.
std::span<const FolderFormat> folder_formats();

bool list_stray_scanner(const SequenceOptions& options, SequenceList* list);
bool list_record3d(const SequenceOptions& options, SequenceList* list);
bool list_scanner_app(const SequenceOptions& options, SequenceList* list);
bool list_polycam(const SequenceOptions& options, SequenceList* list);
bool list_open_loris(const SequenceOptions& options, SequenceList* list);
bool list_replica(const SequenceOptions& options, SequenceList* list);
bool list_tum_or_icl(const SequenceOptions& options, SequenceList* list);
bool list_seven_scenes(const SequenceOptions& options, SequenceList* list);
bool list_nyu(const SequenceOptions& options, SequenceList* list);
bool list_depth_images(const SequenceOptions& options, SequenceList* list);

}  // namespace plumbline
