#include "simulated_device/blocks.h"

#include <link.h>
#include <sys/mman.h>

#include <algorithm>
#include <boost/context/detail/fcontext.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <vector>

#include "core/random.h"
#include "simulated_device/access.h"
#include "simulated_device/faults.h"
#include "simulated_device/order.h"

namespace plumbline::cuda {
/// The shared memory of a launch's own size, which launch.cuh declares.
alignas(16) thread_local std::int32_t counts[simulated::kDynamicShared / 4];
}  // namespace plumbline::cuda

namespace plumbline::simulated {

Running now_running;

namespace {

namespace context = boost::context::detail;

constexpr unsigned char kGarbage = 0xcb;
constexpr std::size_t kStackBytes = std::size_t{128} << 10;

/// Where a thread waits; those that wait for each other must do so at the same kind of place.
enum class Wait : std::uint8_t { nothing, warp, warp_sum, block, block_or, block_sum, grid, end };
bool is_of_warp(Wait wait) { return wait == Wait::warp || wait == Wait::warp_sum; }
const char* name_of(Wait wait) {
  static const char* const kNames[] = {"nothing",          "__syncwarp",     "cub::WarpReduce", "__syncthreads",
                                       "__syncthreads_or", "cub::BlockScan", "the grid's sync", "the kernel's end"};
  return kNames[static_cast<std::size_t>(wait)];
}

union Value {
  float real;
  double wide;
  long long integer;
};

struct Thread {
  context::fcontext_t resume = nullptr;
  Wait wait = Wait::nothing;
  Value given{};                  ///< to the others that wait
  const void* storage = nullptr;  ///< of CUB, that it waits with
};

/// Who used a piece of CUB's storage, and since which barrier.
struct Use {
  std::uint32_t segment;
  int warp, warp_phase;
};

struct Block {
  int index = 0;
  std::uint32_t segment = 0;
  std::vector<Thread> threads;
  std::vector<Value> taken;  ///< what the threads gave where they met
  std::vector<int> warp_phases;
  std::vector<char*> stacks;
  bool any = false, result = false;  ///< of __syncthreads_or
  std::map<const void*, Use> uses;
  std::vector<char> shared;  ///< contents while another block runs
  std::vector<Cell> cells;   ///< of shared memory
  std::vector<std::uint32_t> touched;
};

/// What the loader knows about the library that this is part of.
struct Module {
  std::uintptr_t shared = 0;  ///< its thread-local memory, all of which are kernels' shared variables
  std::size_t shared_bytes = 0;
  std::vector<std::pair<std::uintptr_t, std::size_t>> constants;
};

int look_at_module(dl_phdr_info* info, std::size_t, void* out) {
  Module found;
  bool is_this = false;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& segment = info->dlpi_phdr[i];
    const std::uintptr_t begin = info->dlpi_addr + segment.p_vaddr;
    if (segment.p_type == PT_TLS)
      found.shared = reinterpret_cast<std::uintptr_t>(info->dlpi_tls_data), found.shared_bytes = segment.p_memsz;
    if (segment.p_type != PT_LOAD) continue;
    is_this = is_this || reinterpret_cast<std::uintptr_t>(&look_at_module) - begin < segment.p_memsz;
    if ((segment.p_flags & PF_W) == 0) found.constants.emplace_back(begin, segment.p_memsz);
  }
  if (is_this) *static_cast<Module*>(out) = found;
  return is_this ? 1 : 0;
}

const Module& module() {
  static const Module found = [] {
    Module m;
    dl_iterate_phdr(look_at_module, &m);
    return m;
  }();
  return found;
}

/// Stacks of fibers, each above a page that nobody may touch.
class Stacks {
 public:
  char* take() {
    if (free_.empty()) free_.push_back(make());
    char* stack = free_.back();
    free_.pop_back();
    return stack;
  }
  void give_back(char* stack) { free_.push_back(stack); }

 private:
  static char* make() {
    constexpr std::size_t kPage = 4096;
    void* memory =
        mmap(nullptr, kStackBytes + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED || mprotect(memory, kPage, PROT_NONE) != 0) std::abort();
    return static_cast<char*>(memory) + kPage;
  }
  std::vector<char*> free_;
};

/// A kernel that runs.
class Grid {
 public:
  Grid(const std::string& name, const Shape& shape, int resident, const Call& call, std::uint64_t seed);
  ~Grid();
  Grid(const Grid&) = delete;
  Grid& operator=(const Grid&) = delete;
  bool run();
  std::size_t touched_shared() const { return touched_shared_; }

