// Files of rosbag2's SQLite storage: tables `topics` and `messages`.
#include <fmt/format.h>
#include <sqlite3.h>

#include <map>
#include <mutex>

#include "io/containers/message_store.h"
#include "io/containers/unpack.h"
#include "plumbline/error.h"

namespace plumbline {
namespace {

constexpr std::size_t kMaxMessage = 1u << 28;
constexpr int kMaxSteps = 1 << 30;
constexpr const char* kSqliteStoreAdvice = "copy the file again, or convert it with `ros2 bag convert`";

struct Closer {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
};
using Database = std::unique_ptr<sqlite3, Closer>;
using Statement = std::unique_ptr<sqlite3_stmt, Closer>;
using Blob = std::unique_ptr<sqlite3_blob, Closer>;

/// SQLite's name for a file that nobody else writes; it is then read without its journal and without locks.
std::string immutable_name(const std::string& path) {
  std::string name = "file:";
  for (const char c : path)
    name +=
        c == '?' || c == '#' || c == '%' ? fmt::format("%{:02X}", static_cast<unsigned char>(c)) : std::string(1, c);
  return name + "?immutable=1";
}

class SqliteStore : public MessageStore {
 public:
  explicit SqliteStore(const std::string& path) : MessageStore(path, "ROS 2 bag (SQLite)") {
    open(path, SQLITE_OPEN_READONLY);
    // A database with a journal cannot be opened as such in a folder that must not be written.
    if (!has_tables()) open(immutable_name(path), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    if (!has_tables()) fail("is a SQLite database, but none of ROS 2: it has no tables 'topics' and 'messages'");
    list();
  }

  MessageBytes read(const StoredMessage& message) const override { return read_beginning(message, message.size); }

  MessageBytes read_beginning(const StoredMessage& message, std::size_t size) const override {
    const std::scoped_lock lock(mutex_);
    sqlite3_blob* raw = nullptr;
    const int status = sqlite3_blob_open(database_.get(), "main", "messages", "data",
                                         static_cast<sqlite3_int64>(message.offset), 0, &raw);
    const Blob blob(raw);
    if (status != SQLITE_OK) fail("a message cannot be read: " + reason());
    const auto stored = static_cast<std::size_t>(sqlite3_blob_bytes(blob.get()));
    if (stored > kMaxMessage) fail("a message is too large");
    std::string bytes = take(blob.get(), std::min(size, stored));
    if (is_zstd(bytes)) bytes = unpacked(take(blob.get(), stored));
    auto owner = std::make_shared<const std::string>(std::move(bytes));
    return {owner, *owner};
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw Error(what, path(), kSqliteStoreAdvice); }
  std::string reason() const { return sqlite3_errmsg(database_.get()); }

  void open(const std::string& name, int flags) {
    sqlite3* raw = nullptr;
    sqlite3_open_v2(name.c_str(), &raw, flags | SQLITE_OPEN_FULLMUTEX, nullptr);
    database_.reset(raw);
    if (!database_) fail("cannot be opened");
    // The file is another's: nothing in it may run or be trusted.
    sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxMessage));
    steps_ = 0;
    sqlite3_progress_handler(
        raw, 1000, [](void* steps) { return (*static_cast<int*>(steps) += 1000) > kMaxSteps ? 1 : 0; }, &steps_);
  }

  Statement prepare(const char* text) const {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(database_.get(), text, -1, &raw, nullptr) != SQLITE_OK) fail("cannot be read: " + reason());
    return Statement(raw);
  }

  bool has_tables() const {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(database_.get(),
                           "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages')",
                           -1, &raw, nullptr) != SQLITE_OK)
      return false;
    const Statement statement(raw);
    return sqlite3_step(raw) == SQLITE_ROW && sqlite3_column_int(raw, 0) == 2;
  }

  static std::string text(sqlite3_stmt* row, int column) {
    const auto* value = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
    return value == nullptr ? std::string() : std::string(value);
  }

  /// Calls `use` with each row.
  template <class Use>
  void each_row(const char* query, Use&& use) const {
    const Statement statement = prepare(query);
    int status = SQLITE_ROW;
    while ((status = sqlite3_step(statement.get())) == SQLITE_ROW) use(statement.get());
    if (status != SQLITE_DONE) fail("is damaged: " + reason());
  }

  void list() {
    std::map<sqlite3_int64, std::size_t> topic_of_id;
    each_row("SELECT id, name, type, serialization_format FROM topics", [&](sqlite3_stmt* row) {
      if (text(row, 3) == "cdr")
        topic_of_id[sqlite3_column_int64(row, 0)] = add_topic(text(row, 1), text(row, 2), Wire::cdr);
    });
    each_row("SELECT rowid, topic_id, timestamp, length(data) FROM messages ORDER BY rowid", [&](sqlite3_stmt* row) {
      const auto topic = topic_of_id.find(sqlite3_column_int64(row, 1));
      if (topic == topic_of_id.end()) return;
      topics_[topic->second].messages.push_back({sqlite3_column_int64(row, 2), 0, 0,
                                                 static_cast<std::uint64_t>(sqlite3_column_int64(row, 0)),
                                                 static_cast<std::uint64_t>(sqlite3_column_int64(row, 3))});
    });
  }

  std::string take(sqlite3_blob* blob, std::size_t size) const {
    std::string bytes(size, '\0');
    if (size > 0 && sqlite3_blob_read(blob, bytes.data(), static_cast<int>(size), 0) != SQLITE_OK)
      fail("a message cannot be read: " + reason());
    return bytes;
  }

  /// Of rosbag2's compression of single messages.
  std::string unpacked(const std::string& stored) const {
    auto bytes = unpack_zstd_frame(stored, kMaxMessage);
    if (!bytes) fail("a packed message is damaged");
    return std::move(*bytes);
  }

  Database database_;
  int steps_ = 0;
  mutable std::mutex mutex_;  // a handle of SQLite keeps one error message for all threads
};

}  // namespace

bool is_sqlite(std::string_view bytes) { return bytes.starts_with(std::string_view("SQLite format 3\0", 16)); }

std::unique_ptr<MessageStore> open_sqlite_store(const std::string& path) { return std::make_unique<SqliteStore>(path); }

}  // namespace plumbline
