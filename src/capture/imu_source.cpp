#include "capture/imu_source.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "capture/clock.h"
#include "plumbline/error.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr Nanoseconds kReconnectInterval = kNanosecondsPerSecond / 2;
constexpr Nanoseconds kPatience = 3 * kNanosecondsPerSecond;  // with a chip that does not answer, before it is reset

/// The first line of an error: what went wrong, without the advice.
std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

}  // namespace

ImuSource::ImuSource(const ImuSourceOptions& options, Sink sink) : options_(options), sink_(std::move(sink)) {
  if (!(options.rate > 0 && options.rate <= 1000))
    throw Error(fmt::format("{} readings a second are not possible", options.rate), "imu rate", "give up to 100");
  connect();
  description_ = fmt::format("BNO055 (firmware {}) at {}", chip_->firmware(), chip_->bus().name());
  thread_ = std::thread([this] { run(); });
}

ImuSource::~ImuSource() { stop(); }

void ImuSource::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void ImuSource::connect() {
  chip_ = std::make_unique<Bno055>(open_bus(options_.connection), options_.chip);
  const std::lock_guard lock(mutex_);
  status_.connected = true;
}

void ImuSource::run() {
  const auto interval = static_cast<Nanoseconds>(1e9 / options_.rate);
  for (Nanoseconds next = now(); pause_until(next);) {
    read_once();
    const Nanoseconds time = now();
    next = chip_ == nullptr ? time + kReconnectInterval : std::max(next + interval, time);
  }
}

void ImuSource::read_once() {
  try {
    if (chip_ == nullptr) {
      connect();
      const std::lock_guard lock(mutex_);
      ++status_.reconnections;
      return;
    }
    const std::optional<ImuReading> reading = chip_->read();
    update_counters();
    if (reading) note_success(*reading);
  } catch (const BusError& error) {
    note_failure(error.what(), false);
  } catch (const std::exception& error) {
    note_failure(error.what(), true);
  }
}

void ImuSource::update_counters() {
  const std::lock_guard lock(mutex_);
  status_.overruns = chip_->bus().counters().overruns;
  if (status_.restarts < chip_->restarts())
    messages_.push_back(fmt::format("{} restarted on its own; check its supply", description_));
  status_.restarts = chip_->restarts();
}

void ImuSource::note_success(const ImuReading& reading) {
  sink_(reading);
  if (failing_since_) say(fmt::format("{} is back after {:.1f} s", description_, to_seconds(now() - *failing_since_)));
  failing_since_.reset();
  const std::lock_guard lock(mutex_);
  ++status_.readings;
  status_.calibration = reading.calibration;
}

void ImuSource::note_failure(const std::string& what, bool gone) {
  const Nanoseconds time = now();
  if (!failing_since_ || gone != gone_) say(first_line(what));
  gone_ = gone;
  if (!failing_since_) failing_since_ = time;
  if (gone || time - *failing_since_ > kPatience) chip_.reset();
  const std::lock_guard lock(mutex_);
  ++status_.failed;
  status_.connected = chip_ != nullptr;
}

void ImuSource::say(std::string message) {
  const std::lock_guard lock(mutex_);
  messages_.push_back(std::move(message));
}

bool ImuSource::pause_until(Nanoseconds time) {
  // libstdc++'s steady clock is the monotonic clock of now().
  const std::chrono::steady_clock::time_point until{std::chrono::nanoseconds(time)};
  std::unique_lock lock(mutex_);
  return !changed_.wait_until(lock, until, [this] { return stopping_; });
}

ImuStatus ImuSource::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::vector<std::string> ImuSource::take_messages() {
  const std::lock_guard lock(mutex_);
  return std::exchange(messages_, {});
}

std::optional<Bno055Calibration> ImuSource::finish() {
  stop();
  if (chip_ == nullptr) return std::nullopt;
  try {
    return chip_->read_calibration();
  } catch (const Error& error) {
    say(first_line(error.what()));
    return std::nullopt;
  }
}

}  // namespace plumbline::capture
