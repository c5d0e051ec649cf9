#include "backend/cuda/cuda.h"

#include <cuda_runtime.h>
#include <thrust/iterator/counting_iterator.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <cuda/std/functional>
#include <functional>
#include <limits>
#include <memory>
#include <new>

#include "backend/cuda/launch.cuh"
#include "backend/fine_fusion.h"
#include "kernels/fine_fusion.h"
#include "plumbline/error.h"

namespace plumbline {
namespace cuda {
namespace {

void check(cudaError_t status, const char* what) {
  if (status == cudaSuccess) return;
  cudaGetLastError();  // the error is told here and must not stick
  if (status == cudaErrorMemoryAllocation) throw std::bad_alloc();
  throw Error(std::string(what) + " failed: " + cudaGetErrorString(status), "cuda",
              "try again with --backend cpu; if that works, please report this");
}

/// Memory of the host that the device can write, and that copies need not stage.
template <class T>
class Pinned {
 public:
  explicit Pinned(std::size_t count) {
    void* address = nullptr;
    check(cudaMallocHost(&address, count * sizeof(T)), "cudaMallocHost");
    data_ = static_cast<T*>(address);
  }
  ~Pinned() { cudaFreeHost(data_); }
  Pinned(const Pinned&) = delete;
  Pinned& operator=(const Pinned&) = delete;
  T* get() const { return data_; }

