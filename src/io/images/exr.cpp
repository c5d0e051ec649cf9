#include "io/images/exr.h"

#include <fmt/format.h>

#include "io/images/image_size.h"
#include "plumbline/error.h"

#ifdef PLUMBLINE_OPENEXR
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfPartType.h>

#include <cstring>
#include <exception>
#endif

namespace plumbline {

bool is_exr(std::string_view bytes) { return bytes.starts_with("\x76\x2f\x31\x01"); }

#ifdef PLUMBLINE_OPENEXR
namespace {

constexpr const char* kExrAdvice = "copy or export the file again, or give depth as 16-bit PNG files";

class MemoryStream : public Imf::IStream {
 public:
  MemoryStream(std::string_view bytes, const std::string& name) : IStream(name.c_str()), bytes_(bytes) {}

  bool read(char out[], int n) override {
    if (n < 0 || static_cast<std::size_t>(n) > bytes_.size() - at_) throw std::runtime_error("it ends early");
    std::memcpy(out, bytes_.data() + at_, static_cast<std::size_t>(n));
    at_ += static_cast<std::size_t>(n);
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t position) override {
    if (position > bytes_.size()) throw std::runtime_error("it ends early");
    at_ = static_cast<std::size_t>(position);
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

/// The name of the channel that holds depth.
std::string depth_channel(const Imf::ChannelList& channels) {
  for (const char* name : {"Z", "D", "depth", "Depth", "Y", "R"})
    if (channels.findChannel(name) != nullptr) return name;
  return channels.begin() == channels.end() ? "" : channels.begin().name();
}

ImageHeader header_of(const Imf::Header& header, const std::string& name) {
  const auto& window = header.dataWindow();
  const auto width = static_cast<long long>(window.max.x) - window.min.x + 1;
  const auto height = static_cast<long long>(window.max.y) - window.min.y + 1;
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide)
    throw Error(fmt::format("is an EXR of {}x{} pixels", width, height), name, kExrAdvice);
  if (header.hasType() && header.type() != Imf::SCANLINEIMAGE)
    throw Error("is an EXR of a kind that is not read (in tiles, or deep)", name, kExrAdvice);
  const std::string channel = depth_channel(header.channels());
  if (channel.empty()) throw Error("is an EXR without a channel", name, kExrAdvice);
  const Imf::Channel& found = header.channels()[channel.c_str()];
  if (found.xSampling != 1 || found.ySampling != 1)
    throw Error("is an EXR whose depth has fewer samples than pixels", name, kExrAdvice);
  const int bits = found.type == Imf::HALF ? 16 : 32;
  return {static_cast<int>(width),
          static_cast<int>(height),
          bits,
          fmt::format("EXR of real numbers, channel {}", channel),
          true,
          true};
}

/// What the library throws, in our words.
template <class Read>
auto guarded(const std::string& name, Read&& read) {
  try {
    return read();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(fmt::format("is a damaged EXR ({})", error.what()), name, kExrAdvice);
  }
}

}  // namespace

ImageHeader read_exr_header(std::string_view bytes, const std::string& name) {
  return guarded(name, [&] {
    MemoryStream stream(bytes, name);
    const Imf::InputFile file(stream, 0);
    return header_of(file.header(), name);
  });
}

Image<float> decode_depth_exr(std::string_view bytes, const std::string& name) {
  return guarded(name, [&] {
    MemoryStream stream(bytes, name);
    Imf::InputFile file(stream, 0);
    const ImageHeader header = header_of(file.header(), name);
    Image<float> depth(header.width, header.height);
    const auto& window = file.header().dataWindow();
    const auto row = static_cast<std::ptrdiff_t>(header.width);
    // The library counts from the pixel (0, 0), which need not lie within the window.
    char* origin = reinterpret_cast<char*>(depth.pixels.data()) -
                   static_cast<std::ptrdiff_t>(sizeof(float)) * (window.min.x + row * window.min.y);
    Imf::FrameBuffer buffer;
    buffer.insert(depth_channel(file.header().channels()).c_str(),
                  Imf::Slice(Imf::FLOAT, origin, sizeof(float), sizeof(float) * static_cast<std::size_t>(row)));
    file.setFrameBuffer(buffer);
    file.readPixels(window.min.y, window.max.y);
    return depth;
  });
}

#else

namespace {
[[noreturn]] void refuse(const std::string& name) {
  throw Error("is an EXR, which this program was built without (OpenEXR)", name,
              "give depth as 16-bit PNG, TIFF or NPY, or install libopenexr-dev and build again");
}
}  // namespace

ImageHeader read_exr_header(std::string_view, const std::string& name) { refuse(name); }
Image<float> decode_depth_exr(std::string_view, const std::string& name) { refuse(name); }

#endif

}  // namespace plumbline
