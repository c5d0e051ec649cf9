#include "io/csv.h"

#include <gmock/gmock.h>

#include "temp_folder.h"

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
