// ROS 1 bags, format 2.0 (http://wiki.ros.org/Bags/Format/2.0): chunks of messages that belong to topics.
//
// librosbag-storage reads them too, and needs 62 packages for that; here the file is walked from its beginning to its
// end, so that bags without an index and those that were cut off are read as well.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "io/recording.h"
#include "plumbline/time.h"

namespace plumbline {

struct BagMessage {
  Nanoseconds time = 0;  ///< when it was recorded
  std::uint32_t chunk = 0, offset = 0, size = 0;
};

struct BagTopic {
  std::string name, type;            ///< "sensor_msgs/Image"
  std::vector<BagMessage> messages;  ///< as they stand in the file
};

/// A message's bytes, and what they lie in.
struct BagBytes {
  std::shared_ptr<const std::string> chunk;
  std::string_view bytes;
};

bool is_rosbag(std::string_view first_bytes);

class Bag {
 public:
  /// Walks through the file. A bag that ends early is read up to there, which `notes` tells. Throws Error if it cannot
  /// be read, is none, or is damaged; for encrypted and unknown chunks; and for chunks that this program was built
  /// without the library for.
  Bag(const std::string& path, std::vector<std::string>* notes);

  const std::vector<BagTopic>& topics() const { return topics_; }
  const std::string& path() const { return file_.path(); }

  /// From any thread. Throws Error if the chunk cannot be unpacked.
  BagBytes read(const BagMessage& message) const;

 private:
  struct Chunk {
    std::uint64_t offset = 0;
    std::uint32_t stored = 0, size = 0;  ///< bytes in the file, and unpacked
    std::string compression;
  };

  void add_record(std::uint64_t* at);
  void add_chunk(const Chunk& chunk);
  void add_connection(std::string_view header, std::string_view data);
  std::shared_ptr<const std::string> unpacked(std::uint32_t chunk) const;
  std::string unpack(const Chunk& chunk) const;
  [[noreturn]] void fail(const std::string& what) const;

  RandomAccessFile file_;
  std::vector<Chunk> chunks_;
  std::vector<BagTopic> topics_;
  std::vector<std::int64_t> topic_of_connection_;  ///< −1: none

  struct Cached {
    std::uint32_t chunk = 0;
    std::shared_ptr<const std::string> bytes;
  };
  mutable std::mutex mutex_;
  mutable std::vector<Cached> cache_;  // guarded by mutex_; the newest last
};

}  // namespace plumbline
