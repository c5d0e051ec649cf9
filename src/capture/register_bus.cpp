#include "capture/register_bus.h"

#include <charconv>

#include "capture/i2c_bus.h"
#include "capture/serial_bus.h"

namespace plumbline::capture {
namespace {

constexpr std::uint16_t kFirstAddress = 0x28;

/// "/dev/i2c-1:0x29".
std::unique_ptr<RegisterBus> open_i2c(const std::string& text) {
  const std::size_t colon = text.rfind(":0x");
  std::uint16_t address = kFirstAddress;
  if (colon != std::string::npos) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + colon + 3, end, address, 16);
    if (error != std::errc() || stop != end || address < 0x08 || address > 0x77)
      throw Error("is no 7-bit address", text.substr(colon + 1), "give 0x28 or 0x29, as in i2c:/dev/i2c-1:0x29");
  }
  return std::make_unique<I2cBus>(text.substr(0, colon), address);
}

}  // namespace

std::unique_ptr<RegisterBus> open_bus(const std::string& description) {
  const std::size_t colon = description.find(':');
  const std::string kind = description.substr(0, colon);
  const std::string rest = colon == std::string::npos ? "" : description.substr(colon + 1);
  if (kind == "serial" && !rest.empty()) return std::make_unique<SerialBus>(rest);
  if (kind == "i2c" && !rest.empty()) return open_i2c(rest);
  throw Error("is no connection of a sensor", "'" + description + "'",
              "give serial:/dev/ttyUSB0, i2c:/dev/i2c-1, i2c:/dev/i2c-1:0x29, or none");
}

}  // namespace plumbline::capture
