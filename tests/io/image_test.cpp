#include <gmock/gmock.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>

#include "io/images/image_file.h"
#include "io/images/jpeg.h"
#include "io/images/png.h"
#include "io/png_samples.h"
#include "plumbline/image.h"
#include "support/data.h"
#include "support/error_of.h"
#include "support/temp_folder.h"

namespace plumbline {
namespace {

using test::error_of;
using test::read_text;
using test::TempFolder;
using test::write_text;
using testing::ElementsAre;
using testing::HasSubstr;

DepthImage ramp(int width, int height) {
  DepthImage depth(width, height);
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) depth.pixels[i] = static_cast<std::uint16_t>(i * 257 + 3);
  return depth;
}

std::string make_jpeg(int width, int height, std::uint8_t r, std::uint8_t g, std::uint8_t b) {
  std::vector<unsigned char> pixels;
  for (int i = 0; i < width * height; ++i) pixels.insert(pixels.end(), {r, g, b});
  const tjhandle handle = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  tjCompress2(handle, pixels.data(), width, 0, height, TJPF_RGB, &bytes, &size, TJSAMP_444, 95, 0);
  std::string result(reinterpret_cast<char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(handle);
  return result;
}

TEST(Png, ReadsBigEndianDepth) {
  for (const std::string_view file : {test::kDepth16, test::kDepth16Interlaced}) {
    const DepthImage depth = decode_depth_png(file, "sample");
    EXPECT_EQ(depth.width, 3);
    EXPECT_EQ(depth.height, 2);
    EXPECT_THAT(depth.pixels, ElementsAre(0, 1, 256, 5000, 65535, 40000));
  }
}

TEST(Png, ReadsEveryKindOfColor) {
  for (const std::string_view file : {test::kRgb8, test::kRgba8, test::kPalette, test::kRgb16}) {
    const ColorImage color = decode_color_png(file, "sample");
    EXPECT_EQ(color.channels, 3);
    EXPECT_THAT(color.pixels, ElementsAre(10, 20, 30, 200, 100, 50));
  }
  for (const std::string_view file : {test::kGrey8, test::kGreyAlpha8})
    EXPECT_THAT(decode_color_png(file, "sample").pixels, ElementsAre(7, 7, 7, 250, 250, 250));
  EXPECT_THAT(decode_color_png(test::kGrey1, "sample").pixels, ElementsAre(0, 0, 0, 255, 255, 255));
}

TEST(Png, HeaderTellsTheKind) {
  const ImageHeader depth = read_png_header(test::kDepth16, "sample");
  EXPECT_TRUE(depth.is_depth);
  EXPECT_EQ(depth.width, 3);
  EXPECT_EQ(depth.height, 2);
  EXPECT_EQ(depth.description, "16-bit grey PNG");
  EXPECT_FALSE(read_png_header(test::kGrey8, "sample").is_depth);
  EXPECT_FALSE(read_png_header(test::kRgb16, "sample").is_depth);
}

TEST(Png, WrittenDepthReadsBack) {
  const TempFolder folder;
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1, 1}, std::pair{7, 3}}) {
    const DepthImage depth = ramp(width, height);
    write_depth_png(folder / "d.png", depth);
    EXPECT_TRUE(read_depth_image(folder / "d.png").pixels == depth.pixels);
  }
}

TEST(Png, WrittenColorReadsBack) {
  const TempFolder folder;
  ColorImage color(33, 21, 3);
  for (std::size_t i = 0; i < color.pixels.size(); ++i) color.pixels[i] = static_cast<std::uint8_t>(i * 31);
  write_color_png(folder / "c.png", color);
  EXPECT_TRUE(read_color_image(folder / "c.png").pixels == color.pixels);
  EXPECT_EQ(read_image_header(folder / "c.png").description, "8-bit RGB PNG");

  ColorImage grey(5, 4, 1);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) grey.pixels[i] = static_cast<std::uint8_t>(i * 11);
  write_color_png(folder / "g.png", grey);
  EXPECT_EQ(read_image_header(folder / "g.png").description, "8-bit grey PNG");
  const ColorImage back = read_color_image(folder / "g.png");
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) EXPECT_EQ(back.pixels[3 * i + 1], grey.pixels[i]);
}

TEST(Png, RefusesToWriteWhatIsNoImage) {
  const TempFolder folder;
  EXPECT_THROW(write_depth_png(folder / "d.png", DepthImage()), Error);
  EXPECT_THROW(write_color_png(folder / "c.png", ColorImage(2, 2, 2)), Error);
  ColorImage wrong(2, 2, 3);
  wrong.pixels.pop_back();
  EXPECT_THROW(write_color_png(folder / "c.png", wrong), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "c.png"));
}

