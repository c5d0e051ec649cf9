// What one thread hands to another without either waiting.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

namespace plumbline::app {

/// Holds one `T` at most: what has not been taken is merged into what follows, by `next.follow(older)`. One thread
/// puts, another takes.
template <class T>
class Mailbox {
 public:
  Mailbox() = default;
  ~Mailbox() { delete slot_.exchange(nullptr); }
  Mailbox(const Mailbox&) = delete;
  Mailbox& operator=(const Mailbox&) = delete;

  /// Only one thread puts, so nothing is lost between the two exchanges.
  void put(std::unique_ptr<T> next) {
    if (const std::unique_ptr<T> older{slot_.exchange(nullptr)}) next->follow(std::move(*older));
    slot_.exchange(next.release());
    ring();
  }
  /// Null if there is nothing.
  std::unique_ptr<T> take() { return std::unique_ptr<T>(slot_.exchange(nullptr)); }

  /// Wakes whoever waits.
  void ring() {
    ++bell_;
    bell_.notify_all();
  }
  /// How often it has rung: to be read before looking for work, and given to `wait`.
  unsigned rung() const { return bell_; }
  void wait(unsigned rung) const { bell_.wait(rung); }

 private:
  std::atomic<T*> slot_ = nullptr;
  std::atomic<unsigned> bell_ = 0;
};

}  // namespace plumbline::app
