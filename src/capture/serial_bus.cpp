#include "capture/serial_bus.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "capture/clock.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr std::uint8_t kRequest = 0xAA, kWrite = 0x00, kRead = 0x01, kData = 0xBB, kStatus = 0xEE;
constexpr int kWritten = 0x01, kOverrun = 0x07;
constexpr Nanoseconds kMillisecond = 1'000'000;
constexpr Nanoseconds kByteTime = 10 * kNanosecondsPerSecond / 115200;  // 8 bits, start and stop
// The chip answers within a few milliseconds; USB adapters keep bytes back for up to 16 ms (FTDI's latency timer).
constexpr Nanoseconds kAnswerTime = 50 * kMillisecond;
constexpr Nanoseconds kDry = 20 * kMillisecond;  // a line that was silent for so long has nothing more to say
constexpr Nanoseconds kDryLimit = 100 * kMillisecond;
constexpr Nanoseconds kPause = 2 * kMillisecond;  // before a busy chip is asked again
constexpr int kOverrunTries = 10, kTries = 4;

void pause(Nanoseconds time) { usleep(static_cast<useconds_t>(time / 1000)); }

int timeout_until(Nanoseconds deadline) {
  const Nanoseconds left = deadline - now();
  return left <= 0 ? 0 : static_cast<int>((left + kMillisecond - 1) / kMillisecond);
}

}  // namespace

std::string_view bno055_status(int code) {
  switch (code) {
    case 0x02:
      return "read failed";
    case 0x03:
      return "write failed";
    case 0x04:
      return "no such register";
    case 0x05:
      return "register cannot be written";
    case 0x06:
      return "wrong start byte";
    case 0x07:
      return "bus over-run";
    case 0x08:
      return "request too long";
    case 0x09:
      return "request too short";
    case 0x0A:
      return "request broke off";
    default:
      return "unknown error";
  }
}

SerialBus::SerialBus(const std::string& path) : RegisterBus(path) {
  fd_ = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) fail("cannot be opened", errno);
  try {
    configure();
  } catch (...) {
    close(fd_);
    throw;
  }
}

SerialBus::~SerialBus() { close(fd_); }

void SerialBus::configure() {
  termios line{};
  if (tcgetattr(fd_, &line) != 0) fail("is no serial line", errno);
  // Two programs that ask one chip in turns would get each other's answers.
  if (ioctl(fd_, TIOCEXCL) != 0) fail("cannot be had alone", errno);
  cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  cfsetispeed(&line, B115200);
  cfsetospeed(&line, B115200);
  if (tcsetattr(fd_, TCSANOW, &line) != 0) fail("cannot be set to 115200 baud", errno);
  tcflush(fd_, TCIOFLUSH);
}

void SerialBus::fail(const char* doing, int error) const {
  const char* advice = "check the cable and that the sensor has power";
  if (error == EACCES) advice = "add yourself to the group that may use serial ports: sudo usermod -aG dialout $USER";
  if (error == EBUSY) advice = "close the other program that uses it";
  if (error == ENOTTY) advice = "give the serial port that the sensor hangs on, such as /dev/ttyUSB0";
  throw Disconnected(std::string("the port ") + doing + ": " + std::strerror(error), name(), advice);
}

void SerialBus::send(const std::vector<std::uint8_t>& bytes) {
  std::size_t sent = 0;
  const Nanoseconds deadline = now() + kAnswerTime;
  while (sent < bytes.size()) {
    const ssize_t n = ::write(fd_, bytes.data() + sent, bytes.size() - sent);
    if (n > 0) {
      sent += static_cast<std::size_t>(n);
    } else if (n < 0 && errno != EAGAIN && errno != EINTR) {
      fail("is gone", errno);
    } else if (now() > deadline) {
      throw BusError("the port takes no bytes", name(), "check the cable and that the sensor has power");
    } else {
      pollfd ready{fd_, POLLOUT, 0};
      poll(&ready, 1, timeout_until(deadline));
    }
  }
}

