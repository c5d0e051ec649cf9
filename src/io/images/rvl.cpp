#include "io/images/rvl.h"

#include <algorithm>
#include <cstring>

#include "plumbline/error.h"

namespace plumbline {
namespace {

/// Numbers of variable length: nibbles of three bits, the lowest first, whose upper bit says that more follow. Eight
/// nibbles stand in a 32-bit word, the first in its upper bits.
class Nibbles {
 public:
  Nibbles(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  std::uint32_t take_number() {
    std::uint32_t value = 0, nibble = 0;
    int bits = 0;
    do {
      nibble = take();
      if (bits > 30) fail();
      value |= (nibble & 7) << bits;
      bits += 3;
    } while ((nibble & 8) != 0);
    return value;
  }
  [[noreturn]] void fail() const { throw Error("the RVL depth is cut off or damaged", name_, "copy the file again"); }

 private:
  std::uint32_t take() {
    if (left_ == 0) {
      if (bytes_.size() < sizeof word_) fail();
      std::memcpy(&word_, bytes_.data(), sizeof word_);
      bytes_.remove_prefix(sizeof word_);
      left_ = 8;
    }
    const std::uint32_t nibble = word_ >> 28;
    word_ <<= 4;
    --left_;
    return nibble;
  }

  std::string_view bytes_;
  const std::string& name_;
  std::uint32_t word_ = 0;
  int left_ = 0;
};

}  // namespace

std::vector<std::uint16_t> decode_rvl(std::string_view bytes, std::size_t count, const std::string& name) {
  Nibbles nibbles(bytes, name);
  std::vector<std::uint16_t> readings(count);
  std::size_t at = 0;
  std::int32_t previous = 0;
  while (at < count) {
    const std::uint32_t zeros = nibbles.take_number(), values = nibbles.take_number();
    if (zeros > count - at || values > count - at - zeros || zeros + values == 0) nibbles.fail();
    at += zeros;
    for (std::uint32_t i = 0; i < values; ++i) {
      const std::uint32_t folded = nibbles.take_number();  // 0, −1, 1, −2, …
      previous += static_cast<std::int32_t>(folded >> 1) ^ -static_cast<std::int32_t>(folded & 1);
      if (previous < 0 || previous > 65535) nibbles.fail();
      readings[at++] = static_cast<std::uint16_t>(previous);
    }
  }
  return readings;
}

}  // namespace plumbline
