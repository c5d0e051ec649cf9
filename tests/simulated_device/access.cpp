#include "simulated_device/access.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "simulated_device/blocks.h"
#include "simulated_device/faults.h"
#include "simulated_device/memory.h"
#include "simulated_device/order.h"

namespace plumbline::simulated {
namespace {

/// Who touches, for the sentence; made only where it is needed.
struct Who {
  const void* instruction;
  const char* operation;
  std::string text() const { return operation != nullptr ? operation : name_of(instruction); }
};

/// Keeps a sentence that `text` makes. It is the simulation's own work, whatever runs.
template <class Text>
void tell(const Text& text) {
  if (enough_is_reported()) return;
  const bool in_kernel = std::exchange(now_running.in_kernel, false);
  report(text());
  now_running.in_kernel = in_kernel;
}

const char* verb(Access kind) {
  return kind == Access::read ? "reads" : kind == Access::write ? "writes" : "atomically changes";
}

/// The pieces of an address range, a word each: the word's address and a bit for each of its bytes.
template <class Piece>
void for_words(std::uintptr_t address, std::size_t bytes, const Piece& piece) {
  if (bytes == 4 && address % 4 == 0) return piece(address, 15U);
  for (std::uintptr_t end = address + bytes; address < end;) {
    const std::uintptr_t word = address & ~std::uintptr_t{3}, next = std::min<std::uintptr_t>(word + 4, end);
    piece(word, ((1U << (next - word)) - 1U) & ~((1U << (address - word)) - 1U));
    address = next;
  }
}

std::string place(std::uintptr_t word) {
  return word - running().shared < running().shared_bytes ? " (shared memory)" : " (" + describe(word) + ")";
}

void race(std::uintptr_t word, Access kind, const char* other, const Who& who) {
  tell([&] {
    return who.text() + " " + verb(kind) + " what " + other + " and no barrier or event is between" + place(word);
  });
}

bool collides(Stamp earlier, unsigned bytes, bool is_atomic) {
  if ((earlier & bytes) == 0 || (is_atomic && (earlier & 16U) != 0)) return false;
  return !Order::get().is_before(earlier);
}

void remember_read(Cell& cell, Stamp now) {
  for (Stamp& read : cell.reads) {
    if ((read ^ now) < 16U) {  // the same but for the bytes
      read |= now;
      return;
    }
  }
  Stamp& replaced = cell.reads[0] == 0 || Order::get().is_before(cell.reads[0]) ? cell.reads[0] : cell.reads[1];
  replaced = now;
}

void check(std::uintptr_t word, unsigned bytes, Access kind, Cell& cell, const Who& who) {
  const Stamp now = Order::get().stamp(bytes, kind == Access::atomic);
  if (kind == Access::write && cell.write == now && cell.reads[0] == 0) return;
  if (cell.write == 0 && kind != Access::write && who.operation == nullptr)
    tell([&] { return who.text() + " " + verb(kind) + " what nobody has written" + place(word); });
  if (collides(cell.write, bytes, kind == Access::atomic)) race(word, kind, "another thread or operation writes", who);
  if (kind == Access::read) return remember_read(cell, now);
  for (Stamp& read : cell.reads) {
    if (read == 0) continue;
    if (collides(read, bytes, false)) race(word, kind, "another thread or operation reads", who);
    read = 0;
  }
  cell.write = (cell.write ^ now) < 16U ? cell.write | now : now;
}

/// In one of the arenas.
void check_arena(std::uintptr_t address, std::size_t bytes, Access kind, const Who& who) {
  if (bytes == 4 && address % 4 == 0) {  // most accesses; a word that somebody wrote belongs to an allocation
    Cell& cell = Memory::get().cell(address);
    if (cell.write != 0) return check(address, 15U, kind, cell, who);
  }
  Allocation* allocation = Memory::get().find(address);
  if (allocation == nullptr || address + bytes > allocation->begin + allocation->bytes) {
    tell([&] {
      return who.text() + " " + verb(kind) + " " + std::to_string(bytes) + " bytes at " + describe(address) +
             ", which are not all within it";
    });
    if (running().in_kernel) abandon();
    return;
  }
  for_words(address, bytes, [&](std::uintptr_t word, unsigned mask) {
    Cell& cell = Memory::get().cell(word);
    if (cell.write == 0) cell.write = allocation->written;
    check(word, mask, kind, cell, who);
  });
}

void check_shared(std::uintptr_t address, std::size_t bytes, Access kind, const Who& who) {
  const Running& now = running();
  if (address - now.dynamic_shared < kDynamicShared &&
      address - now.dynamic_shared + bytes > now.dynamic_shared_bytes) {
    tell([&] { return who.text() + " " + verb(kind) + " beyond the shared memory that its launch gives it"; });
    abandon();
  }
  for_words(address, bytes,
            [&](std::uintptr_t word, unsigned mask) { check(word, mask, kind, shared_cell(word), who); });
}

void from_host(std::uintptr_t address, std::size_t bytes, Access kind, const Who& who) {
  Memory& memory = Memory::get();
  if (!memory.contains(address)) return;
  if (memory.is_device(address)) {
    tell([&] { return who.text() + ", the host's code, " + verb(kind) + " " + describe(address); });
    return;
  }
  Order::get().host_accesses();
  check_arena(address, bytes, kind, who);
}

}  // namespace

void access(const void* pointer, std::size_t bytes, Access kind, const void* instruction) {
  const auto address = reinterpret_cast<std::uintptr_t>(pointer);
  const Running& now = running();
  const Who who{instruction, nullptr};
  if (!now.in_kernel) return from_host(address, bytes, kind, who);
  if (address - now.stack < now.stack_bytes) return;
  if (Memory::get().contains(address)) return check_arena(address, bytes, kind, who);
  if (address - now.shared < now.shared_bytes) return check_shared(address, bytes, kind, who);
  if (kind == Access::read && (address - now.parameters < now.parameter_bytes || is_constant(address))) return;
  tell([&] { return who.text() + " " + verb(kind) + " the host's memory in a kernel"; });
  abandon();
}

void access_range(const void* address, std::size_t bytes, Access kind, const char* operation) {
  if (bytes > 0 && Memory::get().contains(reinterpret_cast<std::uintptr_t>(address)))
    check_arena(reinterpret_cast<std::uintptr_t>(address), bytes, kind, {nullptr, operation});
}

}  // namespace plumbline::simulated
