// Frames fetched from a camera as they come, in a thread of their own.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "capture/depth_device.h"
#include "plumbline/time.h"

namespace plumbline::capture {

struct GrabberStatus {
  std::uint64_t frames = 0;   ///< that came from the camera
  std::uint64_t dropped = 0;  ///< that nobody fetched in time, or that the camera says we missed
  int clock_jumps = 0;
  double silence = 0;  ///< seconds since the latest frame, or since the start
  bool ended = false;  ///< no frame will come, and all that came were fetched
};

/// One thread calls next(). The device lives in the grabber's thread.
class FrameGrabber {
 public:
  using Open = std::function<std::unique_ptr<DepthDevice>()>;

  /// Opens the device, throwing what that throws. At most `capacity` frames wait to be fetched, 1 for "the latest
  /// alone"; if more come, the oldest are dropped, unless the device waits.
  FrameGrabber(const Open& open, std::size_t capacity);
  ~FrameGrabber();
  FrameGrabber(const FrameGrabber&) = delete;
  FrameGrabber& operator=(const FrameGrabber&) = delete;

  const DepthDeviceInfo& info() const { return info_; }

  /// The oldest frame that waits; nothing if none comes within the time, or ever. Throws, once the frames before it
  /// are fetched, what the camera threw when it was lost.
  std::optional<CapturedFrame> next(std::chrono::milliseconds timeout);

  GrabberStatus status() const;

 private:
  void run(const Open& open);
  void grab(DepthDevice& device);
  void push(CapturedFrame frame);

  const std::size_t capacity_;
  DepthDeviceInfo info_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<CapturedFrame> waiting_;  // this and all below guarded by mutex_
  GrabberStatus status_;
  Nanoseconds latest_frame_ = 0;
  std::uint64_t overflow_ = 0;
  std::exception_ptr error_;
  bool opened_ = false, stopping_ = false, finished_ = false;
  std::thread thread_;  // last: starts when all else stands
};

}  // namespace plumbline::capture
