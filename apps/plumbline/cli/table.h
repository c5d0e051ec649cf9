// Tables of results: made once, written as text, Markdown, CSV and JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace plumbline::app {

/// What people read, and the number behind it where there is one, for programs.
struct Cell {
  std::string text;
  std::optional<double> value;

  Cell() = default;
  Cell(std::string words) : text(std::move(words)) {}  // NOLINT: a word is a cell
  Cell(const char* words) : text(words) {}             // NOLINT
  /// A number with so many decimals, and what stands behind it ("%", " ms").
  Cell(double number, int decimals, const std::string& unit = "");
};

/// A number, or a dash where there is none.
Cell number_or_dash(const std::optional<double>& number, int decimals, const std::string& unit = "");

struct Table {
  std::string name;                ///< of its files
  std::string title;               ///< a sentence
  std::vector<std::string> notes;  ///< below it, a sentence or more each
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;  ///< a cell for each column
};

/// Aligned for a terminal, numbers to the right.
std::string table_text(const Table& table);
/// With title and notes.
std::string table_markdown(const Table& table);
/// Header and rows: the numbers with all their digits, nothing where there is a dash.
std::string table_csv(const Table& table);
/// An array with an object for each row: the numbers as numbers, null where there is a dash.
std::string table_json(const Table& table);

}  // namespace plumbline::app
