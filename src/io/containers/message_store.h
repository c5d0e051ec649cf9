// Messages by topic, whatever they lie in: what ROS 1 bags, SQLite files of ROS 2 and MCAP files have in common.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/time.h"

namespace plumbline {

/// How a topic's messages are serialised: as ROS 1 does, or in OMG's Common Data Representation, as ROS 2 does.
enum class Wire { ros1, cdr };

struct StoredMessage {
  Nanoseconds time = 0;                ///< when it was recorded
  std::uint32_t file = 0, chunk = 0;   ///< of a recording in several files; of a file in chunks
  std::uint64_t offset = 0, size = 0;  ///< within the chunk or file; `offset` is the row of a table
};

struct MessageTopic {
  std::string name, type;  ///< "sensor_msgs/Image", in ROS 2 as well, which has "sensor_msgs/msg/Image"
  Wire wire = Wire::ros1;
  std::vector<StoredMessage> messages;  ///< as they stand in the file
};

/// A message's bytes, and what they lie in.
struct MessageBytes {
  std::shared_ptr<const std::string> owner;
  std::string_view bytes;
};

class MessageStore {
 public:
  virtual ~MessageStore() = default;
  MessageStore(const MessageStore&) = delete;
  MessageStore& operator=(const MessageStore&) = delete;

  const std::vector<MessageTopic>& topics() const { return topics_; }
  const std::string& path() const { return path_; }  ///< of the file or folder
  const std::string& format() const { return format_; }

  /// All of a message, from any thread. Throws Error if it cannot be read or unpacked.
  virtual MessageBytes read(const StoredMessage& message) const = 0;
  /// Its beginning, at least `size` bytes of it or all; where that is cheaper, no more.
  virtual MessageBytes read_beginning(const StoredMessage& message, std::size_t size) const;

 protected:
  MessageStore(std::string path, std::string format) : path_(std::move(path)), format_(std::move(format)) {}

  /// The index of the topic, which is added if it is new.
  std::size_t add_topic(std::string_view name, std::string_view type, Wire wire);
  bool has_messages() const;

  std::vector<MessageTopic> topics_;

 private:
  std::string path_, format_;
};

/// The unpacked chunks that were used latest. All members may be called from several threads at once.
class ChunkCache {
 public:
  /// The chunk's bytes, from `unpack` if they are not there.
  std::shared_ptr<const std::string> get(std::uint32_t chunk, const std::function<std::string()>& unpack);

 private:
  struct Cached {
    std::uint32_t chunk = 0;
    std::shared_ptr<const std::string> bytes;
  };
  std::mutex mutex_;
  std::vector<Cached> cache_;  // guarded by mutex_; the newest last
};

/// Opens what lies at `path`: a ROS 1 bag, a file of ROS 2 (.db3, .mcap), or a folder of those with metadata.yaml.
/// Throws Error if it cannot be read.
std::unique_ptr<MessageStore> open_message_store(const std::string& path, std::vector<std::string>* notes);

/// Whether a file begins as a SQLite database does; whether as an MCAP file does.
bool is_sqlite(std::string_view first_bytes);
bool is_mcap(std::string_view first_bytes);

/// ROS 2's SQLite files, of all versions of rosbag2. Throws Error for other databases.
std::unique_ptr<MessageStore> open_sqlite_store(const std::string& path);
/// MCAP (https://mcap.dev/spec), chunked or not, read from its beginning to its end, so that a file without its index
/// is read as well; what of it is cut off, `notes` tell.
std::unique_ptr<MessageStore> open_mcap_store(const std::string& path, std::vector<std::string>* notes);
/// Several files of one recording, in that order.
std::unique_ptr<MessageStore> join_stores(const std::string& path, std::vector<std::unique_ptr<MessageStore>> parts);

/// Whether the folder is a recording of ROS 2: it has a metadata.yaml of rosbag2, or .db3 or .mcap files and nothing
/// else that could be frames.
bool is_ros2_folder(const std::string& path);

}  // namespace plumbline