  // Called on a thread's fiber.
  [[noreturn]] void end_thread();
  void wait(Wait wait, Value given = {}, const void* storage = nullptr);
  void abandon() {
    is_broken_ = true;
    end_thread();
  }
  bool give_predicate(bool predicate) {
    block_->any = block_->any || predicate;
    wait(Wait::block_or);
    return block_->result;
  }
  int thread() const { return thread_; }
  const std::vector<Value>& taken() const { return block_->taken; }
  Cell& shared_cell(std::uintptr_t address);
  const Call& call() const { return call_; }
  int block() const { return block_->index; }
  const Shape& shape() const { return shape_; }

 private:
  int below(std::size_t count) { return random_.below(static_cast<int>(count)); }
  void start_block();
  void finish_block(std::size_t at);
  void switch_to(Block* block);
  void resume_warp(int warp);
  void resume(int thread);
  bool run_block();
  void meet_in_warp(int warp);
  bool meet_in_block();
  bool all_wait(int first, int last, Wait wait) const;
  void check_storage(int first, int last, bool is_warp);
  void fill_garbage(Block& block);
  void diverged(int first, int last);
  void pass_grid();

  const std::string& name_;
  const Shape& shape_;
  std::size_t resident_;
  const Call& call_;
  Random random_;
  int threads_;
  std::vector<int> order_;  ///< blocks to come, the next one at the back
  std::vector<std::unique_ptr<Block>> blocks_;
  Block* block_ = nullptr;
  int thread_ = 0;
  context::fcontext_t scheduler_ = nullptr;
  bool is_broken_ = false;
  std::size_t touched_shared_ = 0;
  static Stacks stacks_;
};

Stacks Grid::stacks_;
Grid* grid = nullptr;

void thread_main(context::transfer_t from) {
  *static_cast<context::fcontext_t*>(from.data) = from.fctx;
  grid->call().run();
  grid->end_thread();
}

Grid::Grid(const std::string& name, const Shape& shape, int resident, const Call& call, std::uint64_t seed)
    : name_(name),
      shape_(shape),
      resident_(static_cast<std::size_t>(resident)),
      call_(call),
      random_(seed),
      threads_(static_cast<int>(shape.block.x * shape.block.y * shape.block.z)),
      order_(std::size_t{shape.grid.x} * shape.grid.y * shape.grid.z) {
  std::iota(order_.begin(), order_.end(), 0);
  for (std::size_t i = order_.size(); i > 1; --i) std::swap(order_[i - 1], order_[static_cast<std::size_t>(below(i))]);
  now_running.shared = module().shared;
  now_running.shared_bytes = module().shared_bytes;
  now_running.dynamic_shared = reinterpret_cast<std::uintptr_t>(cuda::counts);
  now_running.dynamic_shared_bytes = shape.dynamic_shared;
  now_running.parameters = reinterpret_cast<std::uintptr_t>(&call);
  now_running.parameter_bytes = call.bytes();
  now_running.stack_bytes = kStackBytes;
  grid = this;
}

Grid::~Grid() {
  for (const auto& block : blocks_)
    for (char* stack : block->stacks) stacks_.give_back(stack);
  grid = nullptr;
}

Cell& Grid::shared_cell(std::uintptr_t address) {
  const std::size_t word = (address - now_running.shared) / 4;
  if (block_->cells.empty()) block_->cells.resize(module().shared_bytes / 4 + 1);
  Cell& cell = block_->cells[word];
  if (cell.write == 0 && cell.reads[0] == 0) block_->touched.push_back(static_cast<std::uint32_t>(word));
  return cell;
}

void Grid::start_block() {
  auto block = std::make_unique<Block>();
  block->index = order_.back();
  order_.pop_back();
  const auto count = static_cast<std::size_t>(threads_);
  block->threads.resize(count);
  block->taken.resize((count + kWarp - 1) / kWarp * kWarp);
  block->warp_phases.resize((count + kWarp - 1) / kWarp);
  block->segment = Order::get().new_segment(block->index);
  for (Thread& thread : block->threads) {
    block->stacks.push_back(stacks_.take());
    thread.resume = context::make_fcontext(block->stacks.back() + kStackBytes, kStackBytes, thread_main);
  }
  blocks_.push_back(std::move(block));
}

/// Shared memory begins with what others left there, which must be nothing that looks like a value.
void Grid::fill_garbage(Block& block) {
  std::size_t declared = 0;
  for (const std::uint32_t word : block.touched) {
    const std::uintptr_t address = module().shared + std::uintptr_t{word} * 4;
    std::memset(reinterpret_cast<void*>(address), kGarbage, 4);
    declared += address - now_running.dynamic_shared >= sizeof cuda::counts ? 4 : 0;
  }
  touched_shared_ = std::max(touched_shared_, declared);
}

void Grid::finish_block(std::size_t at) {
  fill_garbage(*blocks_[at]);
  for (char* stack : blocks_[at]->stacks) stacks_.give_back(stack);
  block_ = nullptr;
  blocks_.erase(blocks_.begin() + static_cast<std::ptrdiff_t>(at));
}

void Grid::switch_to(Block* block) {
  if (block_ == block) return;
  auto* shared = reinterpret_cast<char*>(module().shared);
  const std::size_t dynamic = now_running.dynamic_shared - module().shared, bytes = module().shared_bytes;
  // What is declared lies before and after the memory of the launch's own size, of which only a part is used.
  const std::size_t used = dynamic + shape_.dynamic_shared, after = dynamic + sizeof cuda::counts;
  if (block_ != nullptr) {
    block_->shared.assign(shared, shared + used);
    block_->shared.insert(block_->shared.end(), shared + after, shared + bytes);
  }
  if (block->shared.empty()) {
    std::memset(shared, kGarbage, used);
    std::memset(shared + after, kGarbage, bytes - after);
  } else {
    std::memcpy(shared, block->shared.data(), used);
    std::memcpy(shared + after, block->shared.data() + used, bytes - after);
  }
  block_ = block;
}

void Grid::resume(int thread) {
  thread_ = thread;
  const auto t = static_cast<std::size_t>(thread);
  Order::get().run(block_->segment, block_->index, thread, block_->warp_phases[t / kWarp]);
  now_running.stack = reinterpret_cast<std::uintptr_t>(block_->stacks[t]);
  block_->threads[t].wait = Wait::nothing;
  now_running.in_kernel = true;
  const context::transfer_t back = context::jump_fcontext(block_->threads[t].resume, &scheduler_);
  now_running.in_kernel = false;
  block_->threads[t].resume = back.fctx;
}

void Grid::wait(Wait wait, Value given, const void* storage) {
  Thread& thread = block_->threads[static_cast<std::size_t>(thread_)];
  thread.wait = wait;
  thread.given = given;
  thread.storage = storage;
  scheduler_ = context::jump_fcontext(scheduler_, nullptr).fctx;
}

void Grid::end_thread() {
  block_->threads[static_cast<std::size_t>(thread_)].wait = Wait::end;
  context::jump_fcontext(scheduler_, nullptr);
  std::abort();  // nobody resumes it
}

bool Grid::all_wait(int first, int last, Wait wait) const {
  return std::all_of(block_->threads.begin() + first, block_->threads.begin() + last,
                     [wait](const Thread& thread) { return thread.wait == wait; });
}

void Grid::diverged(int first, int last) {
  std::vector<int> counts(8);
  for (int i = first; i < last; ++i)
    ++counts[static_cast<std::size_t>(block_->threads[static_cast<std::size_t>(i)].wait)];
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] != 0)
      text += (text.empty() ? "" : ", ") + std::to_string(counts[i]) + " at " + name_of(static_cast<Wait>(i));
  }
  report(name_ + ": threads wait for each other at different places: " + text);
  is_broken_ = true;
}