 private:
  T* data_ = nullptr;
};

class Event {
 public:
  explicit Event(unsigned flags = cudaEventDisableTiming) {
    check(cudaEventCreateWithFlags(&event_, flags), "cudaEventCreate");
  }
  ~Event() { cudaEventDestroy(event_); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  operator cudaEvent_t() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

class Stream {
 public:
  Stream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate"); }
  ~Stream() { cudaStreamDestroy(stream_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  operator cudaStream_t() const { return stream_; }
  void wait() const { check(cudaStreamSynchronize(stream_), "waiting for the device"); }
  void wait_for(const Event& event) const { check(cudaStreamWaitEvent(stream_, event, 0), "cudaStreamWaitEvent"); }
  void record(const Event& event) const { check(cudaEventRecord(event, stream_), "cudaEventRecord"); }

 private:
  cudaStream_t stream_ = nullptr;
};

/// Blocks of a kernel and the threads of each; `shared_bytes` come beside what the kernel declares itself. Blocks of a
/// cooperative launch may wait for each other.
struct Shape {
  dim3 blocks, threads;
  std::size_t shared_bytes = 0;
  bool cooperative = false;
};

/// Puts a kernel on a stream; no block is no launch. A function where CUDA has <<<…>>>, so that any C++ compiler takes
/// it.
template <class... Parameters, class... Arguments>
void launch(const Stream& stream, const char* what, const Shape& shape, void (*kernel)(Parameters...),
            const Arguments&... arguments) {
  if (shape.blocks.x == 0 || shape.blocks.y == 0) return;
  cudaLaunchAttribute cooperative{};
  cooperative.id = cudaLaunchAttributeCooperative;
  cooperative.val.cooperative = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = shape.blocks;
  config.blockDim = shape.threads;
  config.dynamicSmemBytes = shape.shared_bytes;
  config.stream = stream;
  config.attrs = &cooperative;
  config.numAttrs = shape.cooperative ? 1 : 0;
  check(cudaLaunchKernelEx(&config, kernel, arguments...), what);
}

/// Blocks of `threads` that are enough for `count`.
dim3 blocks_for(int count, int threads) { return dim3(static_cast<unsigned>(divide_up(count, threads))); }
dim3 blocks_for_pixels(int width, int height) {
  return dim3(static_cast<unsigned>(divide_up(width, kTileColumns)),
              static_cast<unsigned>(divide_up(height, kTileRows)));
}

/// Device memory that grows to what is asked for and keeps no content.
class Scratch {
 public:
  ~Scratch() { cudaFree(data_); }
  template <class T>
  T* get(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (bytes > bytes_) {
      cudaFree(data_);  // waits until nothing uses it
      data_ = nullptr;
      bytes_ = 0;
      check(cudaMalloc(&data_, bytes), "cudaMalloc");
      bytes_ = bytes;
    }
    return static_cast<T*>(data_);
  }

 private:
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
};

/// Copies to the device that nobody waits for: what is sent is taken over at once, crosses the bus on a stream of its
/// own beside the work in hand, and is put in its place in the order of the work.
class Uploads {
 public:
  /// Larger ones are not worth the memory that is kept for them.
  static constexpr std::size_t kLargest = std::size_t{16} << 20;

  /// Rows of the host's memory one after the other; where they go they may lie farther apart. All in bytes.
  void send(const Stream& work, void* device, std::size_t device_pitch, const void* host, std::size_t host_pitch,
            std::size_t row_bytes, std::size_t rows) {
    Slot& slot = slots_[next_++ % kSlots];
    const std::size_t bytes = row_bytes * rows;
    if (slot.pinned) check(cudaEventSynchronize(slot.taken), "waiting for an upload");
    slot.grow(bytes);
    for (std::size_t row = 0; row < rows; ++row)
      std::memcpy(slot.pinned->get() + row * row_bytes, static_cast<const std::byte*>(host) + row * host_pitch,
                  row_bytes);
    auto* staged = slot.staged.get<std::byte>(bytes);
    check(cudaMemcpyAsync(staged, slot.pinned->get(), bytes, cudaMemcpyHostToDevice, bus_), "upload");
    bus_.record(slot.arrived);
    work.wait_for(slot.arrived);
    check(cudaMemcpy2DAsync(device, device_pitch, staged, row_bytes, row_bytes, rows, cudaMemcpyDeviceToDevice, work),
          "upload");
    work.record(slot.taken);
  }

 private:
  static constexpr std::size_t kSlots = 4;
  struct Slot {
    std::unique_ptr<Pinned<std::byte>> pinned;
    std::size_t bytes = 0;
    Scratch staged;
    Event arrived, taken;

    void grow(std::size_t wanted) {
      if (wanted <= bytes) return;
      pinned = std::make_unique<Pinned<std::byte>>(wanted);
      bytes = wanted;
    }
  };
  Stream bus_;
  Slot slots_[kSlots];
  std::size_t next_ = 0;
};

struct ToLong {
  __host__ __device__ std::int64_t operator()(std::int32_t value) const { return value; }
};

class CudaBackend final : public Backend, public FineFusionStages {
 public:
  using Backend::run;
  using FineFusionStages::run;

  explicit CudaBackend(CudaMemory memory) : memory_(memory) {
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, 0), "cudaGetDeviceProperties");
    processors_ = properties.multiProcessorCount;
    int cooperative = 0;
    check(cudaDeviceGetAttribute(&cooperative, cudaDevAttrCooperativeLaunch, 0), "cudaDeviceGetAttribute");
    is_cooperative_ = cooperative != 0;
    description_ = std::string("cuda (") + properties.name + ")";
  }

  std::string name() const override { return "cuda"; }
  std::string description() const override { return description_; }

  std::shared_ptr<void> allocate(std::size_t bytes) const override;
  void upload(void* device, const void* host, std::size_t bytes) const override {
    upload_rows(device, bytes, host, bytes, bytes, 1);
  }
  void upload_rows(void* device, std::size_t device_pitch, const void* host, std::size_t host_pitch,
                   std::size_t row_bytes, int rows) const override {
    const std::size_t bytes = row_bytes * static_cast<std::size_t>(rows);
    if (bytes == 0) return;
    if (bytes <= Uploads::kLargest) {
      uploads_.send(stream_, device, device_pitch, host, host_pitch, row_bytes, static_cast<std::size_t>(rows));
      return launched("upload");
    }
    check(cudaMemcpy2DAsync(device, device_pitch, host, host_pitch, row_bytes, static_cast<std::size_t>(rows),
                            cudaMemcpyHostToDevice, stream_),
          "upload");
    stream_.wait();  // the caller may change its memory at once
  }
  void download(void* host, const void* device, std::size_t bytes) const override {
    if (bytes == 0) return;
    check(cudaMemcpyAsync(host, device, bytes, cudaMemcpyDeviceToHost, stream_), "download");
    stream_.wait();
  }
  void clear(void* device, std::size_t bytes) const override {
    check(cudaMemsetAsync(device, 0, bytes, stream_), "clear");
    launched("clear");
  }

  void run(const kernels::ToMetres& k) const override { on(k.depth, k, "ToMetres"); }
  void run(const kernels::BilateralFilter& k) const override { on(k.out, k, "BilateralFilter"); }
  void run(const kernels::DecimateDepth& k) const override { on(k.coarse, k, "DecimateDepth"); }
  void run(const kernels::InverseDepth& k) const override { on(k.depth, k, "InverseDepth"); }
  void run(const kernels::PlaneNormals& k) const override { on(k.depth, k, "PlaneNormals"); }

  IcpSums reduce(const kernels::IcpReduce& kernel) const override;
  DepthComparison reduce(const kernels::CompareDepth& kernel) const override;
  void correct(const kernels::IcpCorrection& kernel, IcpSums* sums) const override;
  kernels::RegistrationState iterate(const kernels::Registration& registration,
                                     const SE3& model_from_live) const override;
  void run(const kernels::ExplainPixels& k) const override { on(k.use, k, "ExplainPixels"); }

  void run(const kernels::DepthRangeBase& k, int rows) const override { pixels(k.stride, rows, k, "DepthRangeBase"); }
  void run(const kernels::DepthRangeCoarser& k, int columns, int rows) const override {
    pixels(columns, rows, k, "DepthRangeCoarser");
  }
  void run(const kernels::MarkBricks& k) const override {
    pixels(k.volume.bricks_per_row(), k.volume.brick_rows(), k, "MarkBricks");
  }
  int compact(const std::int32_t* flags, int count, std::int32_t* list) const override;
  void integrate_marked(const kernels::Integrate& kernel, const std::int32_t* flags, int count, std::int32_t* list,
                        std::int32_t* listed) const override;

  void run(const kernels::MarkLeavingBricks& k) const override {
    pixels(k.volume.bricks_per_row(), k.volume.brick_rows(), k, "MarkLeavingBricks");
  }
  void run(const kernels::TakeBrick& k, int count) const override { entries(k, count, "TakeBrick"); }
  void run(const kernels::PutBrick& k, int count) const override { entries(k, count, "PutBrick"); }

  void run(const kernels::RaySpans& k) const override;
  void run(const kernels::Raycast& k) const override { on(k.depth, k, "Raycast"); }
  void run(const kernels::DecimateModel& k) const override { on(k.coarse_depth, k, "DecimateModel"); }

  void run(const kernels::CountBrick& k, int count) const override { entries(k, count, "CountBrick"); }
  std::int64_t scan(std::int32_t* values, int count) const override;
  void run(const kernels::WriteBrick& k, int count) const override { entries(k, count, "WriteBrick"); }

  const FineFusionStages* fine_fusion() const override { return this; }
  void run(const kernels::WeighReadings& k) const override { on(k.out, k, "WeighReadings"); }
  void run(const kernels::TouchedBricks& k) const override { pixels(k.columns(), k.rows(), k, "TouchedBricks"); }
  void run(const kernels::MarkFineBricks& k) const override;
  void update(const kernels::FuseFineBrick& kernel, const std::int32_t* list, int count) const override;
  void run(const kernels::CountFineBrick& k, int count) const override { entries(k, count, "CountFineBrick"); }
  void run(const kernels::WriteFineBrick& k, int count) const override { entries(k, count, "WriteFineBrick"); }
  std::size_t free_memory() const override;

  void wait() const override { stream_.wait(); }
  double milliseconds(const std::function<void()>& work) const override;

 private:
  static constexpr int kMaxBins = 8192;

  void launched(const char* what) const {
    check(cudaGetLastError(), what);
    if (memory_ == CudaMemory::managed) stream_.wait();
  }
  template <class T, class Kernel>
  void on(const PlaneView<T>& plane, const Kernel& kernel, const char* what) const {
    pixels(plane.width, plane.height, kernel, what);
  }
  template <class Kernel>
  void pixels(int width, int height, const Kernel& kernel, const char* what) const {
    launch(stream_, what, {blocks_for_pixels(width, height), dim3(kTileColumns, kTileRows)}, for_each<Kernel>, kernel,
           width, height);
    launched(what);
  }
  template <class Kernel>
  void entries(const Kernel& kernel, int count, const char* what) const {
    constexpr int kThreads = 64;
    launch(stream_, what, {blocks_for(count, kThreads), kThreads}, for_each_entry<Kernel>, kernel, count);
    launched(what);
  }
  template <int N, class Kernel>
  void reduce_pixels(const Kernel& kernel, int width, int height, int bins) const;
  std::int32_t* cleared_histogram() const;
  static void check_bins(int bins);
  int resident_blocks(std::size_t shared_bytes) const;
  unsigned brick_blocks(int bricks) const;
  template <class Count>
  void select(const std::int32_t* flags, int count, std::int32_t* list, Count* listed) const;
  /// Runs one of CUB's algorithms: asks for its memory first, as they all want it.
  template <class Algorithm>
  void with_memory(const char* what, const Algorithm& algorithm) const {
    std::size_t bytes = 0;
    check(algorithm(nullptr, bytes), what);
    void* memory = cub_.get<std::byte>(bytes);
    check(algorithm(memory, bytes), what);
  }

  CudaMemory memory_;
  std::string description_;
  int processors_ = 1;
  bool is_cooperative_ = false;
  Stream stream_;
  mutable Uploads uploads_;
  // What the stages need between two launches; a backend is used by one thread at a time.
  mutable Scratch cub_, partial_, histogram_;
  mutable bool histogram_is_clear_ = false;
  Pinned<double> sums_{kernels::icp_sum::kCount};
  Pinned<std::int32_t> counts_{kMaxBins};
  Pinned<std::int64_t> total_{1};
  Pinned<kernels::RegistrationState> state_{1};
  mutable Scratch device_state_;
};

std::shared_ptr<void> CudaBackend::allocate(std::size_t bytes) const {
  void* address = nullptr;
  if (memory_ == CudaMemory::managed)
    check(cudaMallocManaged(&address, bytes), "cudaMallocManaged");
  else
    check(cudaMalloc(&address, bytes), "cudaMalloc");
  std::shared_ptr<void> memory(address, [](void* p) { cudaFree(p); });
  clear(address, bytes);
  return memory;
}

void CudaBackend::run(const kernels::RaySpans& k) const {
  const int tiles = k.spans.stride * k.spans.rows;
  launch(stream_, "RaySpans", {blocks_for(tiles, kReduceThreads), kReduceThreads}, clear_spans, k.spans);
  const dim3 blocks = blocks_for_pixels(k.volume.bricks_per_row(), k.volume.brick_rows());
  launch(stream_, "RaySpans", {blocks, dim3(kTileColumns, kTileRows)}, span_rays, k);
  launched("RaySpans");
}

/// Whoever counts into it leaves it cleared.
std::int32_t* CudaBackend::cleared_histogram() const {
  auto* histogram = histogram_.get<std::int32_t>(kMaxBins);
  if (!histogram_is_clear_) check(cudaMemsetAsync(histogram, 0, kMaxBins * sizeof(std::int32_t), stream_), "clear");
  histogram_is_clear_ = true;
  return histogram;
}

/// Leaves the sums in sums_ and the counts in counts_, and waits for them.
template <int N, class Kernel>
void CudaBackend::reduce_pixels(const Kernel& kernel, int width, int height, int bins) const {
  const int count = width * height, blocks = divide_up(count, kReducePixels);
  auto* partial = partial_.get<double>(static_cast<std::size_t>(blocks) * N);
  std::int32_t* histogram = cleared_histogram();
  const Shape shape{blocks_for(count, kReducePixels), kReduceThreads,
                    sizeof(std::int32_t) * static_cast<std::size_t>(bins)};
  launch(stream_, "reduction", shape, cuda::reduce<N, Kernel>, kernel, width, count, partial, histogram, bins);
  launch(stream_, "reduction", {1, N * kWarp}, fold<N>, partial, blocks, histogram, bins, sums_.get(), counts_.get());
  stream_.wait();
}

void CudaBackend::check_bins(int bins) {
  if (bins + 2 > kMaxBins)
    throw Error("the distance distribution has " + std::to_string(bins) + " bins", "registration",
                "the cuda backend takes at most " + std::to_string(kMaxBins - 2));
}

IcpSums CudaBackend::reduce(const kernels::IcpReduce& kernel) const {
  // One bin more counts what lies beyond the range; one more still what is no pair, which nobody asks for.
  const int bins = kernel.in.bins;
  check_bins(bins);
  reduce_pixels<kernels::icp_sum::kCount>(kernel, kernel.in.live_depth.width, kernel.in.live_depth.height, bins + 2);
  IcpSums sums;
  std::copy(sums_.get(), sums_.get() + kernels::icp_sum::kCount, sums.slots);
  sums.histogram.assign(counts_.get(), counts_.get() + bins + 1);
  if (bins > 0) sums.bin_width = 1.0 / static_cast<double>(kernel.in.bins_per_metre);
  return sums;
}

DepthComparison CudaBackend::reduce(const kernels::CompareDepth& kernel) const {
  reduce_pixels<kernels::depth_comparison::kCount>(kernel, kernel.live.width, kernel.live.height, 0);
  DepthComparison sums;
  std::copy_n(sums_.get(), kernels::depth_comparison::kCount, sums.slots);
  return sums;
}

void CudaBackend::correct(const kernels::IcpCorrection& kernel, IcpSums* sums) const {
  reduce_pixels<kernels::icp_sum::kCount>(kernel, kernel.in.live_depth.width, kernel.in.live_depth.height, 0);
  for (int slot = 0; slot < kernels::icp_sum::kCount; ++slot) sums->slots[slot] += sums_.get()[slot];
}

/// How many of `register_frame`'s blocks the device can hold at once, which is how many may wait for each other.
int CudaBackend::resident_blocks(std::size_t shared_bytes) const {
  int of_processor = 0;
  check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&of_processor, register_frame, kReduceThreads, shared_bytes),
        "registration");
  return of_processor * processors_;
}

kernels::RegistrationState CudaBackend::iterate(const kernels::Registration& registration,
                                                const SE3& model_from_live) const {
  check_bins(registration.rules.bins);
  const std::size_t shared_bytes = sizeof(std::int32_t) * static_cast<std::size_t>(registration.rules.bins + 2);
  const int resident = is_cooperative_ ? resident_blocks(shared_bytes) : 0;
  if (resident == 0) return Backend::iterate(registration, model_from_live);
  int chunks = 0;
  for (int level = 0; level < registration.level_count; ++level)
    chunks = std::max(chunks, divide_up(registration.levels[level].pixels, kReducePixels));
  auto* partial = partial_.get<double>(static_cast<std::size_t>(chunks) * kernels::icp_sum::kCount);
  std::int32_t* histogram = cleared_histogram();
  auto* state = device_state_.get<kernels::RegistrationState>(1);
  constexpr std::size_t kStateBytes = sizeof(kernels::RegistrationState);
  *state_.get() = kernels::begin(registration, model_from_live);
  check(cudaMemcpyAsync(state, state_.get(), kStateBytes, cudaMemcpyHostToDevice, stream_), "registration");
  const Shape shape{static_cast<unsigned>(std::clamp(chunks, 1, resident)), kReduceThreads, shared_bytes, true};
  launch(stream_, "registration", shape, register_frame, registration, state, partial, histogram);
  check(cudaMemcpyAsync(state_.get(), state, kStateBytes, cudaMemcpyDeviceToHost, stream_), "registration");
  stream_.wait();
  return *state_.get();
}

/// The indices of the flags that are not zero, and how many there are, which need not be known here.
template <class Count>
void CudaBackend::select(const std::int32_t* flags, int count, std::int32_t* list, Count* listed) const {
  const thrust::counting_iterator<std::int32_t> indices(0);
  with_memory("compact", [&](void* memory, std::size_t& bytes) {
    return cub::DeviceSelect::Flagged(memory, bytes, indices, flags, list, listed, count, stream_);
  });
}

int CudaBackend::compact(const std::int32_t* flags, int count, std::int32_t* list) const {
  if (count == 0) return 0;
  select(flags, count, list, total_.get());
  stream_.wait();
  return static_cast<int>(*total_.get());
}

void CudaBackend::run(const kernels::MarkFineBricks& k) const {
  launch(stream_, "MarkFineBricks", {blocks_for(k.volume.bricks, kReduceThreads), kReduceThreads},
         for_each_along<kernels::MarkFineBricks>, k, k.volume.bricks);
  launched("MarkFineBricks");
}

void CudaBackend::update(const kernels::FuseFineBrick& kernel, const std::int32_t* list, int count) const {
  launch(stream_, "FuseFineBrick", {brick_blocks(count), kernels::kBrickVoxels},
         for_each_listed_brick<kernels::FuseFineBrick>, kernel, list, count);
  launched("FuseFineBrick");
}

std::size_t CudaBackend::free_memory() const {
  std::size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free;
}

/// Blocks that update bricks in turn.
unsigned CudaBackend::brick_blocks(int bricks) const {
  constexpr int kBlocksOfProcessor = 2048 / kernels::kBrickVoxels;  // threads that one can hold
  return static_cast<unsigned>(std::min(bricks, kBlocksOfProcessor * processors_));
}

void CudaBackend::integrate_marked(const kernels::Integrate& kernel, const std::int32_t* flags, int count,
                                   std::int32_t* list, std::int32_t* listed) const {
  select(flags, count, list, listed);
  launch(stream_, "Integrate", {brick_blocks(count), kernels::kBrickVoxels}, for_each_brick<kernels::Integrate>, kernel,
         list, listed);
  launched("Integrate");
}

double CudaBackend::milliseconds(const std::function<void()>& work) const {
  const Event begin(cudaEventDefault), end(cudaEventDefault);
  stream_.record(begin);
  work();
  stream_.record(end);
  check(cudaEventSynchronize(end), "waiting for the device");
  float elapsed = 0;
  check(cudaEventElapsedTime(&elapsed, begin, end), "cudaEventElapsedTime");
  return static_cast<double>(elapsed);
}

std::int64_t CudaBackend::scan(std::int32_t* values, int count) const {
  if (count == 0) return 0;
  with_memory("sum", [&](void* memory, std::size_t& bytes) {
    return cub::DeviceReduce::TransformReduce(memory, bytes, values, total_.get(), count, ::cuda::std::plus<>{},
                                              ToLong{}, std::int64_t{0}, stream_);
  });
  with_memory("scan", [&](void* memory, std::size_t& bytes) {
    return cub::DeviceScan::ExclusiveSum(memory, bytes, values, values, count, stream_);
  });
  stream_.wait();
  if (*total_.get() > std::numeric_limits<std::int32_t>::max())
    throw Error("the surface has more elements than 32 bits can count", "mesh", "lower volume.resolution");
  return *total_.get();
}

/// Empty if there is a device, or why there is none.
std::string why_unavailable() {
  int devices = 0;
  const cudaError_t status = cudaGetDeviceCount(&devices);
  if (status != cudaSuccess) {
    cudaGetLastError();  // the error is told here and must not stick
    int driver = 0;
    if (cudaDriverGetVersion(&driver) == cudaSuccess && driver == 0) return "no CUDA device: there is no NVIDIA driver";
    return std::string("no CUDA device: ") + cudaGetErrorString(status);
  }
  return devices == 0 ? "no CUDA device" : "";
}

}  // namespace
}  // namespace cuda

std::unique_ptr<Backend> make_cuda_backend(CudaMemory memory) {
  const std::string reason = cuda::why_unavailable();
  if (!reason.empty()) throw Error(reason, "cuda", "use --backend cpu");
  return std::make_unique<cuda::CudaBackend>(memory);
}

BackendInfo cuda_info() {
  const std::string reason = cuda::why_unavailable();
  if (!reason.empty()) return {"cuda", false, reason};
  cudaDeviceProp properties;
  if (cudaGetDeviceProperties(&properties, 0) != cudaSuccess) return {"cuda", false, "the CUDA device does not answer"};
  return {"cuda", true, properties.name};
}

}  // namespace plumbline
