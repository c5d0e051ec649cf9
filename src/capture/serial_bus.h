// The register protocol of the BNO055's UART (data sheet BST-BNO055-DS000, section 4.7; application note AN012).
#pragma once

#include <string>
#include <string_view>

#include "capture/register_bus.h"
#include "plumbline/time.h"

namespace plumbline::capture {

/// A serial line at 115200 baud, 8 bits, no parity, one stop bit.
///
///     write  AA 00 reg n data…   answered by EE 01, or EE and an error
///     read   AA 01 reg n         answered by BB n data…, or EE and an error
///
/// The chip answers EE 07 (bus over-run) whenever a request meets it while it is busy with its own sensors: asked
/// again, it answers. Lost bytes end in silence or in a wrong length; then the line is left to run dry, and asked
/// again.
class SerialBus : public RegisterBus {
 public:
  /// Throws Disconnected if the port cannot be opened or is no serial line.
  explicit SerialBus(const std::string& path);
  ~SerialBus() override;
  SerialBus(const SerialBus&) = delete;
  SerialBus& operator=(const SerialBus&) = delete;

  std::vector<std::uint8_t> read(std::uint8_t first, std::size_t count, Nanoseconds* time) override;
  void write(std::uint8_t first, const std::vector<std::uint8_t>& values) override;
  void write_unanswered(std::uint8_t address, std::uint8_t value) override;

 private:
  enum class Answer { good, overrun, refused, none };

  void configure();
  void send(const std::vector<std::uint8_t>& bytes);
  /// Waits for exactly `count` bytes; fewer after the time is up.
  std::vector<std::uint8_t> receive(std::size_t count, Nanoseconds deadline, Nanoseconds* first_byte);
  Answer read_once(std::uint8_t first, std::size_t count, std::vector<std::uint8_t>* values, Nanoseconds* time);
  Answer write_once(std::uint8_t first, const std::vector<std::uint8_t>& values);
  template <class Request>
  void repeat(const char* what, std::uint8_t first, Request&& request);
  void run_dry();
  void throw_away_input();
  [[noreturn]] void fail(const char* doing, int error) const;

  int fd_ = -1;
  int refusal_ = 0;  // the latest error code of the chip
};

/// In words: "bus over-run".
std::string_view bno055_status(int code);

}  // namespace plumbline::capture
