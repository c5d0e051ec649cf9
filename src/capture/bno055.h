// Bosch BNO055: nine axes and their fusion in one chip (data sheet BST-BNO055-DS000).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "capture/imu_reading.h"
#include "capture/register_bus.h"

namespace plumbline::capture {

/// Offsets and radii of the three sensors: registers 0x55 to 0x6A.
using Bno055Calibration = std::array<std::uint8_t, 22>;

/// A text file with the 22 bytes in hexadecimal. Throws Error for anything else.
Bno055Calibration read_bno055_calibration(const std::string& path);
void write_bno055_calibration(const std::string& path, const Bno055Calibration& calibration);

struct Bno055Options {
  bool raw = true;  ///< gyroscope, accelerometer and magnetometer beside the orientation
  std::optional<Bno055Calibration> calibration = {};  ///< to begin with
};

/// One chip in its fusion mode NDOF. Orientation is read as a quaternion: the chip's Euler angles are wrong beyond some
/// tilt in some of its firmwares. Not thread-safe.
class Bno055 {
 public:
  /// Resets the chip, restores the calibration and starts the fusion; waits up to 2 s for a chip that boots. Throws
  /// BusError if no BNO055 answers, Disconnected.
  Bno055(std::unique_ptr<RegisterBus> bus, const Bno055Options& options);

  /// The chip's present registers, all from one request. Empty while it has no orientation: for a moment after its
  /// start, and for readings that are no unit quaternion. A chip that has restarted on its own (its supply broke down
  /// for a moment) is set up again. Throws BusError, Disconnected.
  std::optional<ImuReading> read();

  /// Interrupts the fusion for some 30 ms, and the chip finds its heading anew: for the end of a recording. Throws
  /// BusError, Disconnected.
  Bno055Calibration read_calibration();

  /// Firmware's revision, "3.17".
  const std::string& firmware() const { return firmware_; }
  /// How often the chip restarted on its own.
  int restarts() const { return restarts_; }
  const RegisterBus& bus() const { return *bus_; }

 private:
  void reset();
  void wait_for_chip();
  void set_up();
  void set_mode(std::uint8_t mode);
  void restore_calibration(const Bno055Calibration& calibration);
  void look_after_restart();

  std::unique_ptr<RegisterBus> bus_;
  Bno055Options options_;
  std::string firmware_;
  int odd_readings_ = 0;  // in a row
  int restarts_ = 0;
};

}  // namespace plumbline::capture
