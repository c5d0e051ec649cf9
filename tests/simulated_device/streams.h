// Streams: operations wait there until the host waits for them or the device gets to them by chance.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/random.h"
#include "simulated_device/device.h"
#include "simulated_device/order.h"
#include "simulated_device/runtime.h"

namespace plumbline::simulated {

/// A point in a stream that an event stands for.
struct Mark {
  bool reached = false;
  double milliseconds = 0;
  Clock clock;
};

struct Operation {
  std::function<void()> run;
  std::shared_ptr<Mark> waits_for;
  bool is_mark = false;  ///< done whatever went wrong
  Clock clock = {};      ///< what is over before it
};

struct Stream {
  int actor = 0;
  std::deque<Operation> waiting;
  Clock clock;  ///< what is over once its operations are
};

struct Event {
  std::shared_ptr<Mark> mark;
};

/// The device's side of the runtime.
class Device {
 public:
  static Device& get();

  void plug_in(const Model& model);
  const Model& model() const { return model_; }
  const Limits& limits() const;
  std::uint64_t next_seed() { return plumbline::stream(model_.seed, ++draws_); }

  Stream* create_stream();
  void destroy(Stream* stream);
  bool knows(const Stream* stream) const;
  /// Adds an operation; some of those that wait are done then and there.
  void enqueue(Stream* stream, Operation operation);
  void record(Stream* stream, Event* event);
  void wait_for(Stream* stream, const Event& event);
  /// Until it is reached or, without a mark, the stream is empty.
  void finish(Stream* stream);
  void finish(const std::shared_ptr<Mark>& mark);
  void finish_all();

  /// An error that stays, as an illegal address does.
  void fail(cudaError_t error) { error_ = error; }
  cudaError_t error() const { return error_; }
  /// What a call returns; an error is kept until cudaGetLastError has told it.
  cudaError_t returned(cudaError_t error) {
    if (error != cudaSuccess) told_ = error;
    return error;
  }
  cudaError_t take_told() { return error_ != cudaSuccess ? error_ : std::exchange(told_, cudaSuccess); }
  void note(const Launch& launch);
  std::vector<Launch> take_launches();

 private:
  bool is_ready(const Stream& stream) const;
  bool do_one();
  void do_some();
  void in_device(const std::function<void()>& work);

  Model model_;
  std::uint64_t draws_ = 0;
  cudaError_t error_ = cudaSuccess, told_ = cudaSuccess;
  std::vector<std::unique_ptr<Stream>> streams_;
  std::vector<Launch> launches_;
};

}  // namespace plumbline::simulated