/// CUB's storage may be used again only past a barrier of those who used it.
void Grid::check_storage(int first, int last, bool is_warp) {
  const void* storage = block_->threads[static_cast<std::size_t>(first)].storage;
  for (int i = first; i < last; ++i) {
    if (block_->threads[static_cast<std::size_t>(i)].storage != storage)
      report(name_ + ": threads of a collective call give different storage");
  }
  const int warp = is_warp ? first / kWarp : -1,
            phase = is_warp ? block_->warp_phases[static_cast<std::size_t>(warp)] : 0;
  const auto [use, is_new] = block_->uses.try_emplace(storage, Use{block_->segment, warp, phase});
  if (is_new) return;
  if (use->second.segment == block_->segment && (use->second.warp != warp || use->second.warp_phase == phase))
    report(name_ + ": the storage of a collective call is used again without a barrier");
  use->second = {block_->segment, warp, phase};
}

void Grid::meet_in_warp(int warp) {
  const int first = warp * kWarp, last = std::min(first + kWarp, threads_);
  const Wait wait = block_->threads[static_cast<std::size_t>(first)].wait;
  const auto waits_in_warp = [](const Thread& thread) { return is_of_warp(thread.wait); };
  if (std::none_of(block_->threads.begin() + first, block_->threads.begin() + last, waits_in_warp)) return;
  if (!all_wait(first, last, wait)) return diverged(first, last);
  if (wait == Wait::warp_sum) check_storage(first, last, true);
  if (wait == Wait::warp) ++block_->warp_phases[static_cast<std::size_t>(warp)];
  for (int i = first; i < last; ++i) {
    Thread& thread = block_->threads[static_cast<std::size_t>(i)];
    block_->taken[static_cast<std::size_t>(i)] = thread.given;
    thread.wait = Wait::nothing;
  }
}

