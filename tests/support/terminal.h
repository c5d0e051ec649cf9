// Pseudo-terminals: a plain chroot has none, and tests that need them are skipped there.
#pragma once

#include <gtest/gtest.h>
#include <pty.h>
#include <unistd.h>

namespace plumbline::test {

/// Whether this machine gives one.
inline bool has_pseudo_terminal() {
  int master = -1, slave = -1;
  if (openpty(&master, &slave, nullptr, nullptr, nullptr) != 0) return false;
  close(master);
  close(slave);
  return true;
}

#define PLUMBLINE_TERMINAL_OR_SKIP()           \
  if (!plumbline::test::has_pseudo_terminal()) \
  GTEST_SKIP() << "this machine gives no pseudo-terminal (is /dev/pts mounted?)"

}  // namespace plumbline::test
