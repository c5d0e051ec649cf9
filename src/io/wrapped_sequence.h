// Another sequence's frames, readings and truth, with something changed about them.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "plumbline/sequence.h"

namespace plumbline {

/// As `wrapped`, which others may look at too, with another `info`. Who overrides read() changes the frames.
class WrappedSequence : public Sequence {
 public:
  WrappedSequence(std::shared_ptr<const Sequence> wrapped, SequenceInfo info)
      : Sequence(std::move(info), times_of(*wrapped)), wrapped_(std::move(wrapped)) {}

  Frame read(int index) const override { return wrapped_->read(index); }
  ImuRecording read_imu(std::vector<std::string>* notes) const override { return wrapped_->read_imu(notes); }
  Trajectory read_groundtruth(std::vector<std::string>* notes) const override {
    return wrapped_->read_groundtruth(notes);
  }

 private:
  static std::vector<Nanoseconds> times_of(const Sequence& sequence) {
    std::vector<Nanoseconds> times;
    for (int i = 0; i < sequence.size(); ++i) times.push_back(sequence.time(i));
    return times;
  }

  std::shared_ptr<const Sequence> wrapped_;
};

}  // namespace plumbline
