#include "support/fake_bno055.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <cmath>
#include <ctime>
#include <stdexcept>
#include <utility>

namespace plumbline::test {
namespace {

constexpr std::uint8_t kMode = 0x3D, kTrigger = 0x3F, kCalibration = 0x55;
constexpr Nanoseconds kMillisecond = 1'000'000;

Nanoseconds monotonic() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kNanosecondsPerSecond + t.tv_nsec;
}

}  // namespace

FakeBno055::FakeBno055(const std::filesystem::path& folder) : port_(folder / "ttyUSB0") {
  power_on();
  plug_in();
}

FakeBno055::~FakeBno055() { unplug(); }

void FakeBno055::plug_in() {
  char name[256];
  if (openpty(&master_, &slave_, name, nullptr, nullptr) != 0) return;  // no port: PLUMBLINE_TERMINAL_OR_SKIP says why
  // A program that is started beside must not keep the line alive.
  fcntl(master_, F_SETFD, FD_CLOEXEC);
  fcntl(slave_, F_SETFD, FD_CLOEXEC);
  termios line{};
  tcgetattr(slave_, &line);
  cfmakeraw(&line);
  tcsetattr(slave_, TCSANOW, &line);
  std::filesystem::remove(port_);
  std::filesystem::create_symlink(name, port_);
  stopping_ = false;
  thread_ = std::thread([this] { serve(); });
}

void FakeBno055::unplug() {
  stopping_ = true;
  if (thread_.joinable()) thread_.join();
  if (master_ >= 0) close(master_), close(slave_);
  master_ = slave_ = -1;
  std::filesystem::remove(port_);
  request_.clear();
}

void FakeBno055::power_on() {
  const std::lock_guard lock(mutex_);
  registers_.fill(0);
  registers_[4] = 0x11, registers_[5] = 0x03;
  deaf_until_ = 0;
  boots_until_ = monotonic() + 100 * kMillisecond;  // a real one boots for 650 ms
}

void FakeBno055::brown_out() { power_on(); }

std::array<std::uint8_t, 22> FakeBno055::calibration() const {
  const std::lock_guard lock(mutex_);
  std::array<std::uint8_t, 22> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = registers_[kCalibration + i];
  return bytes;
}

void FakeBno055::set_calibration(const std::array<std::uint8_t, 22>& bytes) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < bytes.size(); ++i) registers_[kCalibration + i] = bytes[i];
}

std::uint8_t FakeBno055::mode() const {
  const std::lock_guard lock(mutex_);
  return registers_[kMode];
}

bool FakeBno055::happens(double share) { return std::uniform_real_distribution<>(0, 1)(random_) < share; }

bool FakeBno055::is_deaf() {
  const std::lock_guard lock(mutex_);
  const Nanoseconds time = monotonic();
  if (time < deaf_until_) ++requests_while_deaf_;
  return time < boots_until_ || time < deaf_until_;
}

void FakeBno055::serve() {
  while (!stopping_) {
    pollfd ready{master_, POLLIN, 0};
    if (poll(&ready, 1, 10) <= 0) continue;
    std::uint8_t bytes[64];
    const ssize_t n = read(master_, bytes, sizeof bytes);
    for (ssize_t i = 0; i < n; ++i) handle(bytes[i]);
  }
}

void FakeBno055::handle(std::uint8_t byte) {
  if (request_.empty() && byte != 0xAA) return;
  request_.push_back(byte);
  if (request_.size() < 4) return;
  const bool writes = request_[1] == 0x00;
  if (writes && request_.size() < 4u + request_[3]) return;
  const std::vector<std::uint8_t> request = std::exchange(request_, {});
  if (is_deaf() || silent) return;
  if (happens(overruns)) return send({0xEE, 0x07});
  if (writes)
    answer_write(request[2], {request.begin() + 4, request.end()});
  else
    answer_read(request[2], request[3]);
}

void FakeBno055::answer_read(std::uint8_t first, std::uint8_t count) {
  std::vector<std::uint8_t> answer = {0xBB, count};
  {
    const std::lock_guard lock(mutex_);
    if (first + count > 0x6B) return send({0xEE, 0x04});
    measure();
    // The calibration is only to be had in CONFIG mode.
    const bool hidden = registers_[kMode] != 0 && first >= kCalibration;
    for (int i = 0; i < count; ++i) answer.push_back(hidden ? 0 : registers_[static_cast<std::size_t>(first + i)]);
  }
  send(answer);
}

void FakeBno055::answer_write(std::uint8_t first, const std::vector<std::uint8_t>& values) {
  if (first == kTrigger && (values[0] & 0x20) != 0) {
    ++resets_;
    return power_on();  // without an answer
  }
  {
    const std::lock_guard lock(mutex_);
    if (first >= kCalibration && registers_[kMode] != 0) return send({0xEE, 0x05});
    for (std::size_t i = 0; i < values.size(); ++i) set_register(static_cast<std::uint8_t>(first + i), values[i]);
  }
  send({0xEE, 0x01});
}

void FakeBno055::set_register(std::uint8_t address, std::uint8_t value) {
  // Table 3-6 of the data sheet: the chip is deaf while it changes its mode.
  if (address == kMode) deaf_until_ = monotonic() + (value == 0 ? 18 : 6) * kMillisecond;
  registers_.at(address) = value;
}

/// The registers as they are now.
void FakeBno055::measure() {
  registers_[0] = chip_id;
  registers_[0x35] = calibration_status;
  const double angle = kFakeRate * 1e-9 * static_cast<double>(monotonic());
  const double half = 0.5 * std::remainder(angle, 4 * M_PI);
  const bool on = registers_[kMode] == 0x0C;
  const auto put = [&](int address, double value) {
    const auto word = static_cast<std::int16_t>(std::lround(on ? value : 0));
    registers_[static_cast<std::size_t>(address)] = static_cast<std::uint8_t>(word & 0xFF);
    registers_[static_cast<std::size_t>(address + 1)] = static_cast<std::uint8_t>(word >> 8 & 0xFF);
  };
  const double forces[] = {0.5, -0.25, 9.81}, field[] = {20, -5, -44}, rate[] = {0, 0, kFakeRate};
  for (int i = 0; i < 3; ++i) {
    put(0x08 + 2 * i, 100 * forces[i]);
    put(0x0E + 2 * i, 16 * field[i]);
    put(0x14 + 2 * i, 16 * 180 / M_PI * rate[i]);
  }
  const double quaternion[] = {std::cos(half), 0, 0, std::sin(half)};  // w x y z
  for (int i = 0; i < 4; ++i) put(0x20 + 2 * i, 16384 * quaternion[i]);
}

void FakeBno055::send(std::vector<std::uint8_t> bytes) {
  if (happens(lost_bytes)) bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(random_() % bytes.size()));
  if (happens(garbage)) {
    std::vector<std::uint8_t> noise(1 + random_() % 8);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random_());
    bytes.insert(bytes.begin(), noise.begin(), noise.end());
  }
  [[maybe_unused]] const ssize_t ignored = write(master_, bytes.data(), bytes.size());
}

}  // namespace plumbline::test
