#include "simulated_device/memory.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>

#include "simulated_device/faults.h"

namespace plumbline::simulated {
namespace {

constexpr unsigned char kGarbage = 0xcb;
/// Of allocations; what lies between two of them belongs to nobody.
constexpr std::size_t kAlignment = 256;

/// Pages that cost nothing until they are first written.
std::uintptr_t reserve(std::size_t bytes, int protection) {
  void* address = mmap(nullptr, bytes, protection, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (address == MAP_FAILED) std::abort();
  return reinterpret_cast<std::uintptr_t>(address);
}

void protect(std::uintptr_t begin, std::uintptr_t end, int protection) {
  if (end > begin && mprotect(reinterpret_cast<void*>(begin), end - begin, protection) != 0) std::abort();
}

}  // namespace

Memory Memory::instance_;

Memory::Memory()
    : base_(reserve(3 * kSpaceBytes, PROT_NONE)),
      cells_(reinterpret_cast<Cell*>(reserve(3 * kSpaceBytes / 4 * sizeof(Cell), PROT_READ | PROT_WRITE))) {
  begin_anew();
}

void Memory::begin_anew() {
  const bool was_open = open_;
  if (was_open) close();
  for (std::size_t space = 0; space < 3; ++space) next_[space] = base_ + space * kSpaceBytes;
  if (was_open) open();
}

void* Memory::allocate(Space space, std::size_t bytes) {
  std::uintptr_t& next = next_[static_cast<std::size_t>(space)];
  const std::uintptr_t limit = base_ + (static_cast<std::size_t>(space) + 1) * kSpaceBytes;
  if (bytes > limit - next || limit - next - bytes < 2 * kPage) return nullptr;
  // At the end of its pages as far as alignment goes, so that what is beyond them is often not mapped at all.
  const std::size_t pages = (bytes + 2 * kAlignment + kPage - 1) / kPage * kPage;
  const std::uintptr_t begin = (next + pages - bytes - kAlignment) / kAlignment * kAlignment;
  protect(next, next + pages, PROT_READ | PROT_WRITE);
  std::memset(reinterpret_cast<void*>(begin), kGarbage, bytes);
  if (space == Space::device && !open_) protect(next, next + pages, PROT_NONE);
  next += pages;
  previous_ = nullptr;
  allocations_[begin] = {begin, bytes, space, 0};
  return reinterpret_cast<void*>(begin);
}

bool Memory::free(Space space, void* address) {
  const auto found = allocations_.find(reinterpret_cast<std::uintptr_t>(address));
  if (found == allocations_.end() || found->second.space != space) return false;
  Allocation& allocation = found->second;
  forget(allocation, 0);
  // Whole pages go back to the system; the addresses are used again only once nothing is allocated.
  const std::uintptr_t first = (allocation.begin + kPage - 1) / kPage * kPage,
                       last = (allocation.begin + allocation.bytes) / kPage * kPage;
  if (last > first) madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
  allocations_.erase(found);
  previous_ = nullptr;
  if (allocations_.empty()) begin_anew();
  return true;
}

Allocation* Memory::search(std::uintptr_t address) {
  auto next = allocations_.upper_bound(address);
  if (next == allocations_.begin()) return nullptr;
  Allocation& candidate = std::prev(next)->second;
  if (address - candidate.begin >= candidate.bytes) return nullptr;
  return previous_ = &candidate;
}

void Memory::forget(Allocation& allocation, Stamp written) {
  allocation.written = written;
  Cell *first = &cell(allocation.begin), *last = &cell(allocation.begin + allocation.bytes + 3);
  const auto begin = (reinterpret_cast<std::uintptr_t>(first) + kPage - 1) / kPage * kPage,
             end = reinterpret_cast<std::uintptr_t>(last) / kPage * kPage;
  if (end <= begin + 16 * kPage) {
    std::fill(first, last, Cell());
    return;
  }
  madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
  std::memset(static_cast<void*>(first), 0, begin - reinterpret_cast<std::uintptr_t>(first));
  std::memset(reinterpret_cast<void*>(end), 0, reinterpret_cast<std::uintptr_t>(last) - end);
}

void Memory::open() {
  if (!open_) protect(base_, next_[0], PROT_READ | PROT_WRITE);
  open_ = true;
}

void Memory::close() {
  if (open_) protect(base_, next_[0], PROT_NONE);
  open_ = false;
}

std::string describe(std::uintptr_t address) {
  static const char* const kNames[] = {"the device's memory", "pinned memory", "managed memory"};
  Memory& memory = Memory::get();
  if (const Allocation* found = memory.find(address))
    return "byte " + std::to_string(address - found->begin) + " of an allocation of " + std::to_string(found->bytes) +
           " bytes in " + kNames[static_cast<std::size_t>(found->space)];
  if (memory.contains(address)) return "an address that belongs to no allocation (or no longer)";
  return "the host's memory";
}

}  // namespace plumbline::simulated
