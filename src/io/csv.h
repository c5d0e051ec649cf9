// Comma-separated tables that can be followed while they grow.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// A field as RFC 4180 wants it: in quotes, with quotes doubled, if it holds a comma, a quote or a line end.
std::string csv_field(std::string_view value);

/// A table that was read whole.
struct CsvTable {
  std::string path;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`

  /// Index of a column. Throws Error if there is none of that name.
  std::size_t column(std::string_view name) const;
};

/// Reads a table whose first line names the columns (RFC 4180, but no line end within quotes); comments with '#' and
/// blank lines are skipped. Throws Error with file and line for a row of another length, and for a file without a line.
CsvTable read_csv(const std::string& path);

/// Writes a header and then row after row, each handed to the system at once, so that a table of a run that was broken
/// off is good up to its last row. Lines end with LF. Not thread-safe.
class CsvWriter {
 public:
  /// Replaces an old file. Throws Error if the file cannot be made or there are no columns.
  CsvWriter(const std::string& path, const std::vector<std::string>& columns);
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  /// One field a column. Throws Error if their number differs from the header's or the disk is full.
  void row(const std::vector<std::string>& fields);

  /// Closes the file, after which no row may follow. Throws Error if the system kept an error until now; the destructor
  /// closes too, but silently.
  void close();

 private:
  std::string path_;
  std::size_t columns_;
  int fd_ = -1;
};

}  // namespace plumbline
