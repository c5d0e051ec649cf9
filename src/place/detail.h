// What a view has besides large planes. Floors, walls and table tops fit to others of their kind wherever those stand,
// three at once in every corner of a room: a place is told by what stands on them.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/maps.h"
#include "plumbline/vec3.h"

namespace plumbline {

/// A pixel of a view, camera's frame; `depth` is 0 where there is no reading or no normal.
struct SurfacePoint {
  float depth = 0;
  Vec3<float> position{}, normal{};
};

/// About 80×60 pixels of a level, evenly spaced, row by row.
std::vector<SurfacePoint> sample_surface(const Backend& backend, const DepthLevel& level);

/// Which of the points lie on none of the large planes among them: 1 or 0 each.
std::vector<std::uint8_t> beyond_planes(const std::vector<SurfacePoint>& points);

/// Two views of one camera at one pose, compared where either of them shows more than planes.
struct DetailComparison {
  int readings = 0;  ///< points that both have
  int detail = 0;    ///< of these, beyond the planes of either
  int matched = 0;   ///< of those, at one depth

  /// How much of the view speaks for one place; what does not match speaks against it. At most 1.
  double support() const {
    constexpr double kMismatch = 2.5;
    return readings > 0 ? (matched - kMismatch * (detail - matched)) / readings : 0;
  }
};
DetailComparison compare_detail(const std::vector<SurfacePoint>& a, const std::vector<SurfacePoint>& b);

}  // namespace plumbline
