#include "io/csv.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "io/atomic_file.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {

std::string csv_field(std::string_view value) {
  if (value.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(value);
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

namespace {

std::vector<std::string> csv_fields(std::string_view line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

}  // namespace

std::size_t CsvTable::column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end())
    throw Error("has no column '" + std::string(name) + "'", path, "give a table of the kind that is needed");
  return static_cast<std::size_t>(found - columns.begin());
}

CsvTable read_csv(const std::string& path) {
  const TextFile file(path);
  CsvTable table{.path = path, .columns = {}, .rows = {}};
  for (const TextLine& line : file.lines()) {
    std::vector<std::string> fields = csv_fields(line.text);
    if (table.columns.empty()) {
      table.columns = std::move(fields);
      continue;
    }
    if (fields.size() != table.columns.size()) {
      // The table of a run that was killed may end within a row.
      if (is_half_written(line, fields.size() < table.columns.size())) break;
      file.fail(line,
                std::to_string(fields.size()) + " fields where the heading has " + std::to_string(table.columns.size()),
                "give one field for each column");
    }
    table.rows.push_back(std::move(fields));
  }
  if (table.columns.empty()) throw Error("is empty", path, "give a table with a heading");
  return table;
}

CsvWriter::CsvWriter(const std::string& path, const std::vector<std::string>& columns)
    : path_(path), columns_(columns.size()) {
  if (columns.empty()) throw Error("a table needs at least one column", path, "name the columns");
  fd_ = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd_ < 0) throw_write_error(path, errno);
  try {
    row(columns);
  } catch (...) {
    ::close(fd_);
    throw;
  }
}

CsvWriter::~CsvWriter() {
  if (fd_ >= 0) ::close(fd_);
}

void CsvWriter::row(const std::vector<std::string>& fields) {
  if (fd_ < 0) throw Error("a row was written after the table was closed", path_, "close it after the last row");
  if (fields.size() != columns_)
    throw Error(
        "a row of " + std::to_string(fields.size()) + " fields does not fit " + std::to_string(columns_) + " columns",
        path_, "give one field for each column");
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) line += ',';
    line += csv_field(fields[i]);
  }
  // A lone empty field would be a blank line, which readers skip.
  if (line.empty()) line = "\"\"";
  write_fully(fd_, line + '\n', path_);
}

void CsvWriter::close() {
  if (fd_ < 0) return;
  const int fd = fd_;
  fd_ = -1;
  if (::close(fd) != 0) throw_write_error(path_, errno);
}

}  // namespace plumbline
