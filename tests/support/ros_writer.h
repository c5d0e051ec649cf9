// Recordings of ROS as tests need them: messages in both encodings, and the files that hold them.
#pragma once

#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include <array>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/time.h"
#include "support/temp_folder.h"

namespace plumbline::test {

struct Encoding {
  bool cdr = true, big_endian = false;
};

/// Values one after the other, in ROS 1's or ROS 2's encoding.
class RosMessage {
 public:
  explicit RosMessage(Encoding encoding) : encoding_(encoding) {
    if (encoding.cdr) bytes_ = std::string("\0\1\0\0", 4);
    if (encoding.big_endian) bytes_[1] = 0;
  }
  template <class T>
  RosMessage& add(T value) {
    while (encoding_.cdr && (bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\0';
    std::string raw(sizeof(T), '\0');
    std::memcpy(raw.data(), &value, sizeof(T));
    if (encoding_.big_endian) raw.assign(raw.rbegin(), raw.rend());
    bytes_ += raw;
    return *this;
  }
  RosMessage& text(const std::string& value) {
    add(static_cast<std::uint32_t>(value.size() + (encoding_.cdr ? 1 : 0)));
    bytes_ += value;
    if (encoding_.cdr) bytes_ += '\0';
    return *this;
  }
  RosMessage& data(std::string_view value) {
    add(static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  RosMessage& doubles(const std::vector<double>& values) {
    for (const double value : values) add(value);
    return *this;
  }
  RosMessage& header(Nanoseconds time, const std::string& frame) {
    if (!encoding_.cdr) add(std::uint32_t{0});
    add(static_cast<std::uint32_t>(time / kNanosecondsPerSecond));
    add(static_cast<std::uint32_t>(time % kNanosecondsPerSecond));
    return text(frame);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  Encoding encoding_;
  std::string bytes_;
};

inline std::string image_message(Encoding e, Nanoseconds time, const std::string& frame, int width, int height,
                                 const std::string& encoding, std::string_view data, bool data_big_endian = false) {
  return RosMessage(e)
      .header(time, frame)
      .add(static_cast<std::uint32_t>(height))
      .add(static_cast<std::uint32_t>(width))
      .text(encoding)
      .add(static_cast<std::uint8_t>(data_big_endian))
      .add(static_cast<std::uint32_t>(data.size() / static_cast<std::size_t>(height)))
      .data(data)
      .bytes();
}

inline std::string camera_message(Encoding e, const std::string& frame, int width, int height, double f, double cx,
                                  double cy, const std::string& model = "plumb_bob",
                                  const std::vector<double>& distortion = {0, 0, 0, 0, 0}) {
  return RosMessage(e)
      .header(0, frame)
      .add(static_cast<std::uint32_t>(height))
      .add(static_cast<std::uint32_t>(width))
      .text(model)
      .add(static_cast<std::uint32_t>(distortion.size()))
      .doubles(distortion)
      .doubles({f, 0, cx, 0, f, cy, 0, 0, 1})
      .doubles({1, 0, 0, 0, 1, 0, 0, 0, 1})
      .doubles({f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0})
      .bytes();
}

inline std::string imu_message(Encoding e, Nanoseconds time, const std::string& frame, const std::vector<double>& rate,
                               const std::vector<double>& force) {
  const std::vector<double> covariance(9, 0);
  return RosMessage(e)
      .header(time, frame)
      .doubles({0, 0, 0, 1})
      .doubles(covariance)
      .doubles(rate)
      .doubles(covariance)
      .doubles(force)
      .doubles(covariance)
      .bytes();
}

inline std::string tf_message(Encoding e, const std::string& parent, const std::string& child,
                              const std::vector<double>& translation, const std::vector<double>& quaternion) {
  return RosMessage(e)
      .add(std::uint32_t{1})
      .header(0, parent)
      .text(child)
      .doubles(translation)
      .doubles(quaternion)
      .bytes();
}

struct RecordedMessage {
  std::string topic, type;
  Nanoseconds time = 0;
  std::string data;
};

/// A database as rosbag2 writes it.
inline void write_db3(const std::string& path, const std::vector<RecordedMessage>& messages) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  sqlite3_exec(db,
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
               "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
               "data BLOB NOT NULL); BEGIN;",
               nullptr, nullptr, nullptr);
  std::map<std::string, int> ids;
  for (const RecordedMessage& message : messages) {
    const auto [id, fresh] = ids.insert({message.topic, static_cast<int>(ids.size()) + 1});
    if (fresh) {
      const std::string insert = "INSERT INTO topics VALUES(" + std::to_string(id->second) + ",'" + message.topic +
                                 "','" + message.type + "','cdr','');";
      ASSERT_EQ(sqlite3_exec(db, insert.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    }
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(db, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?,?,?)", -1, &statement, nullptr);
    sqlite3_bind_int(statement, 1, id->second);
    sqlite3_bind_int64(statement, 2, message.time);
    sqlite3_bind_blob(statement, 3, message.data.data(), static_cast<int>(message.data.size()), SQLITE_TRANSIENT);
    ASSERT_EQ(sqlite3_step(statement), SQLITE_DONE);
    sqlite3_finalize(statement);
  }
  ASSERT_EQ(sqlite3_exec(db, "COMMIT", nullptr, nullptr, nullptr), SQLITE_OK);
  sqlite3_close(db);
}

inline std::string zstd_packed(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  return packed;
}

inline std::string lz4_packed(std::string_view bytes) {
  std::string packed(LZ4F_compressFrameBound(bytes.size(), nullptr), '\0');
  packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr));
  return packed;
}

/// Little-endian values, for the records of MCAP and of ROS 1's bags.
template <class T>
std::string little(T value) {
  std::string raw(sizeof(T), '\0');
  std::memcpy(raw.data(), &value, sizeof(T));
  return raw;
}
inline std::string counted(std::string_view text) {
  return little(static_cast<std::uint32_t>(text.size())) + std::string(text);
}

/// An MCAP file, its messages in chunks of `packing` ("none": unpacked; "": no chunks), two a chunk.
inline std::string mcap_bytes(const std::vector<RecordedMessage>& messages, const std::string& packing,
                              const std::string& encoding = "cdr") {
  const auto record = [](char op, const std::string& content) {
    return std::string(1, op) + little(static_cast<std::uint64_t>(content.size())) + content;
  };
  const std::string magic("\x89MCAP0\r\n", 8);
  std::string file = magic + record(1, counted("ros2") + counted("test")), chunk;
  std::map<std::string, std::uint16_t> ids;
  int held = 0;
  const auto flush = [&] {
    if (chunk.empty()) return;
    const std::string packed = packing == "zstd" ? zstd_packed(chunk) : packing == "lz4" ? lz4_packed(chunk) : chunk;
    file += record(6, little(std::uint64_t{0}) + little(std::uint64_t{0}) +
                          little(static_cast<std::uint64_t>(chunk.size())) + little(std::uint32_t{0}) +
                          counted(packing == "none" ? "" : packing) +
                          little(static_cast<std::uint64_t>(packed.size())) + packed);
    chunk.clear();
  };
  for (const RecordedMessage& message : messages) {
    const auto [id, fresh] = ids.insert({message.topic, static_cast<std::uint16_t>(ids.size() + 1)});
    std::string& out = packing.empty() ? file : chunk;
    if (fresh) {
      out += record(3, little(id->second) + counted(message.type) + counted("ros2msg") + counted(""));
      out +=
          record(4, little(id->second) + little(id->second) + counted(message.topic) + counted(encoding) + counted(""));
    }
    out += record(
        5, little(id->second) + little(std::uint32_t{0}) + little(message.time) + little(message.time) + message.data);
    if (!packing.empty() && ++held % 2 == 0) flush();
  }
  flush();
  return file + record(15, little(std::uint32_t{0})) + record(2, std::string(20, '\0')) + magic;
}

/// A ROS 1 bag without an index, in one chunk.
inline std::string bag_bytes(const std::vector<RecordedMessage>& messages) {
  const auto field = [](const std::string& name, const std::string& value) { return counted(name + "=" + value); };
  const auto record = [](const std::string& header, const std::string& data) {
    return counted(header) + counted(data);
  };
  std::map<std::string, std::uint32_t> ids;
  std::string chunk;
  for (const RecordedMessage& message : messages) {
    const auto [id, fresh] = ids.insert({message.topic, static_cast<std::uint32_t>(ids.size())});
    if (fresh)
      chunk += record(field("op", "\x07") + field("conn", little(id->second)) + field("topic", message.topic),
                      field("topic", message.topic) + field("type", message.type));
    const std::string time = little(static_cast<std::uint32_t>(message.time / kNanosecondsPerSecond)) +
                             little(static_cast<std::uint32_t>(message.time % kNanosecondsPerSecond));
    chunk += record(field("op", "\x02") + field("conn", little(id->second)) + field("time", time), message.data);
  }
  return "#ROSBAG V2.0\n" + record(field("op", "\x05") + field("compression", "none") +
                                       field("size", little(static_cast<std::uint32_t>(chunk.size()))),
                                   chunk);
}

}  // namespace plumbline::test
