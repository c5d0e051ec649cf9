#include "io/download.h"

#include "plumbline/error.h"

#ifdef PLUMBLINE_DOWNLOAD
#include <archive.h>
#include <archive_entry.h>
#include <curl/curl.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "io/atomic_file.h"
#include "io/camera.h"
#include "io/text_file.h"
#endif

namespace plumbline {

#ifdef PLUMBLINE_DOWNLOAD
namespace {

namespace fs = std::filesystem;

constexpr const char* kAgain = "try again; what has come is kept and the download goes on from there";

/// What a server says about a file, from the header of its answer.
struct Answer {
  long status = 0;
  std::string validator;  ///< ETag or Last-Modified: the file is the same as long as this is
  std::optional<std::uint64_t> length, range_begin, range_total;

  std::optional<std::uint64_t> total() const { return status == 206 ? range_total : length; }
};

std::optional<std::uint64_t> number(std::string_view text) {
  const auto value = parse_unsigned(trim(text));
  return value ? std::optional<std::uint64_t>(static_cast<std::uint64_t>(*value)) : std::nullopt;
}

/// "bytes 100-199/1000" or "bytes */1000".
void parse_content_range(std::string_view value, Answer* answer) {
  value = trim(value);
  if (!value.starts_with("bytes ")) return;
  value.remove_prefix(6);
  const std::size_t slash = value.find('/'), dash = value.find('-');
  if (slash == std::string_view::npos) return;
  answer->range_total = number(value.substr(slash + 1));
  if (dash < slash) answer->range_begin = number(value.substr(0, dash));
}

void parse_header_line(std::string_view line, Answer* answer) {
  if (line.starts_with("HTTP/")) {  // also after a redirection: only the final answer counts
    *answer = {};
    const std::size_t blank = line.find(' ');
    if (blank != std::string_view::npos)
      answer->status = static_cast<long>(number(line.substr(blank + 1, 3)).value_or(0));
    return;
  }
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const std::string key = lower(line.substr(0, colon));
  const std::string_view value = trim(line.substr(colon + 1));
  if (key == "content-length") answer->length = number(value);
  if (key == "content-range") parse_content_range(value, answer);
  // A weak ETag does not promise the same bytes.
  if (key == "etag" && !value.starts_with("W/")) answer->validator = value;
  if (key == "last-modified" && answer->validator.empty()) answer->validator = value;
}

/// The file that grows, and beside it a line that says of which version of the server's file it is a part.
class Partial {
 public:
  explicit Partial(const std::string& path) : path_(path + ".partial"), note_(path + ".partial.version") {
    fd_ = open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    struct stat status {};
    if (fd_ < 0 || fstat(fd_, &status) != 0) throw_write_error(path_, errno);
    size_ = static_cast<std::uint64_t>(status.st_size);
    std::error_code error;
    if (size_ > 0 && fs::exists(note_, error)) validator_ = std::string(trim(read_file(note_)));
    if (validator_.empty()) restart();
  }
  ~Partial() {
    close(fd_);
    if (size_ == 0) remove();
  }
  Partial(const Partial&) = delete;
  Partial& operator=(const Partial&) = delete;

  std::uint64_t size() const { return size_; }
  const std::string& validator() const { return validator_; }
  const std::string& path() const { return path_; }

  void restart() {
    if (ftruncate(fd_, 0) != 0) throw_write_error(path_, errno);
    size_ = 0;
    validator_.clear();
  }
  void set_validator(const std::string& validator) {
    if (validator == validator_) return;
    validator_ = validator;
    AtomicFile file(note_, Durable::no);
    file.write(validator + "\n");
    file.commit();
  }
  void append(const char* data, std::size_t bytes) {
    if (lseek(fd_, static_cast<off_t>(size_), SEEK_SET) < 0) throw_write_error(path_, errno);
    write_fully(fd_, {data, bytes}, path_);
    size_ += bytes;
  }
  void remove() {
    std::error_code ignored;
    fs::remove(path_, ignored);
    fs::remove(note_, ignored);
  }
  void finish(const std::string& target) {
    if (fsync(fd_) != 0 || rename(path_.c_str(), target.c_str()) != 0) throw_write_error(target, errno);
    std::error_code ignored;
    fs::remove(note_, ignored);
  }