TEST(Png, WrongKindIsAnErrorWithTheFilesName) {
  for (const std::string_view file : {test::kGrey8, test::kRgb8, test::kRgb16, test::kPalette})
    EXPECT_THAT(error_of([&] { decode_depth_png(file, "depth/7.png"); }),
                testing::AllOf(HasSubstr("depth/7.png"), HasSubstr("16-bit grey depth is expected")));
}

TEST(Png, EveryTruncationIsAnError) {
  const TempFolder folder;
  write_depth_png(folder / "d.png", ramp(64, 48));
  const std::string whole = read_text(folder / "d.png");
  const std::size_t end_of_data = whole.size() - 12 - 4;  // without IEND and the last checksum the pixels are whole
  for (std::size_t size = 0; size < end_of_data; size += 13)
    EXPECT_THROW(decode_depth_png(std::string_view(whole).substr(0, size), "cut"), Error) << size;
  EXPECT_NO_THROW(decode_depth_png(whole, "whole"));
}

TEST(Png, FlippedBitsAreFound) {
  const TempFolder folder;
  write_depth_png(folder / "d.png", ramp(64, 48));
  const std::string whole = read_text(folder / "d.png");
  for (std::size_t at = 60; at + 20 < whole.size(); at += 97) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    EXPECT_THROW(decode_depth_png(damaged, "damaged"), Error) << at;
  }
}

TEST(Png, ImpossibleSizeIsRefusedBeforeMemoryIsAsked) {
  EXPECT_THAT(error_of([] { decode_depth_png(test::kHuge16, "huge"); }), HasSubstr("16000x16000"));
}

TEST(Jpeg, ReadsColor) {
  const TempFolder folder;
  write_text(folder / "named.png", make_jpeg(40, 24, 200, 100, 50));  // told by its bytes, not by its name
  const ColorImage color = read_color_image(folder / "named.png");
  EXPECT_EQ(color.width, 40);
  EXPECT_EQ(color.height, 24);
  for (std::size_t i = 0; i < color.pixels.size(); i += 3) {
    EXPECT_NEAR(color.pixels[i], 200, 3);
    EXPECT_NEAR(color.pixels[i + 1], 100, 3);
    EXPECT_NEAR(color.pixels[i + 2], 50, 3);
  }
  EXPECT_EQ(read_image_header(folder / "named.png").description, "JPEG");
  EXPECT_THAT(error_of([&] { read_depth_image(folder / "named.png"); }), HasSubstr("is a JPEG"));
}

TEST(Jpeg, TruncationIsAnError) {
  const std::string whole = make_jpeg(64, 64, 1, 2, 3);
  for (std::size_t size = 4; size + 2 < whole.size(); size += 17)
    EXPECT_THROW(decode_jpeg(std::string_view(whole).substr(0, size), "cut"), Error) << size;
}

TEST(ImageFile, SaysWhatIsWrong) {
  const TempFolder folder;
  write_text(folder / "empty.png", "");
  write_text(folder / "text.png", "hello");
  EXPECT_THAT(error_of([&] { read_depth_image(folder / "empty.png"); }), HasSubstr("empty"));
  EXPECT_THAT(error_of([&] { read_depth_image(folder / "text.png"); }), HasSubstr("neither a PNG nor a JPEG"));
  EXPECT_THAT(error_of([&] { read_color_image(folder / "text.png"); }), HasSubstr("neither a PNG nor a JPEG"));
  EXPECT_THAT(error_of([&] { read_color_image(folder / "gone.png"); }), HasSubstr("No such file"));
  EXPECT_THAT(error_of([&] { read_image_header(folder.path().string()); }), HasSubstr("is a folder"));
}

TEST(ImageFile, RealDepthAndColor) {
  PLUMBLINE_DATA_OR_SKIP(folder, "icl_nuim/office_kt3");
  const DepthImage depth = read_depth_image((folder / "depth/1.png").string());
  EXPECT_EQ(depth.width, 640);
  EXPECT_EQ(depth.height, 480);
  const auto [low, high] = std::minmax_element(depth.pixels.begin(), depth.pixels.end());
  EXPECT_GT(*high, 5000);   // beyond a metre
  EXPECT_LT(*high, 50000);  // an office is less than ten metres: bytes in the wrong order would not be
  EXPECT_LT(*low, *high);
  const ColorImage color = read_color_image((folder / "rgb/1.jpg").string());
  EXPECT_EQ(color.width, 640);
  EXPECT_EQ(color.channels, 3);
}

}  // namespace
}  // namespace plumbline
