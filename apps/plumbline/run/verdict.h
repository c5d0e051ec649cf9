// Whether a result can be trusted: by the truth where it is known, else by all that speaks against it.
#pragma once

#include <string>
#include <vector>

#include "run/reconstruction.h"

namespace plumbline::app {

/// One thing that can speak against a result.
struct Doubt {
  std::string name;   ///< as summary.json has it
  double value = 0;   ///< the larger, the worse; 0 where it is not known
  double fair, poor;  ///< from `fair` on a result is not good, beyond `poor` not even fair
  std::string text;   ///< a sentence, for a value that reaches `fair`

  /// 0 … 1 below `fair`, 1 … 2 up to `poor`, and on alike, 4 at most.
  double weight() const;
};

struct Verdict {
  enum class Level { none, good, fair, poor };
  Level level = Level::none;
  std::string text;  ///< a sentence or more
  /// Grows with the error that is to be expected: the fourth root of the sum of the weights' fourth powers.
  double doubt = 0;
  std::vector<Doubt> doubts = {};
  std::vector<std::string> reasons = {};  ///< those of the doubts that are told, also part of `text`
};

/// Without ground truth: poor or fair as the worst of its doubts is. With it: good if no more than 0.5 % of the frames
/// were lost and the path is within 5 cm (rmse), poor if it is over 20 cm off or a tenth of the frames were lost. Never
/// good for a run that broke off.
Verdict verdict_of(const Reconstruction& run);

std::string_view to_string(Verdict::Level level);

}  // namespace plumbline::app
