// An orientation sensor that is read in a thread of its own, and that may be unplugged and come back.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "capture/bno055.h"
#include "plumbline/time.h"

namespace plumbline::capture {

struct ImuSourceOptions {
  std::string connection;  ///< see open_bus()
  double rate = 100;       ///< readings a second; the chip fuses 100 times a second
  Bno055Options chip;
};

struct ImuStatus {
  bool connected = false;
  std::uint64_t readings = 0;
  std::uint64_t failed = 0;    ///< requests that got no answer, and readings without an orientation
  std::uint64_t overruns = 0;  ///< see BusCounters; since the sensor was connected
  int reconnections = 0, restarts = 0;
  CalibrationStatus calibration;
};

class ImuSource {
 public:
  using Sink = std::function<void(const ImuReading&)>;

  /// Connects, so that a wrong port is told at once: throws Error. After that `sink` gets every reading, from the
  /// source's thread; it must not throw.
  ImuSource(const ImuSourceOptions& options, Sink sink);
  ~ImuSource();
  ImuSource(const ImuSource&) = delete;
  ImuSource& operator=(const ImuSource&) = delete;

  ImuStatus status() const;
  /// What happened since the previous call, a sentence each: "… does not answer", "… is back after 1.2 s".
  std::vector<std::string> take_messages();

  /// Ends the readings and fetches the calibration that the chip has reached; empty if it does not answer.
  std::optional<Bno055Calibration> finish();

  /// In words: "BNO055 (firmware 3.11) at /dev/ttyUSB0".
  const std::string& description() const { return description_; }

 private:
  void run();
  void read_once();
  void connect();
  void note_failure(const std::string& what, bool gone);
  void note_success(const ImuReading& reading);
  void update_counters();
  void say(std::string message);
  bool pause_until(Nanoseconds time);  // false once the source is to stop
  void stop();

  ImuSourceOptions options_;
  Sink sink_;
  std::string description_;
  std::unique_ptr<Bno055> chip_;              // of the thread while it runs
  std::optional<Nanoseconds> failing_since_;  // of the thread
  bool gone_ = false;                         // of the thread: the failure that was told was a lost port

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  ImuStatus status_;                   // guarded by mutex_
  std::vector<std::string> messages_;  // guarded by mutex_
  bool stopping_ = false;              // guarded by mutex_
  std::thread thread_;                 // last: starts when all else stands
};

}  // namespace plumbline::capture
