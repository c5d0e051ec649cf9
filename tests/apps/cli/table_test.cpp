// Tables as text, Markdown, CSV and JSON.
#include "cli/table.h"

#include <gtest/gtest.h>

namespace plumbline::test {
namespace {

app::Table example() {
  app::Table table;
  table.title = "A title";
  table.columns = {"λ", "value, m", "what"};
  table.rows = {{"c/√n", app::Cell(0.123456789, 2), "a|b"}, {"c", "–", "x \"y\""}};
  table.notes = {"A note."};
  return table;
}

TEST(Table, TextIsAlignedByColumnsOfTheTerminal) {
  EXPECT_EQ(app::table_text(example()),
            "λ     value, m  what\n"
            "c/√n      0.12  a|b\n"
            "c            –  x \"y\"\n");
}

TEST(Table, MarkdownHasTitleNotesAndNoStrayBars) {
  EXPECT_EQ(app::table_markdown(example()),
            "**A title**\n\n"
            "| λ | value, m | what |\n"
            "|---|--:|---|\n"
            "| c/√n | 0.12 | a\\|b |\n"
            "| c | – | x \"y\" |\n"
            "\nA note.\n");
}

TEST(Table, CsvKeepsAllDigitsAndLeavesOutWhatIsUnknown) {
  EXPECT_EQ(app::table_csv(example()), "λ,\"value, m\",what\nc/√n,0.123456789,a|b\nc,,\"x \"\"y\"\"\"\n");
}

TEST(Table, JsonHasNumbersAndNulls) {
  EXPECT_EQ(app::table_json(example()),
            "[\n  {\n    \"λ\": \"c/√n\",\n    \"value, m\": 0.123456789,\n    \"what\": \"a|b\"\n  },\n"
            "  {\n    \"λ\": \"c\",\n    \"value, m\": null,\n    \"what\": \"x \\\"y\\\"\"\n  }\n]\n");
}

TEST(Table, ACellMayHaveAUnitThatItsNumberHasNot) {
  const app::Cell cell(-12.345, 1, "%");
  EXPECT_EQ(cell.text, "-12.3%");
  EXPECT_EQ(cell.value, -12.345);
  EXPECT_EQ(app::number_or_dash({}, 1, "%").text, "–");
}

}  // namespace
}  // namespace plumbline::test
