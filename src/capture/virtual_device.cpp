#include <algorithm>
#include <thread>
#include <utility>

#include "capture/clock.h"
#include "capture/drivers.h"
#include "plumbline/frame.h"
#include "plumbline/image.h"
#include "plumbline/sequence.h"
#include "plumbline/time.h"

namespace plumbline::capture {
namespace {

class VirtualDevice : public DepthDevice {
 public:
  VirtualDevice(std::unique_ptr<Sequence> sequence, const DepthDeviceOptions& options)
      : sequence_(std::move(sequence)), speed_(options.speed), color_(options.color) {
    const SequenceInfo& found = sequence_->info();
    info_.name = "virtual camera, " + found.path;
    info_.camera = found.camera;
    info_.camera_source = found.camera_source;
    info_.depth_scale = found.depth_scale;
    info_.has_color = color_ && found.color_frames > 0;
    info_.waits = speed_ == 0;
    info_.notes = found.notes;
    apply(options, &info_);
  }

  std::optional<CapturedFrame> wait(std::chrono::milliseconds timeout) override {
    if (start_ == 0) start_ = now();
    if (ended()) return std::nullopt;
    const Nanoseconds limit = now() + std::chrono::nanoseconds(timeout).count();
    skip_missed();
    const Nanoseconds wanted = std::min(due(next_), limit);
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(wanted)));
    if (now() < due(next_)) return std::nullopt;
    const int index = next_++;
    Frame frame = sequence_->read(index);
    const Nanoseconds time = start_ + since_start(index);
    return CapturedFrame{time, std::move(frame.depth), time, color_ ? std::move(frame.color) : ColorImage()};
  }

  bool ended() const override { return next_ >= sequence_->size(); }
  std::uint64_t missed() const override { return missed_; }

 private:
  Nanoseconds since_start(int index) const { return sequence_->time(index) - sequence_->time(0); }
  Nanoseconds due(int index) const {
    return speed_ == 0 ? start_ : start_ + static_cast<Nanoseconds>(static_cast<double>(since_start(index)) / speed_);
  }
  /// A camera does not wait: of the frames that are over only the latest is still to be had.
  void skip_missed() {
    while (speed_ > 0 && next_ + 1 < sequence_->size() && due(next_ + 1) <= now()) ++next_, ++missed_;
  }

  std::unique_ptr<Sequence> sequence_;
  double speed_;
  bool color_;
  Nanoseconds start_ = 0;  // 0 = not yet
  int next_ = 0;
  std::uint64_t missed_ = 0;
};

}  // namespace

std::unique_ptr<DepthDevice> make_virtual_device(const std::string& folder, const DepthDeviceOptions& options) {
  SequenceOptions input;
  input.color = options.color;
  input.intrinsics = options.intrinsics;
  return std::make_unique<VirtualDevice>(open_sequence(folder, input), options);
}

}  // namespace plumbline::capture
