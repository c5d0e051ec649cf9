// The stages of the final fusion, for the backends that have them.
#pragma once

#include <cstdint>

#include "kernels/marching_cubes.h"

namespace plumbline {

namespace kernels {
struct WeighReadings;
struct TouchedBricks;
struct MarkFineBricks;
struct FuseFineBrick;
class SparseBricks;
}  // namespace kernels

/// Runs the kernels of kernels/fine_fusion.h; see Backend.
class FineFusionStages {
 public:
  virtual void run(const kernels::WeighReadings& kernel) const = 0;
  virtual void run(const kernels::TouchedBricks& kernel) const = 0;
  virtual void run(const kernels::MarkFineBricks& kernel) const = 0;
  /// Updates `count` bricks; those that get a surface are marked as occupied.
  virtual void update(const kernels::FuseFineBrick& kernel, const std::int32_t* list, int count) const = 0;
  virtual void run(const kernels::CountBrickOf<kernels::SparseBricks>& kernel, int entries) const = 0;
  virtual void run(const kernels::WriteBrickOf<kernels::SparseBricks>& kernel, int entries) const = 0;

 protected:
  ~FineFusionStages() = default;
};

}  // namespace plumbline
