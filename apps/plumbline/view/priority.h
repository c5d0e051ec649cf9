// How urgent a thread is.
#pragma once

#include <sched.h>
#include <sys/resource.h>

namespace plumbline::app {

/// Of the calling thread alone, by so many of the system's steps (nice).
inline void lower_priority(int steps) { setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + steps); }

/// Of the calling thread alone: it runs where no other thread wants the processor (sched(7), SCHED_IDLE).
inline void run_when_idle() {
  const sched_param none{};
  sched_setscheduler(0, SCHED_IDLE, &none);
}

}  // namespace plumbline::app
