#include "cli/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/csv.h"

namespace plumbline::app {
namespace {

constexpr const char* kDash = "–";

/// Columns that UTF-8 text takes on a terminal, for the scripts that occur here.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

/// A column of numbers: none of its cells is a word.
bool is_numeric(const Table& table, std::size_t column) {
  return std::all_of(table.rows.begin(), table.rows.end(), [&](const std::vector<Cell>& row) {
    return row[column].value || row[column].text.empty() || row[column].text == kDash;
  });
}

std::string padded(const std::string& text, std::size_t width, bool right) {
  const std::string blanks(width - std::min(width, width_of(text)), ' ');
  return right ? blanks + text : text + blanks;
}

std::string csv_text(const Cell& cell) {
  if (cell.value) return fmt::format("{:.9g}", *cell.value);
  return cell.text == kDash ? "" : cell.text;
}

std::string markdown_cell(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '|') escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

template <class Cells, class Text>
std::string joined(const Cells& cells, const std::string& separator, Text&& text) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : separator) + text(cells[i], i);
  return line;
}

std::size_t width_of_column(const Table& table, std::size_t i) {
  std::size_t width = width_of(table.columns[i]);
  for (const auto& row : table.rows) width = std::max(width, width_of(row[i].text));
  return width;
}

}  // namespace

Cell::Cell(double number, int decimals, const std::string& unit)
    : text(fmt::format("{:.{}f}{}", number, decimals, unit)), value(number) {}

Cell number_or_dash(const std::optional<double>& number, int decimals, const std::string& unit) {
  return number ? Cell(*number, decimals, unit) : Cell(kDash);
}

std::string table_text(const Table& table) {
  std::vector<std::size_t> widths;
  std::vector<bool> right;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    widths.push_back(width_of_column(table, i));
    right.push_back(is_numeric(table, i));
  }
  const auto line = [&](const auto& cells, auto&& text) {
    std::string result =
        joined(cells, "  ", [&](const auto& cell, std::size_t i) { return padded(text(cell), widths[i], right[i]); });
    result.erase(result.find_last_not_of(' ') + 1);
    return result + "\n";
  };
  std::string result = line(table.columns, [](const std::string& name) { return name; });
  for (const auto& row : table.rows) result += line(row, [](const Cell& cell) { return cell.text; });
  return result;
}

std::string table_markdown(const Table& table) {
  std::string result = "**" + table.title + "**\n\n";
  result +=
      "| " + joined(table.columns, " | ", [](const auto& name, auto) { return markdown_cell(name); }) + " |\n|" +
      joined(table.columns, "|", [&](const auto&, std::size_t i) { return is_numeric(table, i) ? "--:" : "---"; }) +
      "|\n";
  for (const auto& row : table.rows)
    result += "| " + joined(row, " | ", [](const Cell& cell, auto) { return markdown_cell(cell.text); }) + " |\n";
  for (const std::string& note : table.notes) result += "\n" + note + "\n";
  return result;
}

std::string table_csv(const Table& table) {
  std::string result = joined(table.columns, ",", [](const auto& name, auto) { return csv_field(name); }) + "\n";
  for (const auto& row : table.rows)
    result += joined(row, ",", [](const Cell& cell, auto) { return csv_field(csv_text(cell)); }) + "\n";
  return result;
}

std::string table_json(const Table& table) {
  using Json = nlohmann::ordered_json;
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json object = Json::object();
    for (std::size_t i = 0; i < row.size(); ++i)
      object[table.columns[i]] = row[i].value ? Json(*row[i].value) : row[i].text == kDash ? Json() : Json(row[i].text);
    rows.push_back(object);
  }
  return rows.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace plumbline::app
