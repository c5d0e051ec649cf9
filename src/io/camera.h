// Which camera took a sequence.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/pinhole.h"
#include "plumbline/sequence.h"

namespace plumbline {

struct CameraChoice {
  Pinhole camera;
  Distortion distortion;
  std::string source;  ///< in words
  bool is_guess = false;
};

/// What is known about the sequence beside the user's options.
struct CameraClues {
  std::string folder;                            ///< that holds the frames
  std::string format_camera;                     ///< the name of the format's own camera, or empty
  bool format_is_guess = false;                  ///< the format's own camera is only its most common one
  int width = 0, height = 0;                     ///< of the images
  std::optional<CameraChoice> calibration = {};  ///< that came with the frames
  std::string refusal = {};                      ///< why there is none, "; …", or empty
};

/// Given intrinsics, else the named camera, else the calibration that came with the frames, else camera-intrinsics.txt
/// in the folder, else freiburg1/2/3 in the folder's name, else the format's own. Throws Error if there is none of
/// these, and if the camera cannot belong to the images.
CameraChoice choose_camera(const SequenceOptions& options, const CameraClues& clues);

/// The folder's names, even if the path is ".", ends in a slash or is a link: as given, then with links followed.
std::vector<std::string> folder_names(const std::string& path);

/// ASCII letters made small.
std::string lower(std::string_view text);

/// Whether `word` stands in `text` with no letter or digit beside it.
bool contains_word(std::string_view text, std::string_view word);

}  // namespace plumbline
