// A chip as a row of 8-bit registers, whatever wire it hangs on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/error.h"
#include "plumbline/time.h"

namespace plumbline::capture {

/// The chip did not answer, or not with what was asked for; the next try may succeed.
class BusError : public Error {
 public:
  using Error::Error;
};

/// The wire itself is gone: unplugged, or never there. It has to be opened again.
class Disconnected : public Error {
 public:
  using Error::Error;
};

/// What a wire went through so far.
struct BusCounters {
  std::uint64_t requests = 0;
  std::uint64_t overruns = 0;  ///< the chip was too busy to answer (0x07), and was asked again
  std::uint64_t repeats = 0;   ///< silence or garbage, and asked again
};

/// Not thread-safe.
class RegisterBus {
 public:
  virtual ~RegisterBus() = default;

  /// Reads `count` registers (1…128) from `first` on in one request. `time`, where given, gets when the chip read them
  /// out (monotonic). Throws BusError after a few tries, Disconnected.
  virtual std::vector<std::uint8_t> read(std::uint8_t first, std::size_t count, Nanoseconds* time = nullptr) = 0;

  /// Writes registers from `first` on. Throws BusError after a few tries, Disconnected.
  virtual void write(std::uint8_t first, const std::vector<std::uint8_t>& values) = 0;

  /// Writes one register and expects no answer: a reset. Throws Disconnected.
  virtual void write_unanswered(std::uint8_t address, std::uint8_t value) = 0;

  const BusCounters& counters() const { return counters_; }
  /// "/dev/ttyUSB0".
  const std::string& name() const { return name_; }

 protected:
  explicit RegisterBus(std::string name) : name_(std::move(name)) {}

  BusCounters counters_;

 private:
  std::string name_;
};

/// `serial:/dev/ttyUSB0` or `i2c:/dev/i2c-1`, the latter with `:0x29` where the chip has its second address. Throws
/// Error for another form, Disconnected if it cannot be opened.
std::unique_ptr<RegisterBus> open_bus(const std::string& description);

}  // namespace plumbline::capture
