// How urgent a thread is.
#pragma once

#include <sys/resource.h>

namespace plumbline::app {

/// Of the calling thread alone, by so many of the system's steps (nice).
inline void lower_priority(int steps) { setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + steps); }

}  // namespace plumbline::app
