#include "core/device_array.h"

#include <sys/mman.h>

#include <cstring>
#include <new>

namespace plumbline {

std::shared_ptr<void> HostMemory::allocate(std::size_t bytes) const {
  // Anonymous pages are zero and take no memory before they are written: a 512³ volume costs what the scene touches.
  void* address = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) throw std::bad_alloc();
  return {address, [bytes](void* p) { munmap(p, bytes); }};
}

// Nothing to copy may come with null pointers, which memcpy must not see.
void HostMemory::upload(void* device, const void* host, std::size_t bytes) const {
  if (bytes != 0) std::memcpy(device, host, bytes);
}
void HostMemory::download(void* host, const void* device, std::size_t bytes) const {
  if (bytes != 0) std::memcpy(host, device, bytes);
}
void HostMemory::clear(void* device, std::size_t bytes) const { std::memset(device, 0, bytes); }

}  // namespace plumbline
