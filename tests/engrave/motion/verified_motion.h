#pragma once

// The independent verifier over a whole plan at once.

#include <vector>

#include "engrave/motion/verify.h"

namespace intaglio::motion {

/// The report of MotionVerifier on these segments; `planned_mm` as there.
inline MotionReport VerifyMotion(const KnotState& start,
                                 const std::vector<Segment>& segments,
                                 const PointList& planned_mm, const Limits& limits,
                                 double rate_hz, const VerifyOptions& options = {}) {
  MotionVerifier verifier(start, planned_mm, limits, rate_hz, options);
  for (const Segment& segment : segments) verifier.Append(segment);
  return verifier.Finish();
}

/// Points per tick of the motion, at most 1; its ticks are those to the rest at its end.
inline double UtilisationRatio(const MotionReport& report) {
  return report.ticks == 0
             ? 0.0
             : static_cast<double>(report.points) / static_cast<double>(report.ticks);
}

}  // namespace intaglio::motion
