#include "capture/frame_grabber.h"

#include <algorithm>
#include <utility>

#include "capture/clock.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

constexpr std::chrono::milliseconds kPoll{100};  // how soon the thread notices that it is to stop

}  // namespace

FrameGrabber::FrameGrabber(const Open& open, std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 1)) {
  thread_ = std::thread([this, open] { run(open); });
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return opened_ || finished_; });
  if (opened_) return;
  lock.unlock();
  thread_.join();
  std::rethrow_exception(error_);
}

FrameGrabber::~FrameGrabber() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void FrameGrabber::run(const Open& open) {
  std::exception_ptr error;
  try {
    const std::unique_ptr<DepthDevice> device = open();
    {
      const std::lock_guard lock(mutex_);
      info_ = device->info();
      latest_frame_ = now();
      opened_ = true;
    }
    changed_.notify_all();
    grab(*device);
  } catch (...) {
    error = std::current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    error_ = error;
    finished_ = true;
  }
  changed_.notify_all();
}

void FrameGrabber::grab(DepthDevice& device) {
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
    }
    std::optional<CapturedFrame> frame = device.wait(kPoll);
    if (frame) push(std::move(*frame));
    const bool ended = device.ended();
    const std::lock_guard lock(mutex_);
    status_.dropped = overflow_ + device.missed();
    status_.clock_jumps = device.clock_jumps();
    if (ended) return;
  }
}

void FrameGrabber::push(CapturedFrame frame) {
  {
    std::unique_lock lock(mutex_);
    ++status_.frames;
    latest_frame_ = now();
    if (info_.waits) changed_.wait(lock, [this] { return stopping_ || waiting_.size() < capacity_; });
    waiting_.push_back(std::move(frame));
    if (waiting_.size() > capacity_) {
      waiting_.pop_front();
      ++overflow_;
    }
  }
  changed_.notify_all();
}

std::optional<CapturedFrame> FrameGrabber::next(std::chrono::milliseconds timeout) {
  std::optional<CapturedFrame> frame;
  {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [this] { return !waiting_.empty() || finished_; });
    if (waiting_.empty()) {
      if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
      return std::nullopt;
    }
    frame = std::move(waiting_.front());
    waiting_.pop_front();
  }
  changed_.notify_all();
  return frame;
}

GrabberStatus FrameGrabber::status() const {
  const std::lock_guard lock(mutex_);
  GrabberStatus status = status_;
  status.silence = to_seconds(now() - latest_frame_);
  status.ended = finished_ && waiting_.empty() && error_ == nullptr;
  return status;
}

}  // namespace plumbline::capture
