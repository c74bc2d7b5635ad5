#pragma once

// Whether a plan still holds its tolerance on a machine whose mechanics are not quite
// those of the model: its setpoints are given to axes with other natural frequencies and
// dampings.

#include <vector>

#include "engrave/course/plan.h"

namespace intaglio::course {

/// How wrong the mechanics may be, as shares; 0..0.5. What identification promises: 2 %
/// and 10 %; the defaults are those of a machine that has aged.
struct ModelError {
  double frequency = 0.05;
  double damping = 0.20;
};

/// The factors of one machine that differs: of x and of y.
struct MechanicsFactors {
  std::array<double, 2> frequency{1, 1}, damping{1, 1};
};

struct MarginCase {
  MechanicsFactors factors;
  double worst_mm = 0;  ///< the greater of both errors
};

struct Margin {
  std::vector<MarginCase> cases;
  MarginCase worst;
  bool holds = false;  ///< all cases within the tolerance
};

/// The frequency or the damping wrong, up or down, of both axes or of one: 12 machines.
std::vector<MechanicsFactors> WrongMechanics(const ModelError& error);

/// The same whatever the executor.
Margin CheckMargin(const Path& path, const CoursePlan& plan, const AxisPair& axes,
                   double tolerance_mm, const ModelError& error,
                   const Executor& executor = {});

struct PlanWithMargin {
  CoursePlan plan;
  Margin margin;
  double planned_ratio = 1;  ///< of the tolerance
};

/// Plans for less than the tolerance, options.planned_ratio to begin with, until the
/// margin holds, at most kMarginTrials times. When it never does, plan and margin of the
/// last trial: margin.holds is false. A plan with swings is compared with one without.
/// Errors as of PlanCourse.
Result<PlanWithMargin> PlanWithin(const Path& path, const AxisPair& axes,
                                  const PlanOptions& options, const ModelError& error);

inline constexpr int kMarginTrials = 5;

}  // namespace intaglio::course
