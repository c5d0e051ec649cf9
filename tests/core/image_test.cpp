#include "plumbline/image.h"
#include "core/plane.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace plumbline {
namespace {

TEST(Plane, RowsArePaddedWithZerosOnBothSides) {
  for (const int width : {1, 15, 16, 17, 640}) {
    const Plane<float> plane(width, 3, HostMemory());
    const PlaneView<float> view = plane.view();
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < width; ++x) view.row(y)[x] = 1.0f;
    }
    for (int y = 0; y < 3; ++y) {
      for (int i = 1; i <= Plane<float>::kPadding; ++i) {
        EXPECT_EQ(view.row(y)[-i], 0.0f);
        EXPECT_EQ(view.row(y)[width - 1 + i], 0.0f);
      }
    }
  }
}

TEST(Plane, RowsStartOnALanesBoundary) {
  const Plane<float> plane(33, 5, HostMemory());
  for (int y = 0; y < 5; ++y) EXPECT_EQ(reinterpret_cast<std::uintptr_t>(plane.view().row(y)) % 64, 0u);
}

TEST(Plane, DefaultIsEmptyAndNull) {
  EXPECT_TRUE(Plane<float>().empty());
  EXPECT_FALSE(Plane<float>(2, 2, HostMemory()).empty());
  EXPECT_TRUE(PlaneView<float>().is_null());
}

TEST(Plane, MemoryLivesAsLongAsTheLastCopy) {
  Plane<std::uint16_t> kept;
  {
    const Plane<std::uint16_t> plane(4, 4, HostMemory());
    plane.view().row(3)[3] = 7;
    kept = plane;
  }
  EXPECT_EQ(kept.view().row(3)[3], 7);
}

TEST(Image, ChannelsAreInterleaved) {
  ColorImage image(3, 2, 3);
  image.at(2, 1, 1) = 9;
  EXPECT_EQ(image.pixels[(1 * 3 + 2) * 3 + 1], 9);
  EXPECT_EQ(image.row(1)[2 * 3 + 1], 9);
  EXPECT_TRUE(DepthImage().empty());
}

TEST(HostMemory, ImpossibleSizesThrow) { EXPECT_THROW(HostMemory().allocate(std::size_t{1} << 60), std::bad_alloc); }

TEST(DeviceArray, HoldsZerosOrACopyOfTheHostsValues) {
  const HostMemory memory;
  const DeviceArray<float> zeros(memory, 1000);
  EXPECT_EQ(zeros.size(), 1000u);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(zeros.data()) % 64, 0u);
  EXPECT_EQ(zeros.download(memory), std::vector<float>(1000));
  std::vector<std::int32_t> values{3, 1, 4, 1, 5};
  const DeviceArray<std::int32_t> copy(memory, values);
  const std::vector<std::int32_t> before = values;
  values[0] = 9;
  EXPECT_EQ(copy.download(memory), before);
  EXPECT_EQ(copy.download(memory, 2), (std::vector<std::int32_t>{3, 1}));
  EXPECT_EQ(copy.parts<std::uint8_t>()[4], 1);
  copy.clear(memory);
  EXPECT_EQ(copy.download(memory), std::vector<std::int32_t>(5));
}

TEST(DeviceArray, AnEmptyOneHasNoMemory) {
  const HostMemory memory;
  const DeviceArray<int> empty(memory, 0);
  EXPECT_TRUE(empty.empty());
  EXPECT_EQ(empty.data(), nullptr);
  EXPECT_TRUE(empty.download(memory).empty());
  empty.clear(memory);
}

}  // namespace
}  // namespace plumbline
