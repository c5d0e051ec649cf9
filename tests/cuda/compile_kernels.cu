// Compiled, never run: every kernel with a `float` lane on a GPU's thread. It keeps the kernels fit for the CUDA
// backend on machines that have nvcc but no GPU.
#include "kernels/icp.h"
#include "kernels/integrate.h"
#include "kernels/marching_cubes.h"
#include "kernels/preprocess.h"
#include "kernels/raycast.h"

namespace plumbline::kernels {

/// One thread's share of a reduction, without the block's fold.
struct ThreadSums {
  float slots[icp_sum::kCount];
  std::int32_t* histogram;

  PL_HD void add(int slot, float value) { slots[slot] += value; }
  PL_HD void add_product(int slot, float a, float b) { slots[slot] = madd(a, b, slots[slot]); }
  PL_HD void count(std::int32_t bin) { ++histogram[bin]; }
};

template <class Kernel>
__global__ void pixels(Kernel kernel) {
  kernel.template operator()<float>(static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x),
                                    static_cast<int>(blockIdx.y));
}

template <class Kernel>
__global__ void sums(Kernel kernel, ThreadSums* out) {
  kernel.template operator()<float>(static_cast<int>(threadIdx.x), static_cast<int>(blockIdx.x), *out);
}

__global__ void bricks(Integrate kernel) {
  const int brick = static_cast<int>(blockIdx.x), offset = static_cast<int>(threadIdx.x);
  if (kernel.is_near_surface<float>(brick, offset)) kernel.update<float>(brick, offset);
}

/// Depths are positive, so that their bits are in their order.
struct ThreadTiles {
  RaySpanView spans;

  template <class F>
  PL_HD void widen(bool valid, const RayTiles<F>& at, F near, F far) {
    if (!valid) return;
    for (int y = at.y0; y <= at.y1; ++y) {
      for (int x = at.x0; x <= at.x1; ++x) {
#if defined(__CUDA_ARCH__)
        atomicMin(reinterpret_cast<int*>(spans.nearest + y * spans.stride + x), bits_from_float(near));
        atomicMax(reinterpret_cast<int*>(spans.farthest + y * spans.stride + x), bits_from_float(far));
#endif
      }
    }
  }
};

__global__ void spans(RaySpans kernel) {
  ThreadTiles tiles{kernel.spans};
  kernel.operator()<float>(static_cast<int>(threadIdx.x), static_cast<int>(blockIdx.x), tiles);
}

template <class Kernel>
__global__ void entries(Kernel kernel) {
  kernel(static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x));
}

template __global__ void pixels<ToMetres>(ToMetres);
template __global__ void pixels<BilateralFilter>(BilateralFilter);
template __global__ void pixels<DecimateDepth>(DecimateDepth);
template __global__ void pixels<InverseDepth>(InverseDepth);
template __global__ void pixels<PlaneNormals>(PlaneNormals);
template __global__ void pixels<IntegralInput>(IntegralInput);
template __global__ void pixels<IntegralNormals>(IntegralNormals);
template __global__ void sums<IcpReduce>(IcpReduce, ThreadSums*);
template __global__ void sums<IcpCorrection>(IcpCorrection, ThreadSums*);
template __global__ void pixels<ExplainPixels>(ExplainPixels);
template __global__ void pixels<DepthRangeBase>(DepthRangeBase);
template __global__ void pixels<DepthRangeCoarser>(DepthRangeCoarser);
template __global__ void pixels<MarkBricks>(MarkBricks);
template __global__ void pixels<Raycast>(Raycast);
template __global__ void pixels<DecimateModel>(DecimateModel);
template __global__ void entries<CountBrick>(CountBrick);
template __global__ void entries<WriteBrick>(WriteBrick);

}  // namespace plumbline::kernels
