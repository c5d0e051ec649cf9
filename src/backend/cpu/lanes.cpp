// The CPU's stages over one lane type. This file is compiled once for each instruction set (and by the tests for plain
// `float`): PLUMBLINE_LANE is the lane type, PLUMBLINE_MAKE the name of the function that makes the backend.
#include "backend/cpu/lanes.h"

#include <cstring>

#include "backend/cpu/launch.h"
#include "kernels/fine_fusion.h"

namespace plumbline::cpu {
namespace {

template <class F>
class Lanes final : public LanesBase {
 public:
  using LanesBase::LanesBase;
  using LanesBase::run;

  void run(const kernels::ToMetres& k) const override { on(k.depth, k); }
  void run(const kernels::BilateralFilter& k) const override { on(k.out, k); }
  void run(const kernels::DecimateDepth& k) const override { on(k.coarse, k); }
  void run(const kernels::InverseDepth& k) const override { on(k.depth, k); }
  void run(const kernels::PlaneNormals& k) const override { on(k.depth, k); }

  void reduce_into(const kernels::IcpReduce& k, double* sums, std::int32_t* histogram) const override {
    cpu::reduce<F, kernels::icp_sum::kCount>(threads(), k.in.live_depth.width, k.in.live_depth.height, k, sums,
                                             histogram, k.in.bins + 2);
  }
  void reduce_into(const kernels::IcpCorrection& k, double* sums) const override {
    cpu::reduce<F, kernels::icp_sum::kCount>(threads(), k.in.live_depth.width, k.in.live_depth.height, k, sums, nullptr,
                                             0);
  }
  void reduce_into(const kernels::CompareDepth& k, double* sums) const override {
    cpu::reduce<F, kernels::depth_comparison::kCount>(threads(), k.live.width, k.live.height, k, sums, nullptr, 0);
  }
  void run(const kernels::ExplainPixels& k) const override { on(k.use, k); }

  void run(const kernels::DepthRangeBase& k, int rows) const override { for_each<F>(threads(), k.stride, rows, k); }
  void run(const kernels::DepthRangeCoarser& k, int columns, int rows) const override {
    for_each<F>(threads(), columns, rows, k);
  }
  void run(const kernels::MarkBricks& k) const override {
    for_each<F>(threads(), k.volume.bricks_per_row(), k.volume.brick_rows(), k);
  }
  void run(const kernels::MarkLeavingBricks& k) const override {
    for_each<F>(threads(), k.volume.bricks_per_row(), k.volume.brick_rows(), k);
  }
  void integrate_listed(const kernels::Integrate& k, const std::int32_t* list, int count) const override {
    for_each_brick<F>(threads(), k, list, count);
  }

  void run(const kernels::RaySpans& k) const override { span_rays<F>(threads(), k); }
  void run(const kernels::Raycast& k) const override { for_each_block<F>(threads(), k.depth.width, k.depth.height, k); }
  void run(const kernels::DecimateModel& k) const override { on(k.coarse_depth, k); }

  void run(const kernels::WeighReadings& k) const override { on(k.out, k); }
  void run(const kernels::TouchedBricks& k) const override { for_each<F>(threads(), k.columns(), k.rows(), k); }
  void run(const kernels::MarkFineBricks& k) const override { for_each_along<F>(threads(), k.volume.bricks, k); }
  void update(const kernels::FuseFineBrick& k, const std::int32_t* list, int count) const override {
    for_each_brick<F>(threads(), k, list, count);
  }

 private:
  template <class T, class Kernel>
  PL_HD void on(const PlaneView<T>& plane, const Kernel& kernel) const {
    for_each<F>(threads(), plane.width, plane.height, kernel);
  }
};

}  // namespace

Backend* PLUMBLINE_MAKE(int threads, const char* instruction_set) {
  return new Lanes<PLUMBLINE_LANE>(threads, instruction_set);
}

}  // namespace plumbline::cpu
