// The files of a sequence's frames, found in each of the layouts.
#pragma once

#include <string>
#include <vector>

#include "plumbline/sequence.h"
#include "plumbline/time.h"

namespace plumbline {

struct SequenceEntry {
  Nanoseconds time = 0;      ///< of the depth image
  std::string depth, color;  ///< paths; color may be empty
};

struct SequenceList {
  std::string folder;  ///< that holds the frames
  std::string format;
  std::vector<SequenceEntry> entries;  ///< by time, at least one, depth files exist
  std::string groundtruth;
  std::string format_camera;  ///< see CameraClues
  bool format_camera_is_guess = false;
  double depth_scale = 0;  ///< the format's own
  std::string depth_scale_source;
  bool saturated_is_invalid = false;      ///< a reading of 65535 means none
  bool stamps_are_frame_numbers = false;  ///< one second a frame says nothing about gaps
  std::vector<std::string> notes;
};

/// Throws Error if the folder is none of the layouts, or holds no frames.
SequenceList list_sequence(const std::string& path, const SequenceOptions& options);

}  // namespace plumbline