void Grid::resume_warp(int warp) {
  const int first = warp * kWarp, lanes = std::min(kWarp, threads_ - first);
  // An order of the lanes: steps of an odd number around a circle of 32.
  const int start = below(kWarp), step = 2 * below(kWarp / 2) + 1;
  for (int i = 0; i < kWarp && !is_broken_; ++i) {
    const int lane = (start + i * step) % kWarp;
    if (lane < lanes) resume(first + lane);
  }
  if (!is_broken_) meet_in_warp(warp);
}

/// Whether the block's threads all met; if not they all wait for other blocks or have ended.
bool Grid::meet_in_block() {
  const Wait wait = block_->threads.front().wait;
  if (!all_wait(0, threads_, wait)) {
    diverged(0, threads_);
    return false;
  }
  if (wait == Wait::grid || wait == Wait::end) return false;
  if (wait == Wait::block_sum) {
    check_storage(0, threads_, false);
  } else {
    block_->segment = Order::get().new_segment(block_->index);
  }
  block_->result = block_->any;
  block_->any = false;
  for (std::size_t i = 0; i < block_->threads.size(); ++i) {
    block_->taken[i] = block_->threads[i].given;
    block_->threads[i].wait = Wait::nothing;
  }
  return true;
}

/// The threads of a block, warp by warp in any order, until all wait.
bool Grid::run_block() {
  std::vector<int> runnable(block_->warp_phases.size());
  std::iota(runnable.begin(), runnable.end(), 0);
  while (!runnable.empty()) {
    const auto at = static_cast<std::size_t>(below(runnable.size()));
    const int warp = runnable[at];
    resume_warp(warp);
    if (is_broken_) return false;
    if (block_->threads[static_cast<std::size_t>(warp) * kWarp].wait == Wait::nothing) continue;
    runnable[at] = runnable.back();
    runnable.pop_back();
  }
  return meet_in_block();
}

void Grid::pass_grid() {
  Order::get().grid_barrier();
  for (const auto& block : blocks_) {
    block->segment = Order::get().new_segment(block->index);
    for (Thread& thread : block->threads) thread.wait = Wait::nothing;
  }
}

bool Grid::run() {
  while (!is_broken_) {
    while (blocks_.size() < resident_ && !order_.empty()) start_block();
    std::vector<std::size_t> ready;
    for (std::size_t i = 0; i < blocks_.size(); ++i)
      if (blocks_[i]->threads.front().wait != Wait::grid) ready.push_back(i);
    if (blocks_.empty()) return true;
    if (ready.empty() && !order_.empty()) {
      report(name_ + ": blocks wait for others that no processor has room for");
      return false;
    }
    if (ready.empty()) {
      pass_grid();
      continue;
    }
    const std::size_t at = ready[static_cast<std::size_t>(below(ready.size()))];
    switch_to(blocks_[at].get());
    // On to the next barrier; now and then past several of them while the others stand.
    while (run_block() && random_.uniform() < 0.7) {
    }
    if (!is_broken_ && block_->threads.front().wait == Wait::end) finish_block(at);
  }
  return false;
}

unsigned size_of(const dim3& size, int axis) { return axis == 0 ? size.x : axis == 1 ? size.y : size.z; }

