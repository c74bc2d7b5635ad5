#pragma once

// Whether the steps of a plan are slow enough for what follows its commands.

#include <span>
#include <vector>

#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

class StepJudge {
 public:
  virtual ~StepJudge() = default;

  /// `planned` goes on where the plan has got to and ends at rest; `point` of the last
  /// segment of each step is the number of the step, from 0 to count - 1. Writes whether
  /// each has to take longer to `too_fast`; false: none has to.
  virtual bool Judge(std::span<const Segment> planned, std::size_t count,
                     std::vector<bool>& too_fast) const = 0;
};

}  // namespace intaglio::motion
