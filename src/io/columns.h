// Headings of tables: what the columns of a text file are called, and in which units they are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "io/text_file.h"

namespace plumbline {

struct ColumnName {
  std::string name;  ///< lower case, without blanks around it and without its unit
  std::string unit;  ///< what stood in brackets after the name, lower case; empty without brackets
};

/// Names between commas, or between blanks where there are none.
std::vector<ColumnName> column_names(std::string_view head);

/// "timestamp, gyro_x, …" for messages.
std::string list(const std::vector<ColumnName>& names);

/// 'w', 'x', 'y' or 'z' if the name is that of a quaternion's component, else 0.
char quaternion_component(std::string_view name);

/// The text before the first blank or comma.
std::string_view first_field(const TextLine& line);

/// Fields between commas, which may be empty, or between blanks where there are no commas.
std::vector<std::string_view> table_fields(std::string_view text);

/// A heading is a line whose first field is a word, or begins with '%' as `rostopic echo -p` writes it, and most of
/// whose fields are no numbers.
bool is_heading(const TextLine& line);

/// A table's lines without its heading.
struct Table {
  std::string_view head;     ///< the heading, or the comment right before the first line; empty without either
  bool has_heading = false;  ///< a heading, and not only a comment
  std::vector<TextLine> rows;
};
Table read_table(const TextFile& file);

}  // namespace plumbline
