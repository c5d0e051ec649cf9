#include "io/columns.h"

#include <algorithm>
#include <cctype>

#include "io/camera.h"

namespace plumbline {
namespace {

/// Without the quotes that spreadsheets put around a name.
std::string_view unquoted(std::string_view text) {
  text = trim(text);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') text = trim(text.substr(1, text.size() - 2));
  return text;
}

/// Spreadsheets of half the world write semicolons.
char separator_of(std::string_view text) { return text.find(';') != std::string_view::npos ? ';' : ','; }

ColumnName column_name(std::string_view quoted) {
  const std::string_view text = unquoted(quoted);
  std::size_t open = text.find('[');
  if (open == std::string_view::npos && text.ends_with(')')) open = text.rfind('(');
  ColumnName column{lower(trim(text.substr(0, open))), ""};
  if (open == std::string_view::npos) return column;
  const std::string_view unit = text.substr(open + 1);
  column.unit = lower(trim(unit.substr(0, unit.find_first_of("])"))));
  return column;
}

}  // namespace

std::vector<ColumnName> column_names(std::string_view head) {
  std::vector<ColumnName> names;
  const char separator = separator_of(head);
  if (head.find(separator) == std::string_view::npos) {
    for (const std::string_view name : split_fields(head)) names.push_back(column_name(name));
    return names;
  }
  for (std::string_view rest = head; !rest.empty();) {
    const std::size_t comma = std::min(rest.find(separator), rest.size());
    names.push_back(column_name(rest.substr(0, comma)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return names;
}

std::string list(const std::vector<ColumnName>& names) {
  std::string text;
  for (const ColumnName& column : names) text += (text.empty() ? "" : ", ") + column.name;
  return text;
}

char quaternion_component(std::string_view name) {
  if (name.size() < 2 || name.back() < 'w' || name.back() > 'z') return 0;
  std::string_view stem = name.substr(0, name.size() - 1);
  while (!stem.empty() && (stem.back() == '_' || stem.back() == '.' || stem.back() == '/')) stem.remove_suffix(1);
  return stem.starts_with('q') || stem.ends_with("orientation") ? name.back() : '\0';
}

std::string_view first_field(const TextLine& line) {
  const auto fields = split_fields(line.text, true);
  return fields.empty() ? std::string_view() : fields.front();
}

std::vector<std::string_view> table_fields(std::string_view text) {
  const char separator = separator_of(text);
  if (text.find(separator) == std::string_view::npos) return split_fields(text);
  std::vector<std::string_view> fields;
  for (std::size_t comma = text.find(separator); comma != std::string_view::npos; comma = text.find(separator)) {
    fields.push_back(trim(text.substr(0, comma)));
    text.remove_prefix(comma + 1);
  }
  fields.push_back(trim(text));
  return fields;
}

bool is_heading(const TextLine& line) {
  const std::string_view first = first_field(line);
  const auto fields = table_fields(line.text);
  const auto numbers = std::count_if(fields.begin(), fields.end(),
                                     [](std::string_view field) { return parse_double(field).has_value(); });
  return !first.empty() && 2 * static_cast<std::size_t>(numbers) < std::max<std::size_t>(fields.size(), 2) &&
         (std::isalpha(static_cast<unsigned char>(first.front())) != 0 || first.front() == '"' ||
          first.front() == '%') &&
         !parse_double(first);
}

Table read_table(const TextFile& file) {
  Table table{file.head(), false, file.lines()};
  table.has_heading = !table.rows.empty() && is_heading(table.rows.front());
  if (!table.has_heading) return table;
  table.head = table.rows.front().text;
  table.rows.erase(table.rows.begin());
  return table;
}

}  // namespace plumbline
