#include "plumbline/image.h"
#include "core/plane.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace plumbline {
namespace {

TEST(Plane, RowsArePaddedWithZerosOnBothSides) {
  for (const int width : {1, 15, 16, 17, 640}) {
    const Plane<float> plane(width, 3, allocate_host);
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
  const Plane<float> plane(33, 5, allocate_host);
  for (int y = 0; y < 5; ++y) EXPECT_EQ(reinterpret_cast<std::uintptr_t>(plane.view().row(y)) % 64, 0u);
}

TEST(Plane, DefaultIsEmptyAndNull) {
  EXPECT_TRUE(Plane<float>().empty());
  EXPECT_FALSE(Plane<float>(2, 2, allocate_host).empty());
  EXPECT_TRUE(PlaneView<float>().is_null());
}

TEST(Plane, MemoryLivesAsLongAsTheLastCopy) {
  Plane<std::uint16_t> kept;
  {
    const Plane<std::uint16_t> plane(4, 4, allocate_host);
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

TEST(AllocateHost, ImpossibleSizesThrow) { EXPECT_THROW(allocate_host(std::size_t{1} << 60), std::bad_alloc); }

}  // namespace
}  // namespace plumbline
