#include "io/download.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "io/datasets.h"
#include "support/error_of.h"
#include "support/source.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;
using test::error_of;
using test::read_text;
using test::TempFolder;
using test::write_text;
using testing::AllOf;
using testing::HasSubstr;

/// tests/io/flaky_server.py over a folder with "file", 350 kB that do not repeat.
class Download : public testing::Test {
 protected:
  void SetUp() override {
    std::uint32_t state = 1;
    for (int i = 0; i < 350'000; ++i) content_ += static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
    write_text(folder_ / "served/file", content_);
    const fs::path script = test::source_root() / "tests/io/flaky_server.py";
    const std::string command =
        "exec python3 '" + script.string() + "' '" + (folder_ / "served") + "' '" + (folder_ / "port") + "'";
    server_ = popen(command.c_str(), "w");
    ASSERT_NE(server_, nullptr);
    for (int i = 0; i < 600 && !fs::exists(folder_ / "port"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    ASSERT_TRUE(fs::exists(folder_ / "port")) << "the server did not start";
    options_.first_wait = 0.01;
    options_.stall_timeout = 20;
  }
  void TearDown() override {
    if (server_ != nullptr) pclose(server_);
  }

  std::string url(const std::string& mode, const std::string& name = "file") const {
    return "http://127.0.0.1:" + read_text(folder_ / "port") + "/" + mode + "/" + name;
  }
  std::string target() const { return folder_ / "got"; }
  void expect_whole() const {
    EXPECT_EQ(read_text(target()), content_);
    EXPECT_FALSE(fs::exists(target() + ".partial"));
    EXPECT_FALSE(fs::exists(target() + ".partial.version"));
  }
  void get(const std::string& mode) {
    EXPECT_EQ(download_file(url(mode), target(), options_), DownloadResult::complete);
    expect_whole();
  }

  TempFolder folder_;
  std::string content_;
  DownloadOptions options_;
  FILE* server_ = nullptr;
};

TEST_F(Download, FetchesAFileAndReportsProgress) {
  DownloadProgress last;
  options_.progress = [&](const DownloadProgress& state) {
    EXPECT_GE(state.done, last.done);
    last = state;
    return true;
  };
  get("good");
  EXPECT_EQ(last.total, content_.size());
  EXPECT_EQ(last.broken, 0);
}

TEST_F(Download, GoesOnWhereTheConnectionBroke) {
  DownloadProgress last;
  options_.progress = [&](const DownloadProgress& state) { return last = state, true; };
  options_.attempts = 1;  // not one try may be without new bytes
  get("broken");
  EXPECT_EQ(last.broken, 3);
}

TEST_F(Download, BeginsAgainWhereItMust) {
  get("noranges");
  get("changing");  // another file each time: nothing of the earlier ones may stay
}

TEST_F(Download, WaitsForABusyServerAndFollowsRedirections) {
  get("busy");
  get("moved");
}

TEST_F(Download, GoesOnInALaterCall) {
  options_.progress = [](const DownloadProgress& state) { return state.done < 150'000; };
  EXPECT_EQ(download_file(url("broken"), target(), options_), DownloadResult::stopped);
  const auto kept = fs::file_size(target() + ".partial");
  EXPECT_GE(kept, 100'000U);
  EXPECT_FALSE(fs::exists(target()));
  std::uint64_t first = 0;
  options_.progress = [&](const DownloadProgress& state) {
    if (first == 0) first = state.done;
    return true;
  };
  get("broken");
  EXPECT_EQ(first, kept);
}

TEST_F(Download, ADoneButUnrenamedPartIsRecognised) {
  write_text(target() + ".partial", content_);
  write_text(target() + ".partial.version", "\"1\"\n");
  get("good");
}

TEST_F(Download, DoesNotTrustAPartOfUnknownOrigin) {
  write_text(target() + ".partial", "something else");
  get("good");
  write_text(target() + ".partial", "something else");
  write_text(target() + ".partial.version", "\"another\"\n");
  get("good");
}

TEST_F(Download, SaysWhatTheServerRefuses) {
  EXPECT_THAT(error_of([&] { download_file(url("good", "nothing"), target(), options_); }),
              AllOf(HasSubstr("404 (not found)"), HasSubstr("--mirror")));
  EXPECT_FALSE(fs::exists(target() + ".partial"));
  EXPECT_THAT(error_of([&] { download_file("ftp://127.0.0.1/x", target(), options_); }),
              HasSubstr("ftp://127.0.0.1/x"));
}

TEST_F(Download, GivesUpOnALengthThatNeverComes) {
  options_.attempts = 3;
  EXPECT_THAT(error_of([&] { download_file(url("short"), target(), options_); }),
              AllOf(HasSubstr("broke off"), HasSubstr("350000 bytes have come"), HasSubstr("try again")));
  EXPECT_FALSE(fs::exists(target()));
  fs::remove(target() + ".partial");
  EXPECT_THAT(error_of([&] { download_file(url("deaf"), target(), options_); }), HasSubstr("broke off"));
  EXPECT_FALSE(fs::exists(target()));
}

TEST_F(Download, ChecksTheChecksum) {
  // printf abc | sha256sum
  write_text(folder_ / "served/abc", "abc");
  options_.sha256 = "BA7816BF8F01CFEA414140DE5DAE2223B00361A396177A9CB410FF61F20015AD";
  EXPECT_EQ(download_file(url("good", "abc"), target(), options_), DownloadResult::complete);
  EXPECT_EQ(sha256_of(target()), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  fs::remove(target());
  EXPECT_THAT(error_of([&] { download_file(url("good"), target(), options_); }), HasSubstr("checksum"));
  EXPECT_FALSE(fs::exists(target()));
  EXPECT_FALSE(fs::exists(target() + ".partial"));
}

class Unpack : public testing::Test {
 protected:
  void make(const std::string& arguments) {
    const std::string command = "cd '" + folder_.path().string() + "' && tar " + arguments;
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }
  TempFolder folder_;
};

TEST_F(Unpack, LeavesOutASingleTopFolder) {
  write_text(folder_ / "a/top/depth/1.png", "one");
  write_text(folder_ / "a/top/depth.txt", "two");
  make("czf nested.tgz -C a top");
  make("czf flat.tgz -C a/top .");
  for (const char* name : {"nested", "flat"}) {
    unpack_archive(folder_ / (std::string(name) + ".tgz"), folder_ / name, {});
    EXPECT_EQ(read_text(folder_ / (std::string(name) + "/depth/1.png")), "one");
    EXPECT_EQ(read_text(folder_ / (std::string(name) + "/depth.txt")), "two");
    EXPECT_FALSE(fs::exists(folder_ / (std::string(name) + ".partial")));
  }
  EXPECT_THAT(error_of([&] { unpack_archive(folder_ / "flat.tgz", folder_ / "flat", {}); }),
              HasSubstr("there already"));
}

TEST_F(Unpack, LeavesNothingOfADamagedArchive) {
  write_text(folder_ / "a/x", std::string(100'000, 'x'));
  write_text(folder_ / "evil", "out of here");
  make("czf good.tgz a");
  const std::string bytes = read_text(folder_ / "good.tgz");
  write_text(folder_ / "bad.tgz", bytes.substr(0, bytes.size() / 2));
  EXPECT_THAT(error_of([&] { unpack_archive(folder_ / "bad.tgz", folder_ / "bad", {}); }),
              HasSubstr("cannot be unpacked"));
  make("czPf evil.tgz --transform 's,^,../,' evil");
  EXPECT_THAT(error_of([&] { unpack_archive(folder_ / "evil.tgz", folder_ / "deep", {}); }),
              HasSubstr("points out of the folder"));
  EXPECT_THAT(error_of([&] { unpack_archive(folder_ / "good.tgz", folder_ / "stop", [] { return false; }); }),
              HasSubstr("stopped"));
  for (const char* name : {"bad", "deep", "stop", "bad.partial", "deep.partial", "stop.partial"})
    EXPECT_FALSE(fs::exists(folder_ / name)) << name;
}

TEST(Datasets, AreFoundByName) {
  EXPECT_EQ(find_dataset("fr1/xyz").url,
            "https://cvg.cit.tum.de/rgbd/dataset/freiburg1/rgbd_dataset_freiburg1_xyz.tgz");
  EXPECT_EQ(find_dataset("rgbd_dataset_freiburg2_desk").name, "fr2/desk");
  EXPECT_EQ(find_dataset("Freiburg3/teddy").name, "fr3/teddy");
  EXPECT_THAT(find_dataset("icl/office_kt3").url, HasSubstr("/traj3_frei_png.tar.gz"));
  EXPECT_THAT(error_of([] { find_dataset("fr1/des"); }), HasSubstr("perhaps you mean fr1/desk, fr1/desk2"));
  EXPECT_THAT(error_of([] { find_dataset("x"); }), HasSubstr("--list"));
}

}  // namespace
}  // namespace plumbline