/// Of number i, x first.
unsigned component_of(int i, const dim3& size, int axis) {
  const auto u = static_cast<unsigned>(i);
  return axis == 0 ? u % size.x : axis == 1 ? u / size.x % size.y : u / size.x / size.y;
}

template <class T, class Member>
T sum_lanes(const std::vector<Value>& values, int first, const Member& member) {
  T sums[kWarp];
  for (int lane = 0; lane < kWarp; ++lane) sums[lane] = member(values[static_cast<std::size_t>(first + lane)]);
  for (int offset = 1; offset < kWarp; offset *= 2) {
    for (int lane = 0; lane + offset < kWarp; ++lane) sums[lane] += sums[lane + offset];
  }
  return sums[0];
}

}  // namespace

bool run_blocks(const std::string& name, const Shape& shape, int resident, const Call& call, std::uint64_t seed,
                std::size_t* touched_shared) {
  Grid running_grid(name, shape, resident, call, seed);
  const bool succeeded = running_grid.run();
  *touched_shared = running_grid.touched_shared();
  return succeeded;
}

bool is_constant(std::uintptr_t address) {
  return std::any_of(module().constants.begin(), module().constants.end(),
                     [address](const auto& range) { return address - range.first < range.second; });
}

Cell& shared_cell(std::uintptr_t address) { return grid->shared_cell(address); }

void abandon() {
  grid->abandon();
  std::abort();
}

std::size_t declared_shared() { return module().shared_bytes - sizeof cuda::counts; }

unsigned thread_index(int axis) { return component_of(grid->thread(), grid->shape().block, axis); }
unsigned block_index(int axis) { return component_of(grid->block(), grid->shape().grid, axis); }
unsigned block_size(int axis) { return size_of(grid->shape().block, axis); }
unsigned grid_size(int axis) { return size_of(grid->shape().grid, axis); }

float sum_of_warp(float value, const void* storage) {
  Value given{};
  given.real = value;
  grid->wait(Wait::warp_sum, given, storage);
  if (grid->thread() % kWarp != 0) return std::numeric_limits<float>::quiet_NaN();
  return sum_lanes<float>(grid->taken(), grid->thread(), [](const Value& v) { return v.real; });
}

double sum_of_warp(double value, const void* storage) {
  Value given{};
  given.wide = value;
  grid->wait(Wait::warp_sum, given, storage);
  if (grid->thread() % kWarp != 0) return std::numeric_limits<double>::quiet_NaN();
  return sum_lanes<double>(grid->taken(), grid->thread(), [](const Value& v) { return v.wide; });
}

long long sum_before(long long value, long long* total, const void* storage) {
  Value given{};
  given.integer = value;
  grid->wait(Wait::block_sum, given, storage);
  long long before = 0, all = 0;
  for (int i = 0; i < static_cast<int>(grid->shape().block.x); ++i) {
    before = i == grid->thread() ? all : before;
    all += grid->taken()[static_cast<std::size_t>(i)].integer;
  }
  *total = all;
  return before;
}

void wait_for_grid() {
  if (!grid->shape().cooperative) {
    report("a kernel that was not launched cooperatively waits for its grid");
    abandon();
  }
  grid->wait(Wait::grid);
}

}  // namespace plumbline::simulated

using plumbline::simulated::Access;

void __syncthreads() { plumbline::simulated::grid->wait(plumbline::simulated::Wait::block); }
int __syncthreads_or(int predicate) { return plumbline::simulated::grid->give_predicate(predicate != 0) ? 1 : 0; }
void __syncwarp(unsigned lanes) {
  if (lanes != 0xffffffffU) plumbline::simulated::report("__syncwarp of some lanes is not simulated");
  plumbline::simulated::grid->wait(plumbline::simulated::Wait::warp);
}
int atomicAdd(int* address, int value) {
  plumbline::simulated::access(address, sizeof *address, Access::atomic, __builtin_return_address(0));
  const int old = *address;
  *address = old + value;
  return old;
}
int atomicMin(int* address, int value) {
  plumbline::simulated::access(address, sizeof *address, Access::atomic, __builtin_return_address(0));
  const int old = *address;
  *address = std::min(old, value);
  return old;
}
int atomicMax(int* address, int value) {
  plumbline::simulated::access(address, sizeof *address, Access::atomic, __builtin_return_address(0));
  const int old = *address;
  *address = std::max(old, value);
  return old;
}