std::vector<std::uint8_t> SerialBus::receive(std::size_t count, Nanoseconds deadline, Nanoseconds* first_byte) {
  std::vector<std::uint8_t> bytes(count);
  std::size_t got = 0;
  while (got < count) {
    pollfd ready{fd_, POLLIN, 0};
    const int events = poll(&ready, 1, timeout_until(deadline));
    if (events == 0) break;
    if (events < 0 && errno != EINTR) fail("is gone", errno);
    if (events < 0) continue;
    const ssize_t n = ::read(fd_, bytes.data() + got, count - got);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    // A port whose device was pulled out reads as an error or as an end of file.
    if (n <= 0) fail("is gone", n < 0 ? errno : ENODEV);
    if (got == 0 && first_byte != nullptr) *first_byte = now();
    got += static_cast<std::size_t>(n);
  }
  bytes.resize(got);
  return bytes;
}

/// Late bytes of an earlier answer must not be taken for the next one.
void SerialBus::run_dry() {
  const Nanoseconds limit = now() + kDryLimit;
  while (now() < limit && !receive(1, now() + kDry, nullptr).empty()) throw_away_input();
}

void SerialBus::throw_away_input() { tcflush(fd_, TCIFLUSH); }

SerialBus::Answer SerialBus::read_once(std::uint8_t first, std::size_t count, std::vector<std::uint8_t>* values,
                                       Nanoseconds* time) {
  throw_away_input();
  send({kRequest, kRead, first, static_cast<std::uint8_t>(count)});
  // The chip takes its registers when it has the whole request. When the answer arrives says less: adapters keep it
  // back.
  const Nanoseconds asked = now() + 4 * kByteTime;
  const Nanoseconds deadline = asked + kAnswerTime + static_cast<Nanoseconds>(count) * kByteTime;
  Nanoseconds answered = asked;
  const std::vector<std::uint8_t> head = receive(2, deadline, &answered);
  if (head.size() < 2) return Answer::none;
  if (head[0] == kStatus) {
    refusal_ = head[1];
    return refusal_ == kOverrun ? Answer::overrun : Answer::refused;
  }
  if (head[0] != kData || head[1] != count) return Answer::none;
  *values = receive(count, deadline, nullptr);
  if (values->size() < count) return Answer::none;
  if (time != nullptr) *time = std::min(asked, answered);
  return Answer::good;
}

SerialBus::Answer SerialBus::write_once(std::uint8_t first, const std::vector<std::uint8_t>& values) {
  throw_away_input();
  std::vector<std::uint8_t> request(4 + values.size());
  request[0] = kRequest, request[1] = kWrite, request[2] = first;
  request[3] = static_cast<std::uint8_t>(values.size());
  std::copy(values.begin(), values.end(), request.begin() + 4);
  send(request);
  const Nanoseconds wire = static_cast<Nanoseconds>(request.size()) * kByteTime;
  const std::vector<std::uint8_t> answer = receive(2, now() + wire + kAnswerTime, nullptr);
  if (answer.size() < 2 || answer[0] != kStatus) return Answer::none;
  refusal_ = answer[1];
  if (refusal_ == kWritten) return Answer::good;
  return refusal_ == kOverrun ? Answer::overrun : Answer::refused;
}

template <class Request>
void SerialBus::repeat(const char* what, std::uint8_t first, Request&& request) {
  refusal_ = 0;
  for (int overruns = 0, tries = 0; overruns < kOverrunTries && tries < kTries;) {
    ++counters_.requests;
    const Answer answer = request();
    if (answer == Answer::good) return;
    if (answer == Answer::overrun) {
      ++overruns;
      ++counters_.overruns;
      pause(kPause);
    } else {
      ++tries;
      ++counters_.repeats;
      run_dry();
    }
  }
  const std::string why =
      refusal_ == 0 ? std::string("no answer") : fmt::format("{} ({:#04x})", bno055_status(refusal_), refusal_);
  throw BusError(fmt::format("the sensor cannot be {} at register {:#04x}: {}", what, first, why), name(),
                 "check its wiring: RX to TX and TX to RX, and PS1 high (UART)");
}

std::vector<std::uint8_t> SerialBus::read(std::uint8_t first, std::size_t count, Nanoseconds* time) {
  std::vector<std::uint8_t> values;
  repeat("read", first, [&] { return read_once(first, count, &values, time); });
  return values;
}

void SerialBus::write(std::uint8_t first, const std::vector<std::uint8_t>& values) {
  repeat("written to", first, [&] { return write_once(first, values); });
}

void SerialBus::write_unanswered(std::uint8_t address, std::uint8_t value) {
  send({kRequest, kWrite, address, 1, value});
}

}  // namespace plumbline::capture
