#include "backend/cpu/cpu.h"

#include <array>

#include "backend/cpu/lanes.h"
#include "backend/cpu/scan.h"
#include "kernels/sparse_bricks.h"
#include "plumbline/error.h"

namespace plumbline {
namespace cpu {
namespace {

struct InstructionSet {
  const char* name;
  bool (*available)();
  Backend* (*make)(int threads, const char* instruction_set);
};

/// AVX-512 as of Ice Lake and Zen 4 (VBMI2 came with them): older processors slow their clock down for it.
bool has_avx512() {
  return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512cd") != 0 &&
         __builtin_cpu_supports("avx512dq") != 0 && __builtin_cpu_supports("avx512bw") != 0 &&
         __builtin_cpu_supports("avx512vl") != 0 && __builtin_cpu_supports("avx512vbmi2") != 0;
}

/// The widest first.
constexpr std::array<InstructionSet, 3> kInstructionSets = {{
    {"avx512", has_avx512, make_lanes_avx512},
    {"avx2+fma", [] { return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0; },
     make_lanes_avx2},
    {"sse4.2", [] { return __builtin_cpu_supports("sse4.2") != 0; }, make_lanes_sse4_2},
}};

}  // namespace

LanesBase::LanesBase(int threads, const char* instruction_set) : threads_(threads), instruction_set_(instruction_set) {}
LanesBase::~LanesBase() = default;

const FineFusionStages* LanesBase::fine_fusion() const { return this; }

std::string LanesBase::name() const { return "cpu"; }

std::string LanesBase::description() const {
  const int n = threads_.count();
  return std::string("cpu (") + instruction_set_ + ", " + std::to_string(n) + (n == 1 ? " thread)" : " threads)");
}

std::shared_ptr<void> LanesBase::allocate(std::size_t bytes) const { return memory_.allocate(bytes); }
void LanesBase::upload(void* device, const void* host, std::size_t bytes) const { memory_.upload(device, host, bytes); }
void LanesBase::download(void* host, const void* device, std::size_t bytes) const {
  memory_.download(host, device, bytes);
}
void LanesBase::clear(void* device, std::size_t bytes) const { memory_.clear(device, bytes); }

IcpSums LanesBase::reduce(const kernels::IcpReduce& kernel) const {
  IcpSums sums;
  sums.histogram.resize(static_cast<std::size_t>(kernel.in.bins) + 2);
  if (kernel.in.bins > 0) sums.bin_width = 1.0 / static_cast<double>(kernel.in.bins_per_metre);
  reduce_into(kernel, sums.slots, sums.histogram.data());
  sums.histogram.pop_back();  // what was no pair
  return sums;
}

DepthComparison LanesBase::reduce(const kernels::CompareDepth& kernel) const {
  DepthComparison sums;
  reduce_into(kernel, sums.slots);
  return sums;
}

void LanesBase::correct(const kernels::IcpCorrection& kernel, IcpSums* sums) const {
  double changes[kernels::icp_sum::kCount];
  reduce_into(kernel, changes);
  for (int slot = 0; slot < kernels::icp_sum::kCount; ++slot) sums->slots[slot] += changes[slot];
}

int LanesBase::compact(const std::int32_t* flags, int count, std::int32_t* list) const {
  return cpu::compact(threads_, flags, count, list);
}
void LanesBase::integrate_marked(const kernels::Integrate& kernel, const std::int32_t* flags, int count,
                                 std::int32_t* list, std::int32_t* listed) const {
  *listed = compact(flags, count, list);
  integrate_listed(kernel, list, *listed);
}

std::int64_t LanesBase::scan(std::int32_t* values, int count) const { return cpu::scan(threads_, values, count); }

void LanesBase::run(const kernels::TakeBrick& kernel, int entries) const {
  threads_.run(entries, [&](int entry, int) { kernel(entry); });
}
void LanesBase::run(const kernels::PutBrick& kernel, int entries) const {
  threads_.run(entries, [&](int entry, int) { kernel(entry); });
}
void LanesBase::run(const kernels::CountBrick& kernel, int entries) const {
  threads_.run(entries, [&](int entry, int) { kernel(entry); });
}
void LanesBase::run(const kernels::WriteBrick& kernel, int entries) const {
  threads_.run(entries, [&](int entry, int) { kernel(entry); });
}

void LanesBase::run(const kernels::CountFineBrick& kernel, int entries) const {
  threads_.run(entries, [&](int entry, int) { kernel(entry); });
}
void LanesBase::run(const kernels::WriteFineBrick& kernel, int entries) const {
  threads_.run(entries, [&](int entry, int) { kernel(entry); });
}

}  // namespace cpu

std::vector<std::string> cpu_instruction_sets() {
  std::vector<std::string> result;
  for (const cpu::InstructionSet& set : cpu::kInstructionSets) {
    if (set.available()) result.emplace_back(set.name);
  }
  return result;
}

std::unique_ptr<Backend> make_cpu_backend(int threads, const std::string& instruction_set) {
  for (const cpu::InstructionSet& set : cpu::kInstructionSets) {
    if ((instruction_set.empty() || instruction_set == set.name) && set.available())
      return std::unique_ptr<Backend>(set.make(threads, set.name));
  }
  std::string available;
  for (const std::string& name : cpu_instruction_sets()) available += (available.empty() ? "" : ", ") + name;
  throw Error("this processor does not have the instruction set" +
                  (instruction_set.empty() ? " SSE4.2" : ": " + instruction_set),
              "cpu backend", available.empty() ? "use a processor of 2009 or later" : "available here: " + available);
}

std::string cpu_description() {
  const std::vector<std::string> sets = cpu_instruction_sets();
  return sets.empty() ? "this processor lacks SSE4.2" : "oneTBB threads, " + sets.front() + " lanes";
}

}  // namespace plumbline
