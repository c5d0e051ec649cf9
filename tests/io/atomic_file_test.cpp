#include "io/atomic_file.h"

#include <gmock/gmock.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "io/images/png.h"
#include "plumbline/image.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::read_text;
using test::TempFolder;
using testing::HasSubstr;

namespace fs = std::filesystem;

void write_whole(const std::string& path, std::string_view text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

TEST(AtomicFile, AppearsOnlyWithCommit) {
  const TempFolder folder;
  const std::string path = folder / "out.txt";
  AtomicFile file(path);
  file.write("hello ");
  file.write("world");
  EXPECT_FALSE(fs::exists(path));
  file.commit();
  EXPECT_EQ(read_text(path), "hello world");
  EXPECT_FALSE(fs::exists(path + ".partial"));
  EXPECT_THROW(file.commit(), Error);
}

TEST(AtomicFile, WithoutCommitTheOldFileStays) {
  const TempFolder folder;
  const std::string path = folder / "out.txt";
  write_whole(path, "old");
  {
    AtomicFile file(path);
    file.write(std::string(3 << 20, 'x'));  // more than the buffer, so bytes have left it
    EXPECT_TRUE(fs::exists(path + ".partial"));
  }
  EXPECT_EQ(read_text(path), "old");
  EXPECT_FALSE(fs::exists(path + ".partial"));
}

TEST(AtomicFile, LargeAndSmallWritesKeepTheirOrder) {
  const TempFolder folder;
  std::string expected;
  AtomicFile file(folder / "out");
  for (int i = 0; i < 200; ++i) {
    const std::string piece(static_cast<std::size_t>((i * 7919) % 50000) * (i % 40 == 39 ? 40 : 1),
                            static_cast<char>('a' + i % 26));
    file.write(piece);
    expected += piece;
  }
  file.commit();
  EXPECT_TRUE(read_text(folder / "out") == expected);
}

TEST(AtomicFile, FollowsALinkAndKeepsTheMode) {
  const TempFolder folder;
  write_whole(folder / "real", "old");
  chmod((folder / "real").c_str(), 0640);
  fs::create_symlink("real", folder / "link");
  write_whole(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(read_text(folder / "real"), "new");
  struct stat status {};
  ASSERT_EQ(stat((folder / "real").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(AtomicFile, SaysWhatIsWrongWithThePath) {
  const TempFolder folder;
  EXPECT_THAT(error_of([&] { AtomicFile file(folder / "no/such/file"); }), HasSubstr("create the folder"));
  EXPECT_THAT(error_of([&] { AtomicFile file(folder.path().string()); }), HasSubstr("is a folder"));
}

TEST(AtomicFile, FullDeviceIsAnError) {
  AtomicFile file("/dev/full");
  file.write("something");
  EXPECT_THAT(error_of([&] { file.commit(); }), HasSubstr("no space left"));
  EXPECT_FALSE(fs::exists("/dev/full.partial"));
}

TEST(AtomicFile, WritesIntoAPipe) {
  const TempFolder folder;
  const std::string pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] { received = read_text(pipe); });
  write_whole(pipe, "through");
  reader.join();
  EXPECT_EQ(received, "through");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

/// A file system of one megabyte, or `is_mounted()` false where that needs rights the test does not have.
class SmallDisk {
 public:
  SmallDisk(const std::string& path, unsigned long flags) : path_(path) {
    fs::create_directories(path);
    mounted_ = mount("none", path.c_str(), "tmpfs", flags, "size=1m") == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount(path_.c_str());
  }
  bool is_mounted() const { return mounted_; }

 private:
  std::string path_;
  bool mounted_ = false;
};

TEST(AtomicFile, FullDiskKeepsTheOldFile) {
  const TempFolder folder;
  const SmallDisk disk(folder / "disk", 0);
  if (!disk.is_mounted()) GTEST_SKIP() << "mounting needs root";
  const std::string path = folder / "disk/depth.png";
  write_depth_png(path, DepthImage(16, 16));
  const std::string old = read_text(path);
  DepthImage noise(1024, 1024);
  std::uint32_t state = 1;
  for (std::uint16_t& v : noise.pixels) v = static_cast<std::uint16_t>((state = state * 1664525 + 1013904223) >> 16);
  EXPECT_THAT(error_of([&] { write_depth_png(path, noise); }), HasSubstr("no space left"));
  EXPECT_TRUE(read_text(path) == old);
  EXPECT_FALSE(fs::exists(path + ".partial"));
}

TEST(AtomicFile, LimitOnFileSizesKeepsTheOldFile) {
  const TempFolder folder;
  const std::string path = folder / "out";
  write_whole(path, "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100000, before.rlim_max};
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = error_of([&] { write_whole(path, std::string(3 << 20, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(error, HasSubstr("limit on file sizes"));
  EXPECT_EQ(read_text(path), "old");
  EXPECT_FALSE(fs::exists(path + ".partial"));
}

TEST(EnsureDirectory, MakesFoldersAndRefusesFiles) {
  const TempFolder folder;
  ensure_directory(folder / "a/b/c");
  EXPECT_TRUE(fs::is_directory(folder / "a/b/c"));
  ensure_directory(folder / "a/b/c");
  ensure_directory(folder / "a/slash/");
  EXPECT_TRUE(fs::is_directory(folder / "a/slash"));
  write_whole(folder / "file", "x");
  EXPECT_THAT(error_of([&] { ensure_directory(folder / "file"); }), HasSubstr("is a file"));
  EXPECT_THAT(error_of([&] { ensure_directory(folder / "file/under"); }), HasSubstr("cannot be made"));
}

TEST(EnsureDirectory, RefusesWhatCannotBeWrittenTo) {
  const TempFolder folder;
  const SmallDisk disk(folder / "disk", MS_RDONLY);
  if (!disk.is_mounted()) GTEST_SKIP() << "mounting needs root";
  EXPECT_THAT(error_of([&] { ensure_directory(folder / "disk"); }), HasSubstr("cannot be written to"));
  EXPECT_THAT(error_of([&] { ensure_directory(folder / "disk/new"); }), HasSubstr("Read-only"));
  EXPECT_THAT(error_of([&] { AtomicFile file(folder / "disk/new"); }), HasSubstr("may write to"));
}

}  // namespace
}  // namespace plumbline
