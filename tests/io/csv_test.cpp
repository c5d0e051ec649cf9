#include "io/csv.h"

#include <gmock/gmock.h>

#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::read_text;
using test::TempFolder;

TEST(Csv, QuotesAsRfc4180) {
  EXPECT_EQ(csv_field("plain text"), "plain text");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"hi\""), "\"say \"\"hi\"\"\"");
  EXPECT_EQ(csv_field("two\nlines"), "\"two\nlines\"");
  EXPECT_EQ(csv_field("cr\r"), "\"cr\r\"");
  EXPECT_EQ(csv_field(""), "");
}

TEST(Csv, EveryRowIsOnDiskAtOnce) {
  const TempFolder folder;
  const std::string path = folder / "frames.csv";
  CsvWriter writer(path, {"frame", "status"});
  EXPECT_EQ(read_text(path), "frame,status\n");
  writer.row({"0", "tracked"});
  EXPECT_EQ(read_text(path), "frame,status\n0,tracked\n");
  writer.row({"", "lost, far"});
  EXPECT_EQ(read_text(path), "frame,status\n0,tracked\n,\"lost, far\"\n");
  writer.close();
  EXPECT_THROW(writer.row({"1", "x"}), Error);
}

TEST(Csv, AnEmptyOnlyFieldIsNotABlankLine) {
  const TempFolder folder;
  CsvWriter writer(folder / "one.csv", {"only"});
  writer.row({""});
  EXPECT_EQ(read_text(folder / "one.csv"), "only\n\"\"\n");
}

TEST(Csv, ReadsWhatItWrote) {
  const TempFolder folder;
  const std::string path = folder / "t.csv";
  CsvWriter writer(path, {"name", "say \"hi\"", "empty"});
  writer.row({"a,b", "1", ""});
  writer.row({"", "\"", "x"});
  writer.close();
  const CsvTable table = read_csv(path);
  EXPECT_EQ(table.columns, (std::vector<std::string>{"name", "say \"hi\"", "empty"}));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"a,b", "1", ""}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"", "\"", "x"}));
  EXPECT_EQ(table.column("empty"), 2u);
  EXPECT_THAT(error_of([&] { [[maybe_unused]] const auto i = table.column("no"); }),
              testing::HasSubstr("no column 'no'"));
}

TEST(Csv, RefusesTornTablesButNotATornEnd) {
  const TempFolder folder;
  const std::string path = folder / "t.csv";
  test::write_text(path, "a,b\n1,2\n3");
  EXPECT_EQ(read_csv(path).rows.size(), 1u);
  test::write_text(path, "a,b\n1\n3,4\n");
  EXPECT_THAT(error_of([&] { read_csv(path); }), testing::HasSubstr("t.csv:2: 1 fields where the heading has 2"));
  test::write_text(path, "");
  EXPECT_THAT(error_of([&] { read_csv(path); }), testing::HasSubstr("is empty"));
}

TEST(Csv, Errors) {
  const TempFolder folder;
  EXPECT_THAT(error_of([&] { CsvWriter(folder / "no/f.csv", {"a"}); }), testing::HasSubstr("create the folder"));
  EXPECT_THAT(error_of([&] { CsvWriter("/dev/full", {"a"}); }), testing::HasSubstr("no space left"));
  EXPECT_THROW(CsvWriter(folder / "f.csv", {}), Error);
  CsvWriter writer(folder / "f.csv", {"a", "b"});
  EXPECT_THAT(error_of([&] { writer.row({"1"}); }), testing::HasSubstr("2 columns"));
}

}  // namespace
}  // namespace plumbline
