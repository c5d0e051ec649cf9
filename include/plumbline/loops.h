// The correction of a path's drift where the camera came back to what it had seen: what was found, and what came of it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "plumbline/export.h"
#include "plumbline/se3.h"

namespace plumbline {

/// Whether the paths of recordings are corrected: never; whenever loops are accepted; or, the default, if besides the
/// correction pays by what is known without the truth.
enum class GlobalCorrection { off, on, automatic };

/// What became of two views that may show one place.
enum class LoopStatus {
  accepted,
  not_registered,  ///< no direction may be left open, either way
  too_weak,        ///< the views say too little of the motion between them
  one_way,         ///< registered the other way the motion is another
  seen_through,    ///< surfaces of one view lie where the other looked through
  too_far,         ///< farther off the path than it can have drifted
  contradicted     ///< by other loops
};
PLUMBLINE_EXPORT std::string_view to_string(LoopStatus status);

struct LoopReport {
  int first_frame = 0, second_frame = 0;  ///< their index in the sequence
  LoopStatus status = LoopStatus::not_registered;
  SE3 first_from_second;                 ///< the motion between the cameras, by their images
  double translation = 0, rotation = 0;  ///< by which the tracked path disagrees: metres, radians
};

struct LoopClosure {
  int views = 0;                  ///< of the path that were compared
  std::vector<LoopReport> loops;  ///< all that were tried
  /// Of the path from the accepted loops, before and after the correction: mean χ² a degree of freedom, each loop
  /// counted up to 25. What registration alone disagrees by is 1.
  double disagreement_before = 0, disagreement_after = 0;
  bool is_applied = false;
  double max_translation = 0, max_rotation = 0;  ///< metres and radians by which a pose was corrected
  double seconds = 0;                            ///< that all of it took
  std::string note;                              ///< why nothing was corrected; empty if it was

  int accepted() const;
  int count(LoopStatus status) const;
};

}  // namespace plumbline
