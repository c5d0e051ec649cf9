// Ctrl-C as a request to finish.
#pragma once

namespace plumbline::app {

/// While it lives, the first SIGINT or SIGTERM sets a flag, and the next one of the same kind has the system's effect.
/// One at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// Number of the signal that came, or 0.
  int signal() const;
};

}  // namespace plumbline::app
