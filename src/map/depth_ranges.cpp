#include "map/depth_ranges.h"

namespace plumbline {

DepthRanges::DepthRanges(const Pinhole& camera, const Backend& backend) : backend_(&backend) {
  int columns = (camera.width + kernels::kRangeTile - 1) / kernels::kRangeTile;
  int rows = (camera.height + kernels::kRangeTile - 1) / kernels::kRangeTile;
  int total = 0;
  for (;;) {
    const Level level{total, columns, rows, padded_to_lanes(columns)};
    levels_.push_back(level);
    total += level.stride * rows;
    if (columns == 1 && rows == 1) break;
    columns = (columns + 1) / 2;
    rows = (rows + 1) / 2;
  }
  nearest_ = DeviceArray<float>(backend, static_cast<std::size_t>(total));
  farthest_ = DeviceArray<float>(backend, static_cast<std::size_t>(total));
  std::vector<std::int32_t> first, stride;
  for (const Level& level : levels_) {
    first.push_back(level.first);
    stride.push_back(level.stride);
  }
  first_ = DeviceArray<std::int32_t>(backend, first);
  stride_ = DeviceArray<std::int32_t>(backend, stride);
  view_ = {nearest_.data(), farthest_.data(), first_.data(), stride_.data(), static_cast<int>(levels_.size())};
}

void DepthRanges::measure(const Plane<float>& depth) const {
  const Level& base = levels_.front();
  backend_->run(kernels::DepthRangeBase{read_only(depth), view_, base.stride}, base.rows);
  for (std::size_t i = 1; i < levels_.size(); ++i) {
    const Level &fine = levels_[i - 1], &level = levels_[i];
    backend_->run(kernels::DepthRangeCoarser{view_, fine.first, fine.stride, fine.rows, level.first, level.stride},
                  level.stride, level.rows);
  }
}

}  // namespace plumbline
