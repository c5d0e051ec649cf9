// ScanNet's .sens, made here as its SensorData.h writes version 4.
#include <gmock/gmock.h>
#include <turbojpeg.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/recording.h"
#include "plumbline/sequence.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::TempFolder;
using test::write_text;
using testing::Contains;
using testing::HasSubstr;

constexpr int kWidth = 32, kHeight = 24, kColorWidth = 64, kColorHeight = 48;

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

std::string matrix(float fx, float cx, float cy, float tx = 0) {
  const std::array<float, 16> m = {fx, 0, cx, tx, 0, fx, cy, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  return raw(m);
}

std::uint16_t reading(int frame, int i) { return static_cast<std::uint16_t>(i % 9 == 0 ? 0 : 1000 + i + 100 * frame); }

std::string depth_bytes(int frame, bool packed) {
  std::string bytes;
  for (int i = 0; i < kWidth * kHeight; ++i) bytes += raw(reading(frame, i));
  if (!packed) return bytes;
  std::string out(compressBound(bytes.size()), '\0');
  uLongf size = out.size();
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  out.resize(size);
  return out;
}

std::string jpeg(std::uint8_t value) {
  const std::vector<std::uint8_t> pixels(3 * kColorWidth * kColorHeight, value);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const tjhandle handle = tjInitCompress();
  tjCompress2(handle, pixels.data(), kColorWidth, 0, kColorHeight, TJPF_RGB, &bytes, &size, TJSAMP_444, 95, 0);
  std::string result(reinterpret_cast<char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(handle);
  return result;
}

struct Sample {
  std::uint32_t depth_packing = 1;
  bool stamps = true, lost = false;
};

std::string imu(std::uint64_t microseconds) {
  // Rotation rate, user acceleration (g), magnetic field, attitude, gravity (g): lying on its back.
  const std::array<double, 15> v = {0.1, 0.2, 0.3, 0, 0, 0.01, 1, 2, 3, 0, 0, 0, 0, 0, -1};
  return raw(v) + raw(microseconds);
}

std::string sens(const Sample& s = {}) {
  const std::string name = "StructureSensor";
  std::string bytes = raw(std::uint32_t{4}) + raw(std::uint64_t{name.size()}) + name;
  bytes += matrix(60, 31, 23) + matrix(1, 0, 0) + matrix(30, 15, 11) + matrix(1, 0, 0);
  bytes += raw(std::uint32_t{2}) + raw(s.depth_packing);
  for (const int side : {kColorWidth, kColorHeight, kWidth, kHeight}) bytes += raw(static_cast<std::uint32_t>(side));
  bytes += raw(1000.0f) + raw(std::uint64_t{3});
  for (int k = 0; k < 3; ++k) {
    const std::string color = jpeg(static_cast<std::uint8_t>(50 + 20 * k)),
                      depth = depth_bytes(k, s.depth_packing == 1);
    std::array<float, 16> lost;
    lost.fill(-std::numeric_limits<float>::infinity());
    bytes += s.lost && k == 1 ? raw(lost) : matrix(1, 0, 0, 0.5f * static_cast<float>(k));
    const std::uint64_t stamp = s.stamps ? 7'000'000 + 40'000 * static_cast<std::uint64_t>(k) : 0;
    bytes +=
        raw(stamp) + raw(stamp) + raw(std::uint64_t{color.size()}) + raw(std::uint64_t{depth.size()}) + color + depth;
  }
  bytes += raw(std::uint64_t{2}) + imu(7'000'000) + imu(7'010'000);
  return bytes;
}

TEST(Sens, DepthColourPosesAndImu) {
  for (const std::uint32_t packing : {0U, 1U}) {
    const TempFolder folder;
    write_text(folder / "scene0000_00.sens", sens({packing}));
    EXPECT_TRUE(holds_recording(folder / "scene0000_00.sens"));
    const auto sequence = open_sequence(folder / "scene0000_00.sens");
    EXPECT_EQ(sequence->info().format, "ScanNet .sens");
    EXPECT_EQ(sequence->info().camera, (Pinhole{30, 30, 15, 11, kWidth, kHeight}));
    EXPECT_EQ(sequence->info().depth_scale, 1000);
    EXPECT_FALSE(sequence->info().depth_scale_is_guess);
    EXPECT_EQ(sequence->info().color_frames, 3);
    ASSERT_EQ(sequence->size(), 3);
    EXPECT_EQ(sequence->time(2), 7'080'000'000);
    for (const int k : {2, 0, 1}) {
      const Frame frame = sequence->read(k);
      for (const int i : {0, 1, 400, kWidth * kHeight - 1})
        EXPECT_EQ(frame.depth.pixels[static_cast<std::size_t>(i)], reading(k, i));
      EXPECT_NEAR(frame.color.at(10, 10, 1), 50 + 20 * k, 2);
    }
    const Trajectory truth = sequence->read_groundtruth();
    ASSERT_EQ(truth.size(), 3U);
    EXPECT_EQ(truth[1].time, sequence->time(1));
    EXPECT_NEAR(truth[1].world_from_camera.translation().x(), 0.5, 1e-7);
    std::vector<std::string> notes;
    const ImuRecording imu = sequence->read_imu(&notes);
    ASSERT_EQ(imu.samples.size(), 2U);
    EXPECT_EQ(imu.samples[1].time, 7'010'000'000);
    EXPECT_NEAR(imu.samples[0].specific_force.z(), 0.99 * 9.80665, 1e-9) << "up, as at rest";
    EXPECT_THAT(notes, Contains(HasSubstr("CoreMotion")));
    EXPECT_FALSE(sequence->info().body_from_camera) << "nothing tells how the tablet's sensor sits on the camera";
  }
}

TEST(Sens, WithoutStampsAndWithLostFrames) {
  const TempFolder folder;
  write_text(folder / "a.sens", sens({.stamps = false, .lost = true}));
  const auto sequence = open_sequence(folder / "a.sens");
  EXPECT_EQ(sequence->time(1), 33'333'333);
  EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("1/30 s apart, a guess")));
  std::vector<std::string> notes;
  EXPECT_EQ(sequence->read_groundtruth(&notes).size(), 2U);
  EXPECT_THAT(notes, Contains(HasSubstr("1 poses that are not finite")));
}

TEST(Sens, CutOffOrDamaged) {
  const TempFolder folder;
  const std::string whole = sens();
  int opened = 0;
  for (std::size_t size = 20; size < whole.size(); size += 97) {
    write_text(folder / "cut.sens", whole.substr(0, size));
    try {
      const auto sequence = open_sequence(folder / "cut.sens");
      ++opened;
      if (sequence->size() < 3) {
        EXPECT_THAT(sequence->info().notes, Contains(HasSubstr("ends early")));
      }
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("cut.sens"));
    }
  }
  EXPECT_GT(opened, 2);
  std::string damaged = whole;
  damaged[damaged.size() - 300] = static_cast<char>(~damaged[damaged.size() - 300]);
  write_text(folder / "a.sens", damaged);
  EXPECT_THAT(error_of([&] { open_sequence(folder / "a.sens")->read(2); }), HasSubstr("depth of frame 2"));
  write_text(folder / "a.sens", sens({2}));
  EXPECT_THAT(error_of([&] { open_sequence(folder / "a.sens"); }), HasSubstr("SensReader"));
}

}  // namespace
}  // namespace plumbline
