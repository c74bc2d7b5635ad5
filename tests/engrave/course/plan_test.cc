#include "engrave/course/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "engrave/course/source_law.h"
#include "engrave/course/swing_table.h"
#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/course/oracle.h"

namespace intaglio::course {
namespace {

constexpr double kFeedMmS = 100, kToleranceMm = 0.1;
// What stopping at every node is planned with, for all comparisons.
constexpr double kAcceleration = 2000;

// The 32 m program of docs/measurements.md, remade with a seed of its own.
const std::vector<Path>& Program() {
  static const std::vector<Path> program = CutProgram(32, kFeedMmS, 2026);
  return program;
}

struct Cut {
  double duration_s = 0, one_sided_mm = 0, node_miss_mm = 0, motor_mm_s2 = 0;

  void Add(const CoursePlan& plan) {
    duration_s += plan.law.duration_s;
    one_sided_mm = std::max(one_sided_mm, plan.worst_one_sided_mm);
    node_miss_mm = std::max(node_miss_mm, plan.worst_node_miss_mm);
    motor_mm_s2 = std::max(motor_mm_s2, plan.motor_mm_s2);
  }
  double SavedRatio(const std::vector<Path>& program) const {
    return 1 - duration_s / StoppingDurationS(program, kAcceleration);
  }
};

Cut CutBySource(const std::vector<Path>& program, double allowance_ratio,
                double acceleration_mm_s2) {
  Cut cut;
  PlanOptions options;
  options.acceleration_mm_s2 = acceleration_mm_s2;
  for (const Path& path : program) {
    const auto limits =
        SourceNodeSpeeds(path, MeasuredMachine(), {kToleranceMm, allowance_ratio, true});
    cut.Add(EvaluateLaw(path, MeasuredMachine(),
                        PlanSpeeds(path, limits, acceleration_mm_s2), options));
  }
  return cut;
}

Cut CutByPlan(const std::vector<Path>& program, PlanOptions options) {
  Cut cut;
  options.swings = std::make_shared<SwingTable>();
  for (const Path& path : program) {
    const CoursePlan plan = PlanCourse(path, MeasuredMachine(), options).value();
    EXPECT_TRUE(plan.holds) << plan.reason;
    cut.Add(plan);
  }
  return cut;
}

TEST(Program, IsAsDescribed) {
  EXPECT_NEAR(LengthMm(Program()), 32300, 600);
  EXPECT_NEAR(static_cast<double>(SegmentCount(Program())), 6932, 700);
  EXPECT_NEAR(static_cast<double>(Program().size()), 167, 25);
}

// .45 of the tolerance with 1.5 m/s^2 held it on the program of the reference; on this
// one it takes 1.25 m/s^2, and then more of the tolerance.
TEST(SourceLaw, ThatHoldsTheToleranceSaves28Percent) {
  for (const double allowance : {0.55, 0.54, 0.53, 0.52, 0.51, 0.5}) {
    const Cut cut = CutBySource(Program(), allowance, 1250);
    if (cut.one_sided_mm > kToleranceMm || cut.node_miss_mm > kToleranceMm) continue;
    EXPECT_GE(cut.SavedRatio(Program()), 0.28);
    return;
  }
  FAIL() << "no allowance holds the tolerance";
}

TEST(SourceLaw, AsPublishedBreaksTheTolerance) {
  const Cut cut = CutBySource(Program(), 1, kAcceleration);
  EXPECT_GT(cut.one_sided_mm, 0.15);
  EXPECT_NEAR(cut.motor_mm_s2, 10800, 1500);
}

TEST(PlanCourse, PredictsTheWholeContourAndSaves40Percent) {
  const Cut cut = CutByPlan(Program(), {});
  EXPECT_LE(cut.one_sided_mm, kToleranceMm * 1.0001);
  EXPECT_LE(cut.node_miss_mm, kToleranceMm * 1.0001);
  EXPECT_GE(cut.SavedRatio(Program()), 0.40);
}

TEST(PlanCourse, CompensatesAndSaves46Percent) {
  const Cut cut = CutByPlan(Program(), CompensatedOptions());
  EXPECT_LE(cut.one_sided_mm, kToleranceMm * 1.0001);
  EXPECT_LE(cut.node_miss_mm, kToleranceMm * 1.0001);
  EXPECT_LE(cut.motor_mm_s2, 11000 * 1.0001);
  EXPECT_GE(cut.SavedRatio(Program()), 0.46);
}

/// What the axes make of a plan, by the independent model.
void ExpectHeld(const Path& path, const CoursePlan& plan, const AxisPair& axes) {
  constexpr int kFine = 4;
  const Tracked tracked = FollowPlan(path, plan, axes, axes);
  const auto actual =
      OracleFollow(OracleOf(axes), tracked.setpoints_mm, plan.tracking.period_s, kFine);
  std::vector<double> s_mm;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    const std::size_t k = i / kFine;
    const double share = static_cast<double>(i % kFine) / kFine;
    const double from = tracked.commanded_s_mm[k];
    const double to =
        k + 1 < tracked.commanded_s_mm.size() ? tracked.commanded_s_mm[k + 1] : from;
    s_mm.push_back(from + share * (to - from));
  }
  const OracleError error = OracleMeasure(path, actual, s_mm);
  // Runge-Kutta in steps of .1 ms, and cusps between the plan's samples: .3 um.
  constexpr double kSlackMm = 0.0003;
  EXPECT_LE(error.one_sided_mm, kToleranceMm + kSlackMm);
  // The oracle's course is points of it, at most 12.5 um apart at full speed.
  EXPECT_LE(error.node_miss_mm, kToleranceMm + kSlackMm);
  EXPECT_LE(error.other_side_mm, kToleranceMm + kSlackMm);
}

// A program that no constant was chosen on.
TEST(PlanCourse, HoldsTheToleranceOnAHeldOutProgram) {
  for (const Path& path : CutProgram(3, kFeedMmS, 77)) {
    const CoursePlan direct = PlanCourse(path, MeasuredMachine(), {}).value();
    ASSERT_TRUE(direct.holds) << direct.reason;
    ExpectHeld(path, direct, MeasuredMachine());
    const CoursePlan compensated =
        PlanCourse(path, MeasuredMachine(), CompensatedOptions()).value();
    ASSERT_TRUE(compensated.holds) << compensated.reason;
    ExpectHeld(path, compensated, MeasuredMachine());
  }
}

TEST(PlanCourse, HoldsTheToleranceThroughACascade) {
  const AxisPair cascade = MeasuredMachine(LoopKind::kCascade);
  for (const Path& path : CutProgram(1.5, kFeedMmS, 78)) {
    PlanOptions options = CompensatedOptions();
    options.period_s = 0.001;
    const CoursePlan plan = PlanCourse(path, cascade, options).value();
    ASSERT_TRUE(plan.holds) << plan.reason;
    ExpectHeld(path, plan, cascade);
  }
}

TEST(PlanCourse, FollowsArcs) {
  const std::vector<Piece> pieces{{Vec2(30, 0), 100},
                                  {Vec2(34, 4), 60, 1.5707963},
                                  {Vec2(34, 30), 100},
                                  {Vec2(0, 0), 100, 2}};
  const Path path = Path::Make(Vec2(0, 0), pieces).value();
  for (const PlanOptions& options : {PlanOptions{}, CompensatedOptions()}) {
    const CoursePlan plan = PlanCourse(path, MeasuredMachine(), options).value();
    EXPECT_TRUE(plan.holds) << plan.reason;
    EXPECT_LE(plan.worst_mm(), kToleranceMm * 1.0001);
    // Faster than with a stop at the two corners.
    EXPECT_GT(plan.law.duration_s, path.length_mm() / 100);
  }
}

TEST(PlanCourse, KeepsTheJerk) {
  PlanOptions options = CompensatedOptions();
  options.jerk_mm_s3 = 800000;
  for (const Path& path : CutProgram(1, kFeedMmS, 79)) {
    const CoursePlan plan = PlanCourse(path, MeasuredMachine(), options).value();
    ASSERT_TRUE(plan.holds) << plan.reason;
    EXPECT_LE(plan.jerk_mm_s3, 800000 * 1.0001);
    EXPECT_LE(plan.worst_mm(), kToleranceMm * 1.0001);
  }
}

// Each of many nodes keeps its limits: what is corrected at one moves no other one on
// the clock of the setpoints.
TEST(PlanCourse, HoldsAtEveryNodeOfALongContour) {
  const Path path = JoinedPath(CutProgram(100, kFeedMmS, 3));
  const CoursePlan plan =
      PlanCourse(path, MeasuredMachine(), CompensatedOptions()).value();
  EXPECT_TRUE(plan.holds) << plan.reason;
  EXPECT_LE(plan.worst_mm(), kToleranceMm * 1.0001);
  EXPECT_LE(plan.motor_mm_s2, 11000 * 1.0001);
}

// The soft machine of figure 2 cannot hold 100 um by speed alone: stopping at every node
// leaves 182 um.
TEST(PlanCourse, ReportsWhatCannotBeHeld) {
  PlanOptions options;
  options.tolerance_mm = 0.001;
  options.rounds = 1;
  const CoursePlan plan =
      PlanCourse(CornerPath(0, 1.5, 20, 100), TunedAxes(55, 105, 0.3, 0.3), options)
          .value();
  EXPECT_FALSE(plan.holds);
  EXPECT_GT(plan.worst_mm(), 0.001);
  EXPECT_THAT(plan.reason, testing::HasSubstr("at node"));
}

TEST(PlanCourse, RefusesOptionsByName) {
  const Path path = CornerPath(0, 1.5, 20, 100);
  PlanOptions options;
  options.tolerance_mm = 0;
  EXPECT_EQ(PlanCourse(path, MeasuredMachine(), options).error().message,
            "tolerance_mm 0 is outside 0.0001..10");
  options = {};
  options.compensate = true;
  EXPECT_EQ(PlanCourse(path, MeasuredMachine(), options).error().code,
            ErrorCode::kMissing);
}

// The same plan bit for bit.
TEST(PlanCourse, IsDeterministic) {
  const Path path = CutProgram(0.3, kFeedMmS, 80, {0, 0, 0, 1}).front();
  const CoursePlan a = PlanCourse(path, MeasuredMachine(), CompensatedOptions()).value();
  const CoursePlan b = PlanCourse(path, MeasuredMachine(), CompensatedOptions()).value();
  EXPECT_EQ(a.law.node_speed_mm_s, b.law.node_speed_mm_s);
}

}  // namespace
}  // namespace intaglio::course
