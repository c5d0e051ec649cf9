// Small programs that each make one mistake, and the same without it: what the simulated device has to find.
#pragma once

namespace plumbline::simulated {

enum class Mistake {
  none,
  missing_barrier,       ///< shared memory is read before all have written it
  missing_warp_barrier,  ///< within a warp
  missing_grid_barrier,  ///< between blocks
  barrier_of_some,       ///< in a branch that only some threads take
  storage_used_again,    ///< CUB's, without a barrier
  plain_count,           ///< counted without an atomic
  beyond_the_array,      ///< one element behind the end
  beyond_shared_memory,  ///< of the launch
  unwritten,             ///< read before anybody wrote it
  host_pointer,          ///< of the host in a kernel
  device_pointer,        ///< of the device in the host's code
  freed,                 ///< used by a kernel that is yet to run
  missing_wait,          ///< of the host, before it reads what a kernel writes
  missing_event,         ///< between two streams
  source_changed,        ///< of a copy that is not yet made
  pinned_freed,          ///< that a copy is still to read
  wrong_side,            ///< a copy's kind and its pointers do not fit
};

/// The sum of 0 … 255 by a block of two warps, and what else a mistake needs. The result, or −1 if the device refused.
int sum_with(Mistake mistake);

}  // namespace plumbline::simulated
