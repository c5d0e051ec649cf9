// A chip on one of Linux's I2C adapters.
#pragma once

#include <linux/i2c.h>

#include <functional>
#include <string>
#include <vector>

#include "capture/register_bus.h"
#include "plumbline/time.h"

namespace plumbline::capture {

/// Registers through combined transfers (I2C_RDWR): one for the address and one for the data, without a stop between.
class I2cBus : public RegisterBus {
 public:
  /// Hands the messages to the adapter; 0, or an errno.
  using Transfer = std::function<int(std::vector<i2c_msg>& messages)>;

  /// Opens the adapter. `address` is the chip's, 7 bits. Throws Disconnected if it cannot be opened or knows no
  /// combined transfers.
  I2cBus(const std::string& path, std::uint16_t address);
  /// On a transfer from elsewhere.
  I2cBus(std::string name, std::uint16_t address, Transfer transfer);

  std::vector<std::uint8_t> read(std::uint8_t first, std::size_t count, Nanoseconds* time) override;
  void write(std::uint8_t first, const std::vector<std::uint8_t>& values) override;
  void write_unanswered(std::uint8_t address, std::uint8_t value) override;

 private:
  void transfer(const char* what, std::uint8_t first, std::vector<i2c_msg> messages);

  std::uint16_t address_;
  Transfer transfer_;
};

}  // namespace plumbline::capture
