// cuda.cu and the kernels are compiled with -fsanitize=thread, which puts a call before each access to memory, but they
// are linked with these functions in the place of ThreadSanitizer's library. Names and meaning: LLVM's
// compiler-rt/lib/tsan/rtl/tsan_interface.h.
#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "simulated_device/access.h"
#include "simulated_device/blocks.h"
#include "simulated_device/device.h"
#include "simulated_device/faults.h"
#include "simulated_device/memory.h"

namespace plumbline::simulated {
namespace {

std::vector<std::string> faults;
int reports = 0;

void say(const char* text) {
  if (write(STDERR_FILENO, text, std::strlen(text)) < 0) std::abort();
}

/// The host touched the device's memory in code that is not instrumented: says so before the process ends.
void on_fault(int signal_number, siginfo_t* info, void*) {
  if (is_device_address(info->si_addr)) {
    say("simulated device: the host's code touched ");
    say(describe(reinterpret_cast<std::uintptr_t>(info->si_addr)).c_str());
    say("\n");
    void* frames[12];
    backtrace_symbols_fd(frames, backtrace(frames, 12), STDERR_FILENO);
  }
  signal(signal_number, SIG_DFL);
}

[[gnu::constructor]] void watch_addresses() {
  struct sigaction action {};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSEGV, &action, nullptr);
}

}  // namespace

void report(const std::string& sentence) {
  ++reports;
  // The same for another byte of the memory that the brackets name is the same.
  const auto begins_alike = [what = sentence.substr(0, sentence.find(" ("))](const std::string& fault) {
    return fault.starts_with(what);
  };
  if (faults.size() < 20 && std::none_of(faults.begin(), faults.end(), begins_alike)) faults.push_back(sentence);
}

bool enough_is_reported() { return reports > 1000; }

std::vector<std::string> take_faults() {
  reports = 0;
  return std::exchange(faults, {});
}

std::string name_of(const void* instruction) {
  Dl_info info{};
  char offset[32] = "?";
  if (dladdr(instruction, &info) == 0 || info.dli_sname == nullptr) {
    std::snprintf(offset, sizeof offset, "%p", instruction);
    return offset;
  }
  int status = 0;
  char* plain = abi::__cxa_demangle(info.dli_sname, nullptr, nullptr, &status);
  std::string name = status == 0 ? plain : info.dli_sname;
  std::free(plain);
  // Names of templates begin with what they return and end with their parameters.
  if (name.starts_with("void ")) name.erase(0, 5);
  std::string::size_type depth = 0, end = 0;
  for (; end < name.size() && !(depth == 0 && name[end] == '('); ++end)
    depth += name[end] == '<' ? 1U : name[end] == '>' ? std::string::size_type(-1) : 0U;
  for (std::string::size_type at; (at = name.find("plumbline::")) < end; end -= 11) name.erase(at, 11);
  std::snprintf(offset, sizeof offset, "+0x%tx",
                static_cast<const char*>(instruction) - static_cast<const char*>(info.dli_saddr));
  return name.substr(0, end) + offset;
}

}  // namespace plumbline::simulated

using plumbline::simulated::Access;
using plumbline::simulated::access;

extern "C" {

void __tsan_init() {}
void __tsan_func_entry(void*) {}
void __tsan_func_exit() {}

#define PL_ACCESS(name, bytes, kind) \
  void name(void* address) { access(address, bytes, Access::kind, __builtin_return_address(0)); }
PL_ACCESS(__tsan_read1, 1, read)
PL_ACCESS(__tsan_read2, 2, read)
PL_ACCESS(__tsan_read4, 4, read)
PL_ACCESS(__tsan_read8, 8, read)
PL_ACCESS(__tsan_read16, 16, read)
PL_ACCESS(__tsan_write1, 1, write)
PL_ACCESS(__tsan_write2, 2, write)
PL_ACCESS(__tsan_write4, 4, write)
PL_ACCESS(__tsan_write8, 8, write)
PL_ACCESS(__tsan_write16, 16, write)
PL_ACCESS(__tsan_unaligned_read2, 2, read)
PL_ACCESS(__tsan_unaligned_read4, 4, read)
PL_ACCESS(__tsan_unaligned_read8, 8, read)
PL_ACCESS(__tsan_unaligned_read16, 16, read)
PL_ACCESS(__tsan_unaligned_write2, 2, write)
PL_ACCESS(__tsan_unaligned_write4, 4, write)
PL_ACCESS(__tsan_unaligned_write8, 8, write)
PL_ACCESS(__tsan_unaligned_write16, 16, write)
PL_ACCESS(__tsan_volatile_read1, 1, read)
PL_ACCESS(__tsan_volatile_write1, 1, write)
#undef PL_ACCESS

void __tsan_read_range(void* address, std::size_t bytes) {
  access(address, bytes, Access::read, __builtin_return_address(0));
}
void __tsan_write_range(void* address, std::size_t bytes) {
  access(address, bytes, Access::write, __builtin_return_address(0));
}
void __tsan_vptr_update(void** address, void*) {
  access(address, sizeof *address, Access::write, __builtin_return_address(0));
}

// Reference counts of the host's shared pointers, and the guards of its static variables.
int __tsan_atomic32_fetch_add(volatile int* address, int value, int) {
  return __atomic_fetch_add(address, value, __ATOMIC_SEQ_CST);
}
int __tsan_atomic32_load(const volatile int* address, int) { return __atomic_load_n(address, __ATOMIC_SEQ_CST); }
char __tsan_atomic8_load(const volatile char* address, int) { return __atomic_load_n(address, __ATOMIC_SEQ_CST); }
long __tsan_atomic64_load(const volatile long* address, int) { return __atomic_load_n(address, __ATOMIC_SEQ_CST); }

// Of copies and fillings that stay calls (cuda_backend.cpp names these functions).
void* simulated_memcpy(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) {
    access(from, bytes, Access::read, __builtin_return_address(0));
    access(to, bytes, Access::write, __builtin_return_address(0));
  }
  return std::memcpy(to, from, bytes);
}
void* simulated_memmove(void* to, const void* from, std::size_t bytes) {
  if (bytes > 0) {
    access(from, bytes, Access::read, __builtin_return_address(0));
    access(to, bytes, Access::write, __builtin_return_address(0));
  }
  return std::memmove(to, from, bytes);
}
void* simulated_memset(void* to, int value, std::size_t bytes) {
  if (bytes > 0) access(to, bytes, Access::write, __builtin_return_address(0));
  return std::memset(to, value, bytes);
}

}  // extern "C"