 private:
  std::string path_, note_, validator_;
  int fd_ = -1;
  std::uint64_t size_ = 0;
};

/// One request for the rest of the file.
class Transfer {
 public:
  Transfer(const std::string& url, const DownloadOptions& options, int broken, Partial* partial)
      : url_(url), options_(options), partial_(*partial), curl_(curl_easy_init(), &curl_easy_cleanup) {
    state_.broken = broken;
    if (!curl_) throw Error("libcurl cannot be started", url, "");
  }

  /// libcurl's code; CURLE_OK only if the answer was received to its end.
  CURLcode run() {
    CURL* curl = curl_.get();
    curl_easy_setopt(curl, CURLOPT_URL, url_.c_str());
    curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_REDIR_PROTOCOLS_STR, "http,https");
    curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 1L);
    curl_easy_setopt(curl, CURLOPT_MAXREDIRS, 10L);
    curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
    curl_easy_setopt(curl, CURLOPT_USERAGENT, "plumbline");
    curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(options_.stall_timeout * 1000));
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, std::max(1L, static_cast<long>(options_.stall_timeout)));
    curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
    curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, &on_progress);
    curl_easy_setopt(curl, CURLOPT_XFERINFODATA, this);
    curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, &on_header);
    curl_easy_setopt(curl, CURLOPT_HEADERDATA, this);
    curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &on_data);
    curl_easy_setopt(curl, CURLOPT_WRITEDATA, this);
    curl_slist* list = nullptr;
    if (partial_.size() > 0) {
      list = curl_slist_append(list, fmt::format("Range: bytes={}-", partial_.size()).c_str());
      list = curl_slist_append(list, ("If-Range: " + partial_.validator()).c_str());
    }
    const std::unique_ptr<curl_slist, void (*)(curl_slist*)> headers(list, &curl_slist_free_all);
    curl_easy_setopt(curl, CURLOPT_HTTPHEADER, list);
    const CURLcode code = curl_easy_perform(curl);
    if (error_) std::rethrow_exception(error_);
    return code;
  }

  const Answer& answer() const { return answer_; }
  bool stopped() const { return stopped_; }

 private:
  static std::size_t on_header(char* data, std::size_t size, std::size_t count, void* self) {
    parse_header_line({data, size * count}, &static_cast<Transfer*>(self)->answer_);
    return size * count;
  }

  static std::size_t on_data(char* data, std::size_t size, std::size_t count, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    try {
      return transfer.take({data, size * count}) ? size * count : 0;
    } catch (...) {  // must not pass through C
      transfer.error_ = std::current_exception();
      return 0;
    }
  }

  static int on_progress(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    auto& transfer = *static_cast<Transfer*>(self);
    transfer.state_.done = transfer.partial_.size();
    transfer.state_.total = transfer.answer_.total().value_or(0);
    try {
      if (transfer.options_.progress && !transfer.options_.progress(transfer.state_)) transfer.stopped_ = true;
    } catch (...) {
      transfer.error_ = std::current_exception();
    }
    return transfer.stopped_ || transfer.error_ ? 1 : 0;
  }

  /// False if the bytes are not those of the file.
  bool take(std::string_view bytes) {
    if (answer_.status != 200 && answer_.status != 206) return true;  // the text of a refusal
    if (!begun_) {
      begun_ = true;
      if (answer_.status == 200) partial_.restart();  // all of it: no ranges, or another version
      if (answer_.status == 206 && answer_.range_begin != partial_.size()) {
        partial_.restart();
        return false;
      }
      partial_.set_validator(answer_.validator);
    }
    partial_.append(bytes.data(), bytes.size());
    return true;
  }

  std::string url_;
  const DownloadOptions& options_;
  Partial& partial_;
  std::unique_ptr<CURL, void (*)(CURL*)> curl_;
  Answer answer_;
  DownloadProgress state_;
  std::exception_ptr error_;
  bool begun_ = false, stopped_ = false;
};

