// How well the views of a run agree with the model that came of all of them: what can be known without the truth.
#pragma once

namespace plumbline {

/// Keyframes compared with the final model rendered at their poses. A camera path that drifted and came back, a place
/// that was taken for another, or a wrong camera leaves surfaces twice: early views look through what later ones saw.
struct ModelConsistency {
  int views = 0;                 ///< keyframes that were compared; with none of them nothing is known
  double known = 0;              ///< of their readings, the share where the model has a surface; mean over the views
  double matched = 0;            ///< of those, the share on the surface (within 1.5 cm + 1 %); mean over the views
  double see_through = 0;        ///< of those, the share behind it (by over 4 cm + 2 %); mean over the views
  double worst_see_through = 0;  ///< the 90th percentile over the views
};

}  // namespace plumbline
