// What the CPU's instruction sets share; the rest is in lanes.cpp.
#pragma once

#include "backend/backend.h"
#include "backend/fine_fusion.h"
#include "core/thread_pool.h"

namespace plumbline::cpu {

/// The stages that need no lanes, compiled once for every processor.
class LanesBase : public Backend, public FineFusionStages {
 public:
  LanesBase(int threads, const char* instruction_set);
  ~LanesBase() override;

  std::string name() const override;
  std::string description() const override;
  std::shared_ptr<void> allocate(std::size_t bytes) const override;
  void upload(void* device, const void* host, std::size_t bytes) const override;
  void download(void* host, const void* device, std::size_t bytes) const override;
  void clear(void* device, std::size_t bytes) const override;
  IcpSums reduce(const kernels::IcpReduce& kernel) const override;
  DepthComparison reduce(const kernels::CompareDepth& kernel) const override;
  void correct(const kernels::IcpCorrection& kernel, IcpSums* sums) const override;
  int compact(const std::int32_t* flags, int count, std::int32_t* list) const override;
  void integrate_marked(const kernels::Integrate& kernel, const std::int32_t* flags, int count, std::int32_t* list,
                        std::int32_t* listed) const override;
  std::int64_t scan(std::int32_t* values, int count) const override;
  void run(const kernels::TakeBrick& kernel, int entries) const override;
  void run(const kernels::PutBrick& kernel, int entries) const override;
  void run(const kernels::CountBrick& kernel, int entries) const override;
  void run(const kernels::WriteBrick& kernel, int entries) const override;
  void run(const kernels::CountBrickOf<kernels::SparseBricks>& kernel, int entries) const override;
  void run(const kernels::WriteBrickOf<kernels::SparseBricks>& kernel, int entries) const override;
  const FineFusionStages* fine_fusion() const override;
  using Backend::run;
  using FineFusionStages::run;

 protected:
  const ThreadPool& threads() const { return threads_; }
  virtual void reduce_into(const kernels::IcpReduce& kernel, double* sums, std::int32_t* histogram) const = 0;
  virtual void reduce_into(const kernels::IcpCorrection& kernel, double* sums) const = 0;
  virtual void reduce_into(const kernels::CompareDepth& kernel, double* sums) const = 0;
  virtual void integrate_listed(const kernels::Integrate& kernel, const std::int32_t* list, int count) const = 0;

 private:
  HostMemory memory_;
  ThreadPool threads_;
  const char* instruction_set_;
};

Backend* make_lanes_sse4_2(int threads, const char* instruction_set);
Backend* make_lanes_avx2(int threads, const char* instruction_set);
Backend* make_lanes_avx512(int threads, const char* instruction_set);

}  // namespace plumbline::cpu
