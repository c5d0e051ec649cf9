#include "io/containers/message_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>

#include "io/containers/rosbag.h"
#include "io/recording.h"
#include "io/stamped_lines.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCachedChunks = 4;

/// "sensor_msgs/msg/Image" as ROS 1 calls it.
std::string short_type(std::string_view type) {
  std::string name(type);
  if (const std::size_t at = name.find("/msg/"); at != std::string::npos) name.erase(at, 4);
  return name;
}

class JoinedStore : public MessageStore {
 public:
  JoinedStore(const std::string& path, std::vector<std::unique_ptr<MessageStore>> parts)
      : MessageStore(path, parts.front()->format()), parts_(std::move(parts)) {
    for (std::size_t i = 0; i < parts_.size(); ++i)
      for (const MessageTopic& topic : parts_[i]->topics()) {
        const std::size_t index = add_topic(topic.name, topic.type, topic.wire);
        for (StoredMessage message : topic.messages) {
          message.file = static_cast<std::uint32_t>(i);
          topics_[index].messages.push_back(message);
        }
      }
  }

  MessageBytes read(const StoredMessage& message) const override { return parts_.at(message.file)->read(message); }
  MessageBytes read_beginning(const StoredMessage& message, std::size_t size) const override {
    return parts_.at(message.file)->read_beginning(message, size);
  }

 private:
  std::vector<std::unique_ptr<MessageStore>> parts_;
};

std::string beginning_of(const std::string& path) {
  const RandomAccessFile file(path);
  return file.read(0, std::min<std::uint64_t>(file.size(), 16));
}

bool is_storage(const fs::path& file) { return file.extension() == ".db3" || file.extension() == ".mcap"; }

/// The files that metadata.yaml lists, in its order: the entries of "relative_file_paths".
std::vector<std::string> listed_files(const fs::path& metadata) {
  const TextFile file(metadata.string());
  std::vector<std::string> names;
  bool inside = false;
  for (const TextLine& line : file.lines()) {
    std::string_view text = trim(line.text);
    if (inside && !text.starts_with('-')) break;
    if (inside) {
      text = trim(text.substr(1));
      while (!text.empty() && (text.front() == '"' || text.front() == '\'')) text.remove_prefix(1);
      while (!text.empty() && (text.back() == '"' || text.back() == '\'')) text.remove_suffix(1);
      names.emplace_back(text);
    }
    inside = inside || text.starts_with("relative_file_paths:");
  }
  return names;
}

/// The storage files in the folder, by name.
std::vector<std::string> found_files(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (is_storage(it->path())) names.push_back(it->path().filename().string());
  std::sort(names.begin(), names.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;  // bag_9 before bag_10
  });
  return names;
}

/// The files of a recording that are there; the others are told.
std::vector<std::string> files_of(const fs::path& folder, std::vector<std::string>* notes) {
  std::error_code error;
  std::vector<std::string> names;
  if (fs::exists(folder / "metadata.yaml", error)) names = listed_files(folder / "metadata.yaml");
  if (names.empty()) {
    names = found_files(folder);
    if (!names.empty())
      add_note(notes, "metadata.yaml lists no files or is missing; the folder's own are read by name");
  }
  std::vector<std::string> there;
  for (const std::string& name : names) {
    // Early versions of rosbag2 wrote the folder's name before the file's.
    const fs::path file = fs::exists(folder / name, error) ? folder / name : folder / fs::path(name).filename();
    if (fs::exists(file, error))
      there.push_back(file.string());
    else
      add_note(notes, fmt::format("{}, which metadata.yaml lists, is missing", name));
  }
  if (there.empty())
    throw Error("has none of the files of a ROS 2 recording", folder.string(), "copy all of the folder");
  return there;
}

std::unique_ptr<MessageStore> open_folder(const std::string& path, std::vector<std::string>* notes) {
  std::vector<std::unique_ptr<MessageStore>> parts;
  for (const std::string& file : files_of(path, notes)) {
    if (file.ends_with(".zstd"))
      throw Error("is a file of a ROS 2 recording that is packed as a whole", file,
                  "unpack it with `zstd -d`, and give the .db3 or .mcap file");
    parts.push_back(open_message_store(file, notes));
  }
  return join_stores(path, std::move(parts));
}

}  // namespace

MessageBytes MessageStore::read_beginning(const StoredMessage& message, std::size_t) const { return read(message); }

std::size_t MessageStore::add_topic(std::string_view name, std::string_view type, Wire wire) {
  const std::string short_name = short_type(type);
  const auto known = std::find_if(topics_.begin(), topics_.end(),
                                  [&](const MessageTopic& t) { return t.name == name && t.type == short_name; });
  const auto index = static_cast<std::size_t>(known - topics_.begin());
  if (known == topics_.end()) topics_.push_back({std::string(name), short_name, wire, {}});
  return index;
}

bool MessageStore::has_messages() const {
  return std::any_of(topics_.begin(), topics_.end(), [](const MessageTopic& t) { return !t.messages.empty(); });
}

std::shared_ptr<const std::string> ChunkCache::get(std::uint32_t chunk, const std::function<std::string()>& unpack) {
  {
    const std::scoped_lock lock(mutex_);
    for (const Cached& cached : cache_)
      if (cached.chunk == chunk) return cached.bytes;
  }
  auto bytes = std::make_shared<const std::string>(unpack());
  const std::scoped_lock lock(mutex_);
  if (cache_.size() >= kCachedChunks) cache_.erase(cache_.begin());
  cache_.push_back({chunk, bytes});
  return bytes;
}

std::unique_ptr<MessageStore> open_message_store(const std::string& path, std::vector<std::string>* notes) {
  if (std::error_code error; fs::is_directory(path, error)) return open_folder(path, notes);
  const std::string first = beginning_of(path);
  if (is_rosbag(first)) return std::make_unique<Bag>(path, notes);
  if (is_mcap(first)) return open_mcap_store(path, notes);
  if (is_sqlite(first)) return open_sqlite_store(path);
  throw Error("is no recording of ROS", path, "give a .bag, .db3 or .mcap file");
}

std::unique_ptr<MessageStore> join_stores(const std::string& path, std::vector<std::unique_ptr<MessageStore>> parts) {
  if (parts.size() == 1) return std::move(parts.front());
  return std::make_unique<JoinedStore>(path, std::move(parts));
}

bool is_ros2_folder(const std::string& path) {
  std::error_code error;
  const fs::path metadata = fs::path(path) / "metadata.yaml";
  if (fs::is_regular_file(metadata, error))
    return read_file(metadata.string()).find("rosbag2_bagfile_information") != std::string::npos;
  if (found_files(path).empty()) return false;
  // A folder of frames may hold the bag that they came from.
  fs::directory_iterator it(path, error);
  return !error && std::all_of(it, fs::directory_iterator(), [](const fs::directory_entry& e) {
    return !e.is_directory() && e.path().extension() != ".txt" && e.path().extension() != ".png";
  });
}

}  // namespace plumbline
