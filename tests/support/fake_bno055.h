// A BNO055 on a pseudo-terminal: the chip's registers and its UART protocol, and all that goes wrong with them.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "plumbline/time.h"

namespace plumbline::test {

/// Turns about the vertical at `kFakeRate`, so that each quaternion tells when it was taken.
constexpr double kFakeRate = 0.5;  // rad/s

class FakeBno055 {
 public:
  explicit FakeBno055(const std::filesystem::path& folder);
  ~FakeBno055();
  FakeBno055(const FakeBno055&) = delete;
  FakeBno055& operator=(const FakeBno055&) = delete;

  /// A link to the pseudo-terminal, the same after it was plugged in again.
  std::string port() const { return port_.string(); }
  std::string connection() const { return "serial:" + port(); }

  // Shares of the answers, 0…1.
  std::atomic<double> overruns = 0;    ///< EE 07 in their place
  std::atomic<double> lost_bytes = 0;  ///< without one of their bytes
  std::atomic<double> garbage = 0;     ///< with up to 8 arbitrary bytes before them
  std::atomic<bool> silent = false;    ///< no answers at all
  std::atomic<std::uint8_t> chip_id = 0xA0;
  std::atomic<std::uint8_t> calibration_status = 0x00;

  void unplug();
  void plug_in();
  /// The supply breaks down for a moment: the chip boots, all that it knew is gone.
  void brown_out();

  int resets() const { return resets_; }
  /// While the chip changed its mode.
  int requests_while_deaf() const { return requests_while_deaf_; }
  std::array<std::uint8_t, 22> calibration() const;
  void set_calibration(const std::array<std::uint8_t, 22>& bytes);
  std::uint8_t mode() const;

 private:
  void serve();
  void handle(std::uint8_t byte);
  void answer_read(std::uint8_t first, std::uint8_t count);
  void answer_write(std::uint8_t first, const std::vector<std::uint8_t>& values);
  void set_register(std::uint8_t address, std::uint8_t value);
  void measure();
  void power_on();
  void send(std::vector<std::uint8_t> bytes);
  bool happens(double share);
  bool is_deaf();

  std::filesystem::path port_;
  int master_ = -1, slave_ = -1;
  std::vector<std::uint8_t> request_;
  std::mt19937 random_{1};

  mutable std::mutex mutex_;
  std::array<std::uint8_t, 128> registers_{};
  Nanoseconds boots_until_ = 0, deaf_until_ = 0;
  std::atomic<int> resets_ = 0, requests_while_deaf_ = 0;
  std::atomic<bool> stopping_ = false;
  std::thread thread_;
};

}  // namespace plumbline::test
