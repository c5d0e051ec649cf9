// The index of a Matroska file: its tracks, attachments, tags, and where its frames lie. Read through libmatroska.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/time.h"

namespace plumbline {

struct MatroskaFrame {
  Nanoseconds time = 0;      ///< from the start of the recording
  std::uint64_t offset = 0;  ///< in the file
  std::uint64_t size = 0;    ///< bytes
};

struct MatroskaTrack {
  std::uint64_t number = 0;
  std::string name, codec, codec_private;
  int width = 0, height = 0;          ///< of video; else 0
  std::vector<MatroskaFrame> frames;  ///< as they stand in the file
};

struct MatroskaFile {
  std::vector<MatroskaTrack> tracks;
  std::map<std::string, std::string> tags, attachments;  ///< by name
};

bool is_matroska(std::string_view first_bytes);

/// Reads everything but the frames' bytes. A file that ends early is read as far as it goes, which `notes` tells.
/// Throws Error if the file cannot be read, is no Matroska file, or is damaged before its first frame; and where this
/// program was built without libmatroska.
MatroskaFile index_matroska(const std::string& path, std::vector<std::string>* notes);

}  // namespace plumbline
