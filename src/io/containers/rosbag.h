// ROS 1 bags, format 2.0 (http://wiki.ros.org/Bags/Format/2.0): chunks of messages that belong to topics.
//
// librosbag-storage reads them too, and needs 62 packages for that; here the file is walked from its beginning to its
// end, so that bags without an index and those that were cut off are read as well.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/containers/message_store.h"
#include "io/recording.h"

namespace plumbline {

bool is_rosbag(std::string_view first_bytes);

class Bag : public MessageStore {
 public:
  /// Walks through the file. A bag that ends early is read up to there, which `notes` tells. Throws Error if it cannot
  /// be read, is none, or is damaged; and for encrypted and unknown chunks.
  Bag(const std::string& path, std::vector<std::string>* notes);

  MessageBytes read(const StoredMessage& message) const override;

 private:
  struct Chunk {
    std::uint64_t offset = 0;
    std::uint32_t stored = 0, size = 0;  ///< bytes in the file, and unpacked
    std::string compression;
  };

  void add_record(std::uint64_t* at);
  void add_chunk(const Chunk& chunk);
  void add_connection(std::string_view header, std::string_view data);
  std::string unpack_chunk(const Chunk& chunk) const;
  [[noreturn]] void fail(const std::string& what) const;

  RandomAccessFile file_;
  std::vector<Chunk> chunks_;
  std::vector<std::int64_t> topic_of_connection_;  ///< −1: none
  mutable ChunkCache cache_;
};

}  // namespace plumbline
