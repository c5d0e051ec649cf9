// Frames decoded ahead of their use, in a thread of their own.
#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/frame.h"
#include "plumbline/sequence.h"

namespace plumbline {

/// Hands out the frames of `indices` in that order. One thread calls next(); the decoding thread is inside. The
/// destructor waits for the frame that is being decoded, and for no more.
class PLUMBLINE_EXPORT Prefetcher {
 public:
  /// The sequence must outlive the prefetcher. At most `ahead` (at least 1) decoded frames wait.
  Prefetcher(const Sequence& sequence, std::vector<int> indices, int ahead = 4);
  ~Prefetcher();
  Prefetcher(const Prefetcher&) = delete;
  Prefetcher& operator=(const Prefetcher&) = delete;

  /// The next frame, or nothing after the last. What reading a frame threw is thrown here in that frame's turn; the
  /// call after that gives the frame that follows.
  std::optional<Frame> next();

  /// How long the frame of the latest next() took to read, decode and undistort, wall time, ms.
  double decode_milliseconds() const { return decode_milliseconds_; }
  /// How long the latest next() waited for it, ms.
  double wait_milliseconds() const { return wait_milliseconds_; }

 private:
  struct Item {
    Frame frame;
    std::exception_ptr error;
    double milliseconds = 0;
  };

  void decode_all();
  Item decode(int index) const;

  const Sequence& sequence_;
  const std::vector<int> indices_;
  const std::size_t ahead_;
  std::size_t handed_out_ = 0;
  double decode_milliseconds_ = 0, wait_milliseconds_ = 0;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> ready_;  // guarded by mutex_
  bool stopping_ = false;   // guarded by mutex_
  std::thread thread_;      // last: starts when all else stands
};

/// The frames of a Prefetcher that can be read: a damaged one costs itself alone.
class PLUMBLINE_EXPORT ReadableFrames {
 public:
  ReadableFrames(const Sequence& sequence, std::vector<int> indices) : frames_(sequence, std::move(indices)) {}

  /// As Prefetcher::next(), but what cannot be read is skipped. Throws the first Error of a frame once more than
  /// twenty are bad and most are, and at the end if most were.
  std::optional<Frame> next();

  /// Why each of the skipped frames could not be read, in their order.
  const std::vector<std::string>& skipped() const { return skipped_; }
  double decode_milliseconds() const { return frames_.decode_milliseconds(); }
  double wait_milliseconds() const { return frames_.wait_milliseconds(); }

 private:
  std::size_t good_ = 0;
  std::exception_ptr first_failure_;
  std::vector<std::string> skipped_;
  Prefetcher frames_;
};

}  // namespace plumbline
