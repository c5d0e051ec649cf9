// What a device can do: run the kernels. A backend is a list of stages with no maths of its own; which kernels make a
// frame is decided above it, in ordinary C++ that is compiled once.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/device_array.h"
#include "core/plane.h"
#include "kernels/brick_moves.h"
#include "kernels/depth_comparison.h"
#include "kernels/icp.h"
#include "kernels/integrate.h"
#include "kernels/marching_cubes.h"
#include "kernels/preprocess.h"
#include "kernels/raycast.h"
#include "plumbline/backend.h"
#include "plumbline/se3.h"

namespace plumbline {

namespace kernels {
struct Registration;
struct RegistrationState;
}  // namespace kernels

class FineFusionStages;

/// What one pass of registration sums up.
struct IcpSums {
  double slots[kernels::icp_sum::kCount] = {};
  /// Pairs per distance bin; the last entry counts those beyond the range.
  std::vector<std::int32_t> histogram;
  double bin_width = 0;  ///< metres

  Matrix6d hessian() const;   ///< AᵀA
  Vector6d gradient() const;  ///< Aᵀb
  double squares() const { return slots[kernels::icp_sum::kSquares]; }
  int inliers() const { return static_cast<int>(slots[kernels::icp_sum::kInliers]); }
  int with_depth() const { return static_cast<int>(slots[kernels::icp_sum::kWithDepth]); }
  double rms() const { return inliers() > 0 ? std::sqrt(squares() / inliers()) : 0; }  ///< metres
  int pairs() const { return static_cast<int>(slots[kernels::icp_sum::kPairs]); }
  /// Bin that holds the median distance of the pairs; the last one (beyond the range) counts too. −1 without pairs.
  int median_bin() const;
  /// Centre of that bin, metres; the range's end when the median lies beyond it, 0 without pairs.
  double median_distance() const;
};

/// What comparing two depth images counts, pixels.
struct DepthComparison {
  double slots[kernels::depth_comparison::kCount] = {};

  /// Of the readings those where the model has a surface; 0 … 1, as those below.
  double known() const { return share(kernels::depth_comparison::kKnown, kernels::depth_comparison::kReadings); }
  double see_through() const {
    return share(kernels::depth_comparison::kSeeThrough, kernels::depth_comparison::kKnown);
  }
  double matched() const { return share(kernels::depth_comparison::kMatched, kernels::depth_comparison::kKnown); }

 private:
  double share(int part, int whole) const { return slots[whole] > 0 ? slots[part] / slots[whole] : 0; }
};

/// Runs kernels on one device, in the order of the calls. What a call returns is there when it returns; what it leaves
/// in the device's memory may come later, and every other call sees it. Not thread-safe; every pipeline may have its
/// own.
class Backend : public DeviceMemory {
 public:
  Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;
  ~Backend() override;

  virtual std::string name() const = 0;         ///< "cpu"
  virtual std::string description() const = 0;  ///< "cpu (avx2+fma, 2 threads)"

  /// Copies `rows` rows, which lie a pitch apart, to the device; all in bytes.
  virtual void upload_rows(void* device, std::size_t device_pitch, const void* host, std::size_t host_pitch,
                           std::size_t row_bytes, int rows) const;

  // Preprocessing.
  virtual void run(const kernels::ToMetres& kernel) const = 0;
  virtual void run(const kernels::BilateralFilter& kernel) const = 0;
  virtual void run(const kernels::DecimateDepth& kernel) const = 0;
  virtual void run(const kernels::InverseDepth& kernel) const = 0;
  virtual void run(const kernels::PlaneNormals& kernel) const = 0;

  // Registration.
  virtual IcpSums reduce(const kernels::IcpReduce& kernel) const = 0;
  /// Adds the correction to the sums of the pass that wrote its distances.
  virtual void correct(const kernels::IcpCorrection& kernel, IcpSums* sums) const = 0;
  /// All iterations of a frame (kernels/registration.h). Here pass by pass; a device may do without the host between
  /// them.
  virtual kernels::RegistrationState iterate(const kernels::Registration& registration,
                                             const SE3& model_from_live) const;
  virtual void run(const kernels::ExplainPixels& kernel) const = 0;

  // Fusion.
  virtual void run(const kernels::DepthRangeBase& kernel, int rows) const = 0;
  virtual void run(const kernels::DepthRangeCoarser& kernel, int columns, int rows) const = 0;
  virtual void run(const kernels::MarkBricks& kernel) const = 0;
  /// Writes the indices i with flags[i] ≠ 0 to `list`, in order, and returns how many there are.
  virtual int compact(const std::int32_t* flags, int count, std::int32_t* list) const = 0;
  /// Updates the bricks i < count with flags[i] ≠ 0; those that get a surface are marked as occupied. `list`, of
  /// `count` elements, gets their indices, and `listed` how many there are: both in the device's memory.
  virtual void integrate_marked(const kernels::Integrate& kernel, const std::int32_t* flags, int count,
                                std::int32_t* list, std::int32_t* listed) const = 0;

  // Moving the window.
  virtual void run(const kernels::MarkLeavingBricks& kernel) const = 0;
  virtual void run(const kernels::TakeBrick& kernel, int entries) const = 0;
  virtual void run(const kernels::PutBrick& kernel, int entries) const = 0;

  // Prediction.
  /// Writes the spans of all tiles.
  virtual void run(const kernels::RaySpans& kernel) const = 0;
  virtual void run(const kernels::Raycast& kernel) const = 0;
  virtual void run(const kernels::DecimateModel& kernel) const = 0;
  virtual DepthComparison reduce(const kernels::CompareDepth& kernel) const = 0;

  // Meshing.
  virtual void run(const kernels::CountBrick& kernel, int entries) const = 0;
  /// Exclusive prefix sum in place; returns the total. Throws Error above 2³¹ − 1.
  virtual std::int64_t scan(std::int32_t* values, int count) const = 0;
  virtual void run(const kernels::WriteBrick& kernel, int entries) const = 0;

  /// The stages of the final fusion; null where the backend has none.
  virtual const FineFusionStages* fine_fusion() const { return nullptr; }
  /// Bytes that its own memory still has; 0 if that is the host's.
  virtual std::size_t free_memory() const;

  // For measurements.
  /// Until all that was asked for is done.
  virtual void wait() const;
  /// What the device needs for the calls that `work` makes, by its own clock.
  virtual double milliseconds(const std::function<void()>& work) const;
};

}  // namespace plumbline
