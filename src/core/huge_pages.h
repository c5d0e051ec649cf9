// Large memory by pages of 2 MiB, where the system has them.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace plumbline {

/// Asks for huge pages in memory that has not been touched yet: the first touch of many small ones costs as much as
/// reading a text file into them. A hint, without effect where the system does not take it.
inline void prefer_huge_pages(void* begin, std::size_t bytes) {
  constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
  const auto address = reinterpret_cast<std::uintptr_t>(begin);
  const std::uintptr_t first = (address + kPage - 1) / kPage * kPage, end = (address + bytes) / kPage * kPage;
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
}

/// reserve(), in huge pages.
template <class T>
void reserve_large(std::vector<T>* items, std::size_t count) {
  items->reserve(count);
  prefer_huge_pages(items->data(), items->capacity() * sizeof(T));
}

}  // namespace plumbline
