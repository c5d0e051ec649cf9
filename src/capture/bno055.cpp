#include "capture/bno055.h"

#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "capture/clock.h"
#include "io/atomic_file.h"
#include "io/text_file.h"
#include "plumbline/angles.h"
#include "plumbline/error.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr std::uint8_t kChipId = 0x00, kFirmware = 0x04, kPage = 0x07, kAccelerometer = 0x08, kQuaternion = 0x20,
                       kCalibrationStatus = 0x35, kUnits = 0x3B, kMode = 0x3D, kPower = 0x3E, kTrigger = 0x3F,
                       kCalibration = 0x55;
constexpr std::uint8_t kBno055 = 0xA0;
constexpr std::uint8_t kConfigMode = 0x00, kNdofMode = 0x0C, kNormalPower = 0x00, kReset = 0x20;
constexpr std::uint8_t kMetricUnits = 0x00;  // m/s², degrees a second, degrees, Celsius

// Table 3-6: from any mode to CONFIG 19 ms, from CONFIG to any other 7 ms.
constexpr useconds_t kToConfig = 19000, kFromConfig = 7000;
constexpr Nanoseconds kBootTime = 2 * kNanosecondsPerSecond;  // table 0-2 has 650 ms after a reset
constexpr useconds_t kResetTime = 30000, kBootPoll = 20000;
constexpr int kOddReadings = 20;  // in a row, before the chip is asked what is the matter

constexpr double kQuaternionUnit = 1.0 / (1 << 14);
constexpr double kRateUnit = radians(1) / 16, kForceUnit = 0.01, kFieldUnit = 1.0 / 16;
constexpr double kUnitTolerance = 0.01;

constexpr const char* kBno055Advice = "check the wiring and that the sensor is a BNO055";
constexpr const char* kCalibrationAdvice = "give the imu-calibration.txt of a recording with the same sensor";

double word(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return static_cast<std::int16_t>(bytes[at] | bytes[at + 1] << 8);
}

Eigen::Vector3d vector(const std::vector<std::uint8_t>& bytes, std::size_t at, double unit) {
  return unit * Eigen::Vector3d(word(bytes, at), word(bytes, at + 2), word(bytes, at + 4));
}

CalibrationStatus status_of(std::uint8_t byte) { return {byte >> 6, byte >> 4 & 3, byte >> 2 & 3, byte & 3}; }

}  // namespace

Bno055::Bno055(std::unique_ptr<RegisterBus> bus, const Bno055Options& options)
    : bus_(std::move(bus)), options_(options) {
  wait_for_chip();
  reset();
  set_up();
}

void Bno055::wait_for_chip() {
  for (const Nanoseconds limit = now() + kBootTime;;) {
    try {
      const std::uint8_t id = bus_->read(kChipId, 1)[0];
      if (id == kBno055) return;
      if (now() > limit)
        throw BusError(fmt::format("the chip's number is {:#04x}, where a BNO055 has {:#04x}", id, kBno055),
                       bus_->name(), kBno055Advice);
    } catch (const BusError&) {
      if (now() > limit) throw;
    }
    usleep(kBootPoll);
  }
}

void Bno055::reset() {
  bus_->write(kPage, {0});
  set_mode(kConfigMode);
  bus_->write_unanswered(kTrigger, kReset);
  usleep(kResetTime);
  wait_for_chip();
}

/// From a chip in CONFIG mode to one that measures.
void Bno055::set_up() {
  bus_->write(kPage, {0});
  bus_->write(kPower, {kNormalPower});
  bus_->write(kUnits, {kMetricUnits});
  const std::vector<std::uint8_t> version = bus_->read(kFirmware, 2);
  firmware_ = fmt::format("{:x}.{:02x}", version[1], version[0]);
  if (options_.calibration) restore_calibration(*options_.calibration);
  set_mode(kNdofMode);
}

void Bno055::set_mode(std::uint8_t mode) {
  bus_->write(kMode, {mode});
  usleep(mode == kConfigMode ? kToConfig : kFromConfig);
}

void Bno055::restore_calibration(const Bno055Calibration& calibration) {
  const std::vector<std::uint8_t> bytes(calibration.begin(), calibration.end());
  bus_->write(kCalibration, bytes);
  if (bus_->read(kCalibration, bytes.size()) != bytes)
    throw BusError("the sensor did not take over its calibration", bus_->name(), kBno055Advice);
}

std::optional<ImuReading> Bno055::read() {
  const std::uint8_t first = options_.raw ? kAccelerometer : kQuaternion;
  ImuReading reading;
  const std::vector<std::uint8_t> bytes = bus_->read(first, kCalibrationStatus - first + 1, &reading.time);
  const std::size_t q = kQuaternion - first;
  reading.quaternion =
      kQuaternionUnit * Eigen::Vector4d(word(bytes, q + 2), word(bytes, q + 4), word(bytes, q + 6), word(bytes, q));
  if (std::abs(reading.quaternion.norm() - 1) > kUnitTolerance) {
    if (++odd_readings_ >= kOddReadings) look_after_restart();
    return std::nullopt;
  }
  odd_readings_ = 0;
  reading.quaternion.normalize();
  reading.calibration = status_of(bytes.back());
  // 0x08 accelerometer, 0x0E magnetometer, 0x14 gyroscope
  if (options_.raw)
    reading.raw = {vector(bytes, 12, kRateUnit), vector(bytes, 0, kForceUnit), vector(bytes, 6, kFieldUnit)};
  return reading;
}

/// A chip that lost its supply for a moment comes back in CONFIG mode, where it measures nothing.
void Bno055::look_after_restart() {
  odd_readings_ = 0;
  const std::uint8_t mode = bus_->read(kMode, 1)[0] & 0x0F;
  if (mode == kNdofMode) return;
  ++restarts_;
  wait_for_chip();
  set_up();
}

Bno055Calibration Bno055::read_calibration() {
  set_mode(kConfigMode);
  const std::vector<std::uint8_t> bytes = bus_->read(kCalibration, Bno055Calibration().size());
  set_mode(kNdofMode);
  Bno055Calibration calibration;
  std::copy(bytes.begin(), bytes.end(), calibration.begin());
  return calibration;
}

namespace {

std::uint8_t parse_byte(const TextFile& file, const TextLine& line, std::string_view field) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value, 16);
  if (error != std::errc() || end != field.data() + field.size() || value > 0xFF)
    file.fail(line, fmt::format("'{}' is no byte in hexadecimal", field), kCalibrationAdvice);
  return static_cast<std::uint8_t>(value);
}

}  // namespace

Bno055Calibration read_bno055_calibration(const std::string& path) {
  const TextFile file(path);
  Bno055Calibration calibration{};
  std::size_t count = 0;
  for (const TextLine& line : file.lines()) {
    for (const std::string_view field : split_fields(line.text)) {
      const std::uint8_t value = parse_byte(file, line, field);
      if (count < calibration.size()) calibration[count] = value;
      ++count;
    }
  }
  if (count != calibration.size())
    throw Error(fmt::format("has {} bytes, where a BNO055's calibration has {}", count, calibration.size()), path,
                kCalibrationAdvice);
  return calibration;
}

void write_bno055_calibration(const std::string& path, const Bno055Calibration& calibration) {
  AtomicFile file(path);
  file.write(
      "# BNO055 calibration: registers 0x55 to 0x6A (offsets of accelerometer, magnetometer, gyroscope; radii)\n");
  file.write(fmt::format("{:02x}\n", fmt::join(calibration, " ")));
  file.commit();
}

}  // namespace plumbline::capture
