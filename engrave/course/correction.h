#pragma once

// The rounds of plan.h: predict a contour, compare each node's error with what is
// allowed, change its speed. Also on a part of a contour whose first nodes are already
// passed.

#include <cstddef>
#include <memory>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/course/plan.h"

namespace intaglio::course {

/// Of a law: for each node the figures, and the greatest ratio of error, motor's
/// acceleration and jerk to what is allowed.
struct Evaluation {
  std::vector<NodeFigures> nodes;
  std::vector<double> load_ratio;
  double worst_load_ratio = 0;
  double motor_mm_s2 = 0, jerk_mm_s3 = 0;
};

struct Allowed {
  double error_mm = 0;
  double motor_mm_s2 = 0;  ///< 0: any
  double jerk_mm_s3 = 0;   ///< 0: any
};

Allowed AllowedBy(const PlanOptions& options);

/// The same whatever the executor.
Evaluation Evaluate(const Path& path, const SpeedLaw& law, const Tracking& tracking,
                    const Allowed& allowed, Exactness exactness,
                    const Executor& executor = {});

/// What following nodes, and the begin of the window, change at nodes that are final.
inline constexpr double kFinalSlack = 1.002;

struct Speeds {
  std::vector<double> node_mm_s;           ///< for each node; the ends are kept
  std::vector<double> segment_mm_s;        ///< for each segment
  std::vector<double> acceleration_mm_s2;  ///< for each segment
  std::shared_ptr<const Swings> swings;    ///< SpeedLaw::swings
};

struct Corrected {
  Speeds speeds;
  SpeedLaw law;
  Evaluation evaluation;
  bool holds = false;
};

/// Of a longer path: the nodes whose speed may change begin at `first_free`, those whose
/// error counts at `first_counted`. Nodes before `first_free` may be worse by
/// kFinalSlack.
struct Window {
  std::size_t first_free = 1;
  std::size_t first_counted = 0;
  double begin_s = 0;  ///< SpeedLaw::begin_s
};

/// The fastest law found that keeps what is allowed; when none does, the last one.
Corrected CorrectSpeeds(const Path& path, const Tracking& tracking,
                        const Allowed& allowed, Speeds speeds, int rounds,
                        const Window& window = {}, const Executor& executor = {});

/// The speeds to begin with: feeds, straight segments whose axes' different lags cost
/// less than the tolerance, and corners by the formula (6)-(8), or by the rounding of the
/// kernel.
Speeds FirstSpeeds(const Path& path, const Tracking& tracking, const Allowed& allowed,
                   double acceleration_mm_s2);

}  // namespace intaglio::course
