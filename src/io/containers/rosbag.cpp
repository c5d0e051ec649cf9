#include "io/containers/rosbag.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "io/containers/unpack.h"
#include "io/stamped_lines.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr std::string_view kBagMagic = "#ROSBAG V2.0\n";
constexpr std::uint32_t kMaxBagHeader = 1 << 20, kMaxBagChunk = 1u << 28;
constexpr std::uint32_t kMaxConnections = 1 << 16;
constexpr const char* kRosbagAdvice = "copy the bag again, or repair it with `rosbag reindex`";
enum BagOp : unsigned char { kBagMessage = 2, kBagChunk = 5, kBagConnection = 7 };

std::uint32_t u32(std::string_view bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data(), 4);
  return value;
}

/// A record within a text of records; `rest` goes on behind it. False if the text ends before the record does.
struct Record {
  std::string_view header, data;
};
bool take_record(std::string_view* rest, Record* record) {
  for (std::string_view* part : {&record->header, &record->data}) {
    if (rest->size() < 4 || rest->size() - 4 < u32(*rest)) return false;
    *part = rest->substr(4, u32(*rest));
    rest->remove_prefix(4 + part->size());
  }
  return true;
}

/// The value of a field "name=value" of a header.
std::optional<std::string_view> field(std::string_view header, std::string_view name) {
  while (header.size() >= 4 && header.size() - 4 >= u32(header)) {
    const std::string_view text = header.substr(4, u32(header));
    if (text.size() > name.size() && text.starts_with(name) && text[name.size()] == '=')
      return text.substr(name.size() + 1);
    header.remove_prefix(4 + text.size());
  }
  return std::nullopt;
}

std::optional<std::uint32_t> number_field(std::string_view header, std::string_view name) {
  const auto value = field(header, name);
  return value && value->size() >= 4 ? std::optional<std::uint32_t>(u32(*value)) : std::nullopt;
}

int op_of(std::string_view header) {
  const auto op = field(header, "op");
  return op && op->size() == 1 ? static_cast<unsigned char>(op->front()) : -1;
}

}  // namespace

bool is_rosbag(std::string_view bytes) { return bytes.starts_with(kBagMagic); }

void Bag::fail(const std::string& what) const { throw Error(what, path(), kRosbagAdvice); }

Bag::Bag(const std::string& path, std::vector<std::string>* notes) : MessageStore(path, "ROS bag"), file_(path) {
  if (!is_rosbag(file_.read(0, std::min<std::uint64_t>(file_.size(), kBagMagic.size()))))
    fail("is no bag of format 2.0");
  std::uint64_t at = kBagMagic.size();
  try {
    while (at < file_.size()) add_record(&at);
  } catch (const Error& error) {
    if (!has_messages()) throw;
    add_note(notes, "the bag ends early or is damaged; it is read up to there");
  }
}

/// One at the top of the file, of which chunks, messages and connections are looked at.
void Bag::add_record(std::uint64_t* at) {
  const auto length = [&](std::uint64_t where, std::uint32_t limit) {
    const std::uint32_t size = u32(file_.read(where, 4));
    if (size > limit || size > file_.size() - where - 4) fail("ends early or is damaged");
    return size;
  };
  const std::uint32_t header_size = length(*at, kMaxBagHeader);
  const std::string header = file_.read(*at + 4, header_size);
  const std::uint64_t data_at = *at + 4 + header_size;
  const std::uint32_t data_size = length(data_at, ~std::uint32_t{0});
  *at = data_at + 4 + data_size;
  const int op = op_of(header);
  if (op == kBagConnection && data_size <= kMaxBagHeader) add_connection(header, file_.read(data_at + 4, data_size));
  if (op == kBagChunk) {
    const auto compression = field(header, "compression");
    const auto size = number_field(header, "size");
    if (!compression || !size || *size > kMaxBagChunk) fail("is damaged: a chunk says nothing of its size");
    add_chunk({data_at + 4, data_size, *size, std::string(*compression)});
  }
  if (op == -1) fail("is damaged");
  if (field(header, "encryptor").value_or("").size() > 0) fail("is encrypted");
}

void Bag::add_connection(std::string_view header, std::string_view data) {
  const auto connection = number_field(header, "conn");
  const auto topic = field(header, "topic"), type = field(data, "type");
  if (!connection || *connection >= kMaxConnections || !topic || !type) fail("is damaged: a topic without a name");
  if (topic_of_connection_.size() <= *connection) topic_of_connection_.resize(*connection + 1, -1);
  if (topic_of_connection_[*connection] >= 0) return;
  topic_of_connection_[*connection] = static_cast<std::int64_t>(add_topic(*topic, *type, Wire::ros1));
}

void Bag::add_chunk(const Chunk& chunk) {
  const auto index = static_cast<std::uint32_t>(chunks_.size());
  const std::string bytes = unpack_chunk(chunk);
  chunks_.push_back(chunk);
  std::string_view rest = bytes;
  for (Record record; take_record(&rest, &record);) {
    const int op = op_of(record.header);
    if (op == kBagConnection) add_connection(record.header, record.data);
    if (op != kBagMessage) continue;
    const auto connection = number_field(record.header, "conn");
    const auto time = field(record.header, "time");
    if (!connection || *connection >= topic_of_connection_.size() || topic_of_connection_[*connection] < 0 || !time ||
        time->size() != 8)
      fail("is damaged: a message of no topic");
    const Nanoseconds stamp = u32(*time) * kNanosecondsPerSecond + u32(time->substr(4));
    topics_[static_cast<std::size_t>(topic_of_connection_[*connection])].messages.push_back(
        {stamp, 0, index, static_cast<std::uint64_t>(record.data.data() - bytes.data()), record.data.size()});
  }
  if (!rest.empty()) fail("is damaged: a chunk ends within a message");
}

std::string Bag::unpack_chunk(const Chunk& chunk) const {
  const auto packing = packing_named(chunk.compression);
  if (!packing) fail(fmt::format("has a chunk packed with '{}', which is not known", chunk.compression));
  auto bytes = unpack(*packing, file_.read(chunk.offset, chunk.stored), chunk.size);
  if (!bytes) fail("is damaged: a chunk cannot be unpacked");
  return std::move(*bytes);
}

MessageBytes Bag::read(const StoredMessage& message) const {
  MessageBytes result{cache_.get(message.chunk, [&] { return unpack_chunk(chunks_.at(message.chunk)); }), {}};
  if (message.offset > result.owner->size() || message.size > result.owner->size() - message.offset)
    fail("has changed while it was read");
  result.bytes = std::string_view(*result.owner).substr(message.offset, message.size);
  return result;
}

}  // namespace plumbline
