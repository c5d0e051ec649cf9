#include "simulated_device/streams.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/random.h"
#include "simulated_device/memory.h"

namespace plumbline::simulated {

// CUDA C++ Programming Guide, "Technical Specifications per Compute Capability".
const std::vector<Limits>& known_limits() {
  static const std::vector<Limits> limits = {{75, 1024, 16, std::size_t{64} << 10, 0},
                                             {80, 2048, 32, std::size_t{164} << 10, 1024},
                                             {90, 2048, 32, std::size_t{228} << 10, 1024},
                                             {100, 2048, 32, std::size_t{228} << 10, 1024}};
  return limits;
}

Device& Device::get() {
  static Device device;
  return device;
}

void Device::plug_in(const Model& model) {
  model_ = model;
  draws_ = 0;
  error_ = told_ = cudaSuccess;
  launches_.clear();
}

const Limits& Device::limits() const {
  const auto& all = known_limits();
  return *std::find_if(all.begin(), all.end() - 1, [&](const Limits& l) { return l.capability == model_.capability; });
}

Stream* Device::create_stream() {
  streams_.push_back(std::make_unique<Stream>());
  streams_.back()->actor = Order::get().add_actor();
  return streams_.back().get();
}

bool Device::knows(const Stream* stream) const {
  return std::any_of(streams_.begin(), streams_.end(), [&](const auto& known) { return known.get() == stream; });
}

void Device::destroy(Stream* stream) {
  finish(stream);  // the device does what is left in it; nobody waits, but then nobody sees it either
  std::erase_if(streams_, [&](const auto& known) { return known.get() == stream; });
}

void Device::enqueue(Stream* stream, Operation operation) {
  Order& order = Order::get();
  const auto actor = static_cast<std::size_t>(stream->actor);
  Clock& clock = stream->clock;
  clock.resize(std::max(clock.size(), actor + 1));
  join(&clock, order.host_clock());
  clock[Order::kHost] = order.host_intervals();
  operation.clock = clock;
  stream->waiting.push_back(std::move(operation));
  ++clock[actor];
  order.host_goes_on();
  do_some();
}

void Device::record(Stream* stream, Event* event) {
  auto mark = std::make_shared<Mark>();
  event->mark = mark;
  const auto reach = [mark] {
    mark->reached = true;
    mark->milliseconds =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  enqueue(stream, {reach, nullptr, true});
  mark->clock = stream->clock;
}

void Device::wait_for(Stream* stream, const Event& event) {
  if (event.mark == nullptr) return;  // an event that was not recorded holds nobody up
  join(&stream->clock, event.mark->clock);
  enqueue(stream, {[] {}, event.mark, true});
}

bool Device::is_ready(const Stream& stream) const {
  return !stream.waiting.empty() &&
         (stream.waiting.front().waits_for == nullptr || stream.waiting.front().waits_for->reached);
}

/// The next operation of some stream that has one.
bool Device::do_one() {
  std::vector<Stream*> ready;
  for (const auto& stream : streams_)
    if (is_ready(*stream)) ready.push_back(stream.get());
  if (ready.empty()) return false;
  Stream& stream = *ready[next_seed() % ready.size()];
  const Operation operation = std::move(stream.waiting.front());
  stream.waiting.pop_front();
  Order::get().begin(stream.actor, operation.clock);
  if (error_ == cudaSuccess || operation.is_mark) operation.run();
  return true;
}

void Device::in_device(const std::function<void()>& work) {
  Memory::get().open();
  work();
  Memory::get().close();
  Order::get().host_goes_on();
}

void Device::do_some() {
  const std::uint64_t draw = next_seed();
  if (draw % 2 == 0) return;
  in_device([&] {
    for (std::uint64_t left = draw / 2 % 5; left > 0 && do_one(); --left) {
    }
  });
}

void Device::finish(Stream* stream) {
  in_device([&] {
    while (!stream->waiting.empty() && do_one()) {
    }
  });
  join(&Order::get().host_clock(), stream->clock);
}

void Device::finish(const std::shared_ptr<Mark>& mark) {
  if (mark == nullptr) return;
  in_device([&] {
    while (!mark->reached && do_one()) {
    }
  });
  join(&Order::get().host_clock(), mark->clock);
}

void Device::finish_all() {
  in_device([&] {
    while (do_one()) {
    }
  });
  for (const auto& stream : streams_) join(&Order::get().host_clock(), stream->clock);
}

void Device::note(const Launch& launch) {
  const auto known =
      std::find_if(launches_.begin(), launches_.end(), [&](const Launch& l) { return l.kernel == launch.kernel; });
  if (known == launches_.end()) {
    launches_.push_back(launch);
    return;
  }
  known->blocks = std::max(known->blocks, launch.blocks);
  known->threads = std::max(known->threads, launch.threads);
  known->dynamic_shared = std::max(known->dynamic_shared, launch.dynamic_shared);
  known->touched_shared = std::max(known->touched_shared, launch.touched_shared);
}

std::vector<Launch> Device::take_launches() { return std::exchange(launches_, {}); }

void plug_in(const Model& model) {
  take_faults();
  Device::get().plug_in(model);
}

std::vector<Launch> take_launches() { return Device::get().take_launches(); }

bool is_device_address(const void* address) {
  return Memory::get().is_device(reinterpret_cast<std::uintptr_t>(address));
}

}  // namespace plumbline::simulated
