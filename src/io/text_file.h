// Text files read whole, line by line, with the numbers that error messages need.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// The bytes of a regular file. Throws Error if it is missing, a folder, or cannot be read.
std::string read_file(const std::string& path);

/// Its first bytes, `limit` at most. Throws Error as above.
std::string read_beginning(const std::string& path, std::size_t limit);

/// A line that says something: blank lines and those that begin with '#' are left out, as are line ends.
struct TextLine {
  int number = 0;  ///< counted from 1
  std::string_view text;
  bool is_last = false;     ///< no line with text follows
  bool has_newline = true;  ///< false for a last line that a writer did not finish, or whose editor left the end out
};

/// A text file with LF or CRLF line ends, with or without a byte-order mark, gzipped or not.
class TextFile {
 public:
  explicit TextFile(const std::string& path);

  const std::string& path() const { return path_; }
  const std::vector<TextLine>& lines() const { return lines_; }
  /// What the comment right before the first line says, without its '#': often the names of the columns. Empty if there
  /// is none.
  std::string_view head() const { return head_; }

  /// Throws Error located at "path:line".
  [[noreturn]] void fail(const TextLine& line, const std::string& what, const std::string& advice) const;

 private:
  std::string path_;
  std::shared_ptr<const void> content_;  // what the views look at; shared, so that a TextFile can be copied
  std::vector<TextLine> lines_;
  std::string_view head_;
};

/// A last line is taken for half-written, and may be left out, if it did not end or lacks fields.
inline bool is_half_written(const TextLine& line, bool lacks_fields) {
  return line.is_last && (lacks_fields || !line.has_newline);
}

std::string_view trim(std::string_view text);

/// Fields between runs of spaces and tabs, and of commas and semicolons where `commas`.
std::vector<std::string_view> split_fields(std::string_view text, bool commas = false);
/// Same into `fields`, whose memory is used again: for files of millions of lines.
void split_fields(std::string_view text, bool commas, std::vector<std::string_view>* fields);

/// The whole of `text` as a number, which may be infinite or NaN; empty if it is none. Independent of the locale.
std::optional<double> parse_double(std::string_view text);

/// The whole of `text` as a decimal integer without a sign.
std::optional<long long> parse_unsigned(std::string_view text);

}  // namespace plumbline
