#include "capture/i2c_bus.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/i2c-dev.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "capture/clock.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr int kI2cTries = 4;
constexpr useconds_t kI2cPause = 2000;  // µs before a chip that did not answer is asked again

struct Descriptor {
  int fd;
  explicit Descriptor(int descriptor) : fd(descriptor) {}
  ~Descriptor() { close(fd); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
};

[[noreturn]] void fail_to_open(const std::string& path, const std::string& why, const char* advice) {
  throw Disconnected("the I2C adapter cannot be used: " + why, path, advice);
}

I2cBus::Transfer open_adapter(const std::string& path) {
  const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0)
    fail_to_open(path, std::strerror(errno),
                 errno == EACCES ? "add yourself to its group: sudo usermod -aG i2c $USER"
                                 : "load the driver (modprobe i2c-dev) and check the path (i2cdetect -l)");
  auto descriptor = std::make_shared<Descriptor>(fd);
  unsigned long functions = 0;
  if (ioctl(fd, I2C_FUNCS, &functions) != 0) fail_to_open(path, std::strerror(errno), "give /dev/i2c-1 or its like");
  if ((functions & I2C_FUNC_I2C) == 0)
    fail_to_open(path, "it knows no combined transfers", "use another adapter, or the sensor's serial port");
  return [descriptor](std::vector<i2c_msg>& messages) {
    i2c_rdwr_ioctl_data data{messages.data(), static_cast<__u32>(messages.size())};
    return ioctl(descriptor->fd, I2C_RDWR, &data) < 0 ? errno : 0;
  };
}

}  // namespace

I2cBus::I2cBus(const std::string& path, std::uint16_t address) : I2cBus(path, address, open_adapter(path)) {}

I2cBus::I2cBus(std::string name, std::uint16_t address, Transfer transfer)
    : RegisterBus(std::move(name)), address_(address), transfer_(std::move(transfer)) {}

void I2cBus::transfer(const char* what, std::uint8_t first, std::vector<i2c_msg> messages) {
  int error = 0;
  for (int i = 0; i < kI2cTries; ++i) {
    ++counters_.requests;
    error = transfer_(messages);
    if (error == 0) return;
    if (error == ENODEV || error == EBADF) break;
    ++counters_.repeats;
    usleep(kI2cPause);
  }
  const std::string text = fmt::format("the sensor at {:#04x} cannot be {} at register {:#04x}: {}", address_, what,
                                       first, std::strerror(error));
  if (error == ENODEV || error == EBADF) throw Disconnected(text, name(), "check that the adapter is plugged in");
  throw BusError(text, name(), "check its wiring and its address (i2cdetect): 0x28, or 0x29 with the ADR pin high");
}

std::vector<std::uint8_t> I2cBus::read(std::uint8_t first, std::size_t count, Nanoseconds* time) {
  std::vector<std::uint8_t> values(count);
  std::uint8_t address = first;
  const Nanoseconds begin = now();
  transfer("read", first, {{address_, 0, 1, &address}, {address_, I2C_M_RD, static_cast<__u16>(count), values.data()}});
  if (time != nullptr) *time = begin + (now() - begin) / 2;
  return values;
}

void I2cBus::write(std::uint8_t first, const std::vector<std::uint8_t>& values) {
  std::vector<std::uint8_t> bytes = {first};
  bytes.insert(bytes.end(), values.begin(), values.end());
  transfer("written to", first, {{address_, 0, static_cast<__u16>(bytes.size()), bytes.data()}});
}

void I2cBus::write_unanswered(std::uint8_t address, std::uint8_t value) {
  std::uint8_t bytes[] = {address, value};
  std::vector<i2c_msg> messages = {{address_, 0, 2, bytes}};
  ++counters_.requests;
  const int error = transfer_(messages);  // a chip that resets may not acknowledge the last byte
  if (error == ENODEV || error == EBADF)
    throw Disconnected(std::strerror(error), name(), "check that the adapter is plugged in");
}

}  // namespace plumbline::capture
