// MCAP files (https://mcap.dev/spec): records of one byte (what it is), eight bytes (its length) and its content.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "io/containers/message_store.h"
#include "io/containers/unpack.h"
#include "io/recording.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t kMaxMcapChunk = 1u << 28;
constexpr std::size_t kRecordHead = 9;
constexpr std::size_t kMessageHead = 2 + 4 + 8 + 8;  // channel, number, two stamps
constexpr std::size_t kChunkHead = 8 + 8 + 8 + 4;    // two stamps, size, checksum
constexpr std::uint32_t kNoChunk = ~std::uint32_t{0};
constexpr const char* kMcapAdvice = "copy the file again, or repair it with `mcap recover`";
enum McapOp : unsigned char { kFooter = 2, kSchema = 3, kChannel = 4, kMessage = 5, kChunk = 6, kDataEnd = 15 };

/// Values of a record, one after the other.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  T take() {
    T value{};
    std::memcpy(&value, take_bytes(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::string_view take_bytes(std::size_t size) {
    if (size > rest_.size()) throw Error("is damaged: a record is too short", "", kMcapAdvice);
    const std::string_view bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return bytes;
  }
  std::string_view take_string() { return take_bytes(take<std::uint32_t>()); }

 private:
  std::string_view rest_;
};

class McapStore : public MessageStore {
 public:
  McapStore(const std::string& path, std::vector<std::string>* notes) : MessageStore(path, "MCAP"), file_(path) {
    try {
      walk();
    } catch (const Error& error) {
      if (!has_messages()) throw;
      add_note(notes, "the file ends early or is damaged; it is read up to there");
    }
    if (unknown_encodings_ > 0)
      add_note(notes, fmt::format("{} topics are neither in ROS 1's nor in ROS 2's encoding and are not read",
                                  unknown_encodings_));
  }

  MessageBytes read(const StoredMessage& message) const override {
    MessageBytes result;
    if (message.chunk == kNoChunk) {
      result.owner = std::make_shared<const std::string>(file_.read(message.offset, message.size));
      result.bytes = *result.owner;
    } else {
      result.owner = cache_.get(message.chunk, [&] { return unpack_chunk(chunks_.at(message.chunk)); });
      if (message.offset > result.owner->size() || message.size > result.owner->size() - message.offset)
        fail("has changed while it was read");
      result.bytes = std::string_view(*result.owner).substr(message.offset, message.size);
    }
    if (!is_zstd(result.bytes)) return result;
    auto bytes = unpack_zstd_frame(result.bytes, kMaxMcapChunk);
    if (!bytes) fail("a packed message is damaged");
    result.owner = std::make_shared<const std::string>(std::move(*bytes));
    result.bytes = *result.owner;
    return result;
  }

 private:
  struct Chunk {
    std::uint64_t offset = 0, stored = 0, size = 0;
    Packing packing = Packing::none;
  };

  [[noreturn]] void fail(const std::string& what) const { throw Error(what, path(), kMcapAdvice); }

  void walk() {
    std::uint64_t at = kMcapMagic.size();
    while (at < file_.size()) {
      const std::string head = file_.read(at, kRecordHead);
      const auto op = static_cast<unsigned char>(head.front());
      std::uint64_t length = 0;
      std::memcpy(&length, head.data() + 1, 8);
      at += kRecordHead;
      if (length > file_.size() - at) fail("ends early");
      if (op == kFooter || op == kDataEnd) return;
      add_record(op, at, length);
      at += length;
    }
  }

  void add_record(unsigned char op, std::uint64_t at, std::uint64_t length) {
    if (op == kChunk) return add_chunk(at, length);
    if (op == kMessage && length >= kMessageHead)
      return add_message(file_.read(at, kMessageHead), kNoChunk, at + kMessageHead, length - kMessageHead);
    if ((op == kSchema || op == kChannel) && length <= kMaxMcapChunk) add_definition(op, file_.read(at, length));
  }

  void add_definition(unsigned char op, std::string_view content) try {
    Fields fields(content);
    const auto id = fields.take<std::uint16_t>();
    if (op == kSchema) {
      schemas_[id] = std::string(fields.take_string());
      return;
    }
    if (channels_.contains(id)) return;
    const std::string type = schemas_[fields.take<std::uint16_t>()];
    const std::string_view topic = fields.take_string(), encoding = fields.take_string();
    const bool known = encoding == "cdr" || encoding == "ros1";
    if (!known) ++unknown_encodings_;
    channels_[id] = std::nullopt;
    if (known) channels_[id] = add_topic(topic, type, encoding == "cdr" ? Wire::cdr : Wire::ros1);
  } catch (const Error&) {
    fail("is damaged: a topic's record is too short");
  }

  void add_message(std::string_view head, std::uint32_t chunk, std::uint64_t offset, std::uint64_t size) {
    Fields fields(head);
    const auto channel = channels_.find(fields.take<std::uint16_t>());
    if (channel == channels_.end()) fail("is damaged: a message of no topic");
    if (!channel->second) return;
    fields.take<std::uint32_t>();
    const auto time = static_cast<Nanoseconds>(fields.take<std::uint64_t>());
    topics_[*channel->second].messages.push_back({time, 0, chunk, offset, size});
  }

  void add_chunk(std::uint64_t at, std::uint64_t length) {
    const std::uint64_t head_size = std::min<std::uint64_t>(length, kChunkHead + 4 + 64 + 8);
    const std::string head = file_.read(at, head_size);
    Chunk chunk;
    try {
      Fields fields(head);
      fields.take_bytes(16);
      chunk.size = fields.take<std::uint64_t>();
      fields.take<std::uint32_t>();
      const std::string_view name = fields.take_string();
      const auto packing = packing_named(name);
      if (!packing) fail(fmt::format("has a chunk packed with '{}', which is not known", name));
      chunk.packing = *packing;
      chunk.stored = fields.take<std::uint64_t>();
      chunk.offset = at + kChunkHead + 4 + name.size() + 8;
    } catch (const Error& error) {
      if (error.where().empty()) fail("is damaged: a chunk's record is too short");
      throw;
    }
    if (chunk.size > kMaxMcapChunk || chunk.offset > at + length || chunk.stored > at + length - chunk.offset)
      fail("is damaged: a chunk's size cannot be");
    chunks_.push_back(chunk);
    add_messages_of(static_cast<std::uint32_t>(chunks_.size() - 1));
  }

  void add_messages_of(std::uint32_t index) {
    const auto bytes = cache_.get(index, [&] { return unpack_chunk(chunks_[index]); });
    for (std::size_t at = 0; at < bytes->size();) {
      if (bytes->size() - at < kRecordHead) fail("is damaged: a chunk ends within a record");
      const auto op = static_cast<unsigned char>((*bytes)[at]);
      std::uint64_t length = 0;
      std::memcpy(&length, bytes->data() + at + 1, 8);
      at += kRecordHead;
      if (length > bytes->size() - at) fail("is damaged: a chunk ends within a record");
      const std::string_view content = std::string_view(*bytes).substr(at, length);
      if (op == kMessage && length >= kMessageHead)
        add_message(content.substr(0, kMessageHead), index, at + kMessageHead, length - kMessageHead);
      if (op == kSchema || op == kChannel) add_definition(op, content);
      at += length;
    }
  }

  std::string unpack_chunk(const Chunk& chunk) const {
    auto bytes = unpack(chunk.packing, file_.read(chunk.offset, chunk.stored), chunk.size);
    if (!bytes) fail("is damaged: a chunk cannot be unpacked");
    return std::move(*bytes);
  }

  RandomAccessFile file_;
  std::vector<Chunk> chunks_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, std::optional<std::size_t>> channels_;  ///< the topic; none in an unknown encoding
  int unknown_encodings_ = 0;
  mutable ChunkCache cache_;
};

}  // namespace

bool is_mcap(std::string_view bytes) { return bytes.starts_with(kMcapMagic); }

std::unique_ptr<MessageStore> open_mcap_store(const std::string& path, std::vector<std::string>* notes) {
  return std::make_unique<McapStore>(path, notes);
}

}  // namespace plumbline