[[noreturn]] void refuse(long status, const std::string& url) {
  throw Error(fmt::format("the server answers {}{}", status, status == 404 ? " (not found)" : ""), url,
              "look on the data set's page whether the file has moved, or name another place with --mirror");
}

bool is_passing(long status) { return status >= 500 || status == 408 || status == 429; }

/// Whether a transfer that failed so may succeed later.
bool is_passing(CURLcode code) {
  switch (code) {
    case CURLE_OK:
    case CURLE_PARTIAL_FILE:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
    case CURLE_WRITE_ERROR:  // bytes that do not follow those that are there; the disk's errors are thrown
    case CURLE_GOT_NOTHING:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_COULDNT_CONNECT:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
      return true;
    default:
      return false;
  }
}

/// Whether the file is whole now. Throws Error for what trying again cannot mend.
bool is_whole(const Answer& answer, CURLcode code, const std::string& url, Partial* partial) {
  if (answer.status == 416) {  // nothing follows what is there: it is all, or part of another file
    if (partial->size() > 0 && answer.range_total == partial->size()) return true;
    partial->restart();
    return false;
  }
  const bool good = answer.status == 200 || answer.status == 206;
  if (answer.status != 0 && !good && !is_passing(answer.status)) refuse(answer.status, url);
  if (!is_passing(code)) throw Error(curl_easy_strerror(code), url, "check the connection and the address");
  if (code != CURLE_OK || !good) return false;
  const std::optional<std::uint64_t> total = answer.total();
  if (total && *total < partial->size()) partial->restart();
  return !total || *total == partial->size();
}

/// Waits, looking every now and then whether to stop.
bool wait_a_while(double seconds, const DownloadOptions& options, const DownloadProgress& state) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    if (options.progress && !options.progress(state)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(std::min(100, 1 + static_cast<int>(1000 * seconds))));
  }
  return true;
}

void check_and_finish(Partial* partial, const std::string& path, const DownloadOptions& options) {
  if (!options.sha256.empty()) {
    const std::string found = sha256_of(partial->path());
    if (found != lower(options.sha256)) {
      partial->remove();
      throw Error(fmt::format("the file has the checksum {} and not {}; it was removed", found, lower(options.sha256)),
                  path, "download it again; if the checksum stays wrong, the file was changed on the server");
    }
  }
  partial->finish(path);
}

}  // namespace

DownloadResult download_file(const std::string& url, const std::string& path, const DownloadOptions& options) {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (started != CURLE_OK) throw Error("libcurl cannot be started", url, "");
  Partial partial(path);
  DownloadProgress state;
  std::uint64_t most = partial.size();
  double wait = options.first_wait;
  for (int failures = 0; failures < options.attempts; ++state.broken) {
    Transfer transfer(url, options, state.broken, &partial);
    const CURLcode code = transfer.run();
    if (transfer.stopped()) return DownloadResult::stopped;
    if (is_whole(transfer.answer(), code, url, &partial)) {
      check_and_finish(&partial, path, options);
      return DownloadResult::complete;
    }
    if (partial.size() > most) {
      most = partial.size();
      failures = 0;
      wait = options.first_wait;
      continue;
    }
    state.done = partial.size();
    state.total = transfer.answer().total().value_or(0);
    if (++failures < options.attempts && !wait_a_while(wait, options, state)) return DownloadResult::stopped;
    wait *= 2;
  }
  throw Error(fmt::format("the download broke off {} times; {} bytes have come", state.broken, partial.size()), url,
              kAgain);
}

