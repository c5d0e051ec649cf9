#include "core/plane.h"

#include <sys/mman.h>

#include <new>

namespace plumbline {

Buffer allocate_host(std::size_t bytes) {
  // Anonymous pages are zero and take no memory before they are written: a 512³ volume costs what the scene touches.
  void* address = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) throw std::bad_alloc();
  return {address, [bytes](void* p) { munmap(p, bytes); }};
}

}  // namespace plumbline
