#include "engrave/course/margin.h"

#include <gtest/gtest.h>

#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/course/oracle.h"

namespace intaglio::course {
namespace {

TEST(WrongMechanics, AreTwelveMachinesAroundTheModel) {
  const auto machines = WrongMechanics({0.05, 0.2});
  ASSERT_EQ(machines.size(), 12U);
  for (const MechanicsFactors& m : machines) {
    const bool other_frequency = m.frequency[0] != 1 || m.frequency[1] != 1;
    const bool other_damping = m.damping[0] != 1 || m.damping[1] != 1;
    EXPECT_NE(other_frequency, other_damping);
  }
}

// The plan holds its tolerance on the machines it promises, by the independent model.
TEST(PlanWithin, HoldsOnMachinesThatDiffer) {
  for (const Path& path : CutProgram(1, 100, 81)) {
    const PlanWithMargin found =
        PlanWithin(path, MeasuredMachine(), CompensatedOptions(), {0.05, 0.2}).value();
    ASSERT_TRUE(found.margin.holds) << found.margin.worst.worst_mm;
    const AxisPair machine = MeasuredMachine();
    for (const MarginCase& c : found.margin.cases) {
      const AxisPair real{
          machine[0].WithMechanics(c.factors.frequency[0], c.factors.damping[0]),
          machine[1].WithMechanics(c.factors.frequency[1], c.factors.damping[1])};
      const Tracked tracked = FollowPlan(path, found.plan, MeasuredMachine(), real);
      const auto actual = OracleFollow(OracleOf(real), tracked.setpoints_mm,
                                       found.plan.tracking.period_s, 1);
      const OracleError error = OracleMeasure(path, actual, tracked.commanded_s_mm);
      // Runge-Kutta in steps of .1 ms.
      EXPECT_LE(error.one_sided_mm, 0.1 + 1e-4);
      EXPECT_LE(error.node_miss_mm, 0.1 + 1e-4);
    }
  }
}

// Without a reserve the same machines cut further than the tolerance, and the margin
// reports it.
TEST(CheckMargin, ReportsThatAPlanWithoutReserveDoesNotHold) {
  int held = 0;
  const auto program = CutProgram(1, 100, 81);
  for (const Path& path : program) {
    const CoursePlan plan =
        PlanCourse(path, MeasuredMachine(), CompensatedOptions()).value();
    const Margin margin = CheckMargin(path, plan, MeasuredMachine(), 0.1, {0.05, 0.2});
    EXPECT_EQ(margin.holds, margin.worst.worst_mm <= 0.1);
    held += margin.holds ? 1 : 0;
    EXPECT_LE(CheckMargin(path, plan, MeasuredMachine(), 0.1, {0, 0}).worst.worst_mm,
              0.1 * 1.001);
  }
  EXPECT_LT(held, static_cast<int>(program.size()));
}

// Mechanics that no identification would leave so wrong.
TEST(PlanWithin, ReportsWhatNoReserveHolds) {
  const Path corner = CornerPath(0.7, 1.5, 20, 100);
  PlanOptions options = CompensatedOptions();
  options.tolerance_mm = 0.01;
  const PlanWithMargin found =
      PlanWithin(corner, MeasuredMachine(), options, {0.5, 0.5}).value();
  EXPECT_FALSE(found.margin.holds);
  EXPECT_GT(found.margin.worst.worst_mm, 0.01);
}

}  // namespace
}  // namespace intaglio::course