std::string sha256_of(const std::string& path) {
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(EVP_MD_CTX_new(), &EVP_MD_CTX_free);
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw Error(std::string("cannot be read: ") + std::strerror(errno), path, "check the path");
  const std::unique_ptr<const int, void (*)(const int*)> closer(&fd, [](const int* f) { close(*f); });
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  std::string buffer(1 << 20, '\0');
  for (;;) {
    const ssize_t n = read(fd, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw Error(std::string("cannot be read: ") + std::strerror(errno), path, "check the disk");
    if (n == 0) break;
    EVP_DigestUpdate(context.get(), buffer.data(), static_cast<std::size_t>(n));
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &size);
  std::string text;
  for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

namespace {

[[noreturn]] void fail_to_unpack(archive* from, const std::string& path) {
  const char* why = archive_error_string(from);
  throw Error(fmt::format("cannot be unpacked: {}", why != nullptr ? why : "unknown"), path,
              "delete the file and download it again");
}

/// Relative, and without "..".
bool stays_inside(const fs::path& path) {
  return !path.empty() && path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

void extract_all(const std::string& path, const fs::path& folder, const std::function<bool()>& go_on) {
  const std::unique_ptr<archive, int (*)(archive*)> reader(archive_read_new(), &archive_read_free);
  const std::unique_ptr<archive, int (*)(archive*)> writer(archive_write_disk_new(), &archive_write_free);
  archive_read_support_filter_all(reader.get());
  archive_read_support_format_all(reader.get());
  archive_write_disk_set_options(writer.get(), ARCHIVE_EXTRACT_TIME);
  if (archive_read_open_filename(reader.get(), path.c_str(), 1 << 20) != ARCHIVE_OK) fail_to_unpack(reader.get(), path);
  for (;;) {
    archive_entry* entry = nullptr;
    const int status = archive_read_next_header(reader.get(), &entry);
    if (status == ARCHIVE_EOF) return;
    if (status < ARCHIVE_WARN) fail_to_unpack(reader.get(), path);
    if (go_on && !go_on()) throw Error("unpacking was stopped", path, "start again; the archive is kept");
    const char* name = archive_entry_pathname(entry);
    const auto type = archive_entry_filetype(entry);
    // Links and devices, by which others' files could be reached, are left out.
    if (name == nullptr || (type != AE_IFREG && type != AE_IFDIR) || archive_entry_hardlink(entry) != nullptr) continue;
    if (!stays_inside(name))
      throw Error(fmt::format("holds '{}', which points out of the folder", name), path, "do not unpack this archive");
    archive_entry_set_pathname(entry, (folder / name).c_str());
    if (archive_read_extract2(reader.get(), entry, writer.get()) < ARCHIVE_WARN) fail_to_unpack(reader.get(), path);
  }
}

}  // namespace

void unpack_archive(const std::string& path, const std::string& folder, const std::function<bool()>& go_on) {
  const fs::path target(folder), temporary(folder + ".partial");
  std::error_code error;
  if (fs::exists(target, error)) throw Error("is there already", folder, "delete it, or choose another folder");
  fs::remove_all(temporary, error);
  ensure_directory(temporary.string());
  try {
    extract_all(path, fs::absolute(temporary), go_on);
  } catch (...) {
    fs::remove_all(temporary, error);
    throw;
  }
  std::vector<fs::path> top;
  for (const auto& entry : fs::directory_iterator(temporary)) top.push_back(entry.path());
  const bool nested = top.size() == 1 && fs::is_directory(top.front());
  fs::rename(nested ? top.front() : temporary, target);
  if (nested) fs::remove_all(temporary, error);
}

#else

namespace {
[[noreturn]] void fail(const std::string& where) {
  throw Error("this program was built without downloads", where,
              "install libcurl4-openssl-dev, libarchive-dev and libssl-dev and build it again");
}
}  // namespace

DownloadResult download_file(const std::string& url, const std::string&, const DownloadOptions&) { fail(url); }
std::string sha256_of(const std::string& path) { fail(path); }
void unpack_archive(const std::string& archive, const std::string&, const std::function<bool()>&) { fail(archive); }

#endif

}  // namespace plumbline
