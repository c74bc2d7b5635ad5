#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "engrave/course/linear_program.h"
#include "engrave/course/plan.h"
#include "engrave/course/swing_maker.h"
#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/course/oracle.h"

namespace intaglio::course {
namespace {

/// The greatest gain over all corners of a polygon, by trying each pair of its sides.
double GreatestAtCorners(const LinearProgram& program) {
  double greatest = -1e300;
  for (Eigen::Index i = 0; i < program.rows.rows(); ++i) {
    for (Eigen::Index k = 0; k < i; ++k) {
      Eigen::Matrix2d sides;
      sides << program.rows.row(i), program.rows.row(k);
      if (std::abs(sides.determinant()) < 1e-9) continue;
      const Eigen::Vector2d corner =
          sides.inverse() * Eigen::Vector2d(program.limits[i], program.limits[k]);
      const Eigen::VectorXd over = program.rows * corner - program.limits;
      if (over.maxCoeff() <= 1e-9)
        greatest = std::max(greatest, program.gain.dot(corner));
    }
  }
  return greatest;
}

TEST(LinearProgram, FindsTheBestCornerOfPolygons) {
  for (int seed = 0; seed < 50; ++seed) {
    constexpr Eigen::Index kSides = 9;
    LinearProgram program;
    program.rows.resize(kSides, 2);
    program.limits.resize(kSides);
    for (Eigen::Index i = 0; i < kSides; ++i) {
      const double at = 2 * std::numbers::pi * static_cast<double>(i) / kSides;
      program.rows.row(i) << std::cos(at), std::sin(at);
      program.limits[i] = 2 + std::sin(3.7 * seed + 2.3 * static_cast<double>(i * i));
    }
    program.gain = Eigen::Vector2d(std::cos(0.9 * seed), std::sin(0.9 * seed));
    const auto found = Maximize(program);
    ASSERT_TRUE(found);
    EXPECT_NEAR(program.gain.dot(*found), GreatestAtCorners(program), 1e-3);
    EXPECT_LE((program.rows * *found - program.limits).maxCoeff(), 1e-5);
  }
}

TEST(LinearProgram, FindsNoneWhenNoPointKeepsTheLimits) {
  LinearProgram program;
  program.rows.resize(2, 1);
  program.rows << 1, -1;
  program.limits = Eigen::Vector2d(-1, -1);  // x <= -1 and x >= 1
  program.gain = Eigen::VectorXd::Ones(1);
  EXPECT_FALSE(Maximize(program));
}

double TimeAt(const SpeedLaw& law, double s_mm) {
  double from_s = 0, to_s = law.duration_s;
  for (int i = 0; i < 60; ++i) {
    const double middle_s = (from_s + to_s) / 2;
    (SampleLaw(law, 1, middle_s, 1).front() < s_mm ? from_s : to_s) = middle_s;
  }
  return from_s;
}

/// Right angles to the left and to the right in turn.
Path StairsPath(double first_rad, int corners, double leg_mm, double feed_mm_s) {
  std::vector<Vec2> nodes_mm{Vec2::Zero()};
  for (int leg = 0; leg <= corners; ++leg) {
    const double at_rad = first_rad + (leg % 2 == 0 ? 0 : std::numbers::pi / 2);
    nodes_mm.push_back(nodes_mm.back() +
                       leg_mm * Vec2(std::cos(at_rad), std::sin(at_rad)));
  }
  return PolylinePath(nodes_mm, feed_mm_s);
}

struct CornerLimit {
  double motor_mm_s2, lost_s;
};

// What a right angle costs beside the same way straight on. A linear program solved
// beforehand for any command, which has the feed again 5 mm beside the corner, loses 24,
// 10, 2 and 2 ms (docs/measurements.md); a swing may begin farther away. Without swings
// it is 57, 38, 17 and 10 ms.
TEST(Swing, PassesRightAnglesWithoutLosingTime) {
  constexpr double kLegMm = 30, kSpeedMmS = 100;
  constexpr int kCorners = 6;
  constexpr std::array<CornerLimit, 4> kLimits{
      {{2000, 0.001}, {3000, 0.001}, {6000, 0.0015}, {11000, 0.001}}};
  for (const CornerLimit& limit : kLimits) {
    for (const double first : {0.0, std::numbers::pi / 2}) {
      const Path path = StairsPath(first, kCorners, kLegMm, kSpeedMmS);
      const AxisPair machine = MeasuredMachine();
      const CoursePlan plan =
          PlanCourse(path, machine, CompensatedOptions(limit.motor_mm_s2)).value();
      ASSERT_TRUE(plan.holds) << plan.reason;
      EXPECT_LE(plan.motor_mm_s2, limit.motor_mm_s2 * 1.0001);
      const double lost_s = TimeAt(plan.law, (kCorners + 0.5) * kLegMm) -
                            TimeAt(plan.law, 0.5 * kLegMm) -
                            kCorners * kLegMm / kSpeedMmS;
      EXPECT_LE(lost_s / kCorners, limit.lost_s) << limit.motor_mm_s2;
      const Tracked tracked = FollowPlan(path, plan, machine, machine);
      const auto actual = OracleFollow(OracleOf(machine), tracked.setpoints_mm,
                                       plan.tracking.period_s, 1);
      const OracleError error = OracleMeasure(path, actual, tracked.commanded_s_mm);
      // Runge-Kutta in steps of .1 ms, and cusps between the plan's samples.
      EXPECT_LE(error.one_sided_mm, 0.1 + 3e-4);
      EXPECT_LE(error.node_miss_mm, 0.1 + 3e-4);
    }
  }
}

// What the program promises for a corner is what the axes make of it, at each setpoint.
TEST(SwingMaker, KeepsItsLimitsBeforeAnyCorrection) {
  const AxisPair machine = MeasuredMachine();
  const Allowed allowed{0.1, 2000, 0};
  constexpr double kSpeedMmS = 100, kAccelerationMmS2 = 1500;
  const Tracking tracking(machine, {0.0005, 0, 0.06});
  for (const double half_s : {0.03, 0.072, 0.12}) {
    const SwingMaker maker(tracking, allowed, kAccelerationMmS2);
    const auto shape = maker.Make({Vec2(1, 0), Vec2(0, 1), kSpeedMmS, half_s});
    ASSERT_TRUE(shape) << half_s;
    const Path path = CornerPath(0, std::numbers::pi / 2, 60, kSpeedMmS);
    SpeedLaw law = PlanSpeeds(path, std::vector{shape->speed_mm_s}, kAccelerationMmS2);
    auto swings = std::make_shared<Swings>();
    swings->shapes = {*shape};
    swings->of_node = {{}, {0, Eigen::Matrix2d::Identity()}, {}};
    swings->longest_half_s = shape->half_s();
    law.swings = swings;
    const Evaluation found = Evaluate(path, law, tracking, allowed, Exactness::kAxes);
    EXPECT_LE(found.load_ratio[1], 1.002) << half_s;
    EXPECT_GE(found.load_ratio[1], shape->speed_mm_s < kSpeedMmS ? 0.95 : 0.5) << half_s;
  }
}

// A corner turned by half a turn, or mirrored, gets the same swing.
TEST(Swing, IsTheSameInTheMirror) {
  const PlanOptions options = CompensatedOptions(6000);
  const auto duration_s = [&](double first_rad, double turn_rad) {
    const Path path = CornerPath(first_rad, turn_rad, 30, 100);
    return PlanCourse(path, MeasuredMachine(), options).value().law.duration_s;
  };
  constexpr double kPi = std::numbers::pi;
  const double once_s = duration_s(0.3, 1.8);
  EXPECT_NEAR(duration_s(0.3 + kPi, 1.8), once_s, 1e-4);
  EXPECT_NEAR(duration_s(kPi - 0.3, -1.8), once_s, 1e-4);
}

// Kernels and swings of a contour never make it slower.
TEST(Swing, IsTakenWhereItIsFaster) {
  for (const Path& path : CutProgram(0.2, 100, 91, {0.5, 0.5, 0, 0})) {
    PlanOptions options = CompensatedOptions(6000);
    const CoursePlan swung = PlanCourse(path, MeasuredMachine(), options).value();
    options.swing = false;
    const CoursePlan plain = PlanCourse(path, MeasuredMachine(), options).value();
    ASSERT_TRUE(swung.holds && plain.holds);
    EXPECT_LT(swung.law.duration_s, plain.law.duration_s);
  }
}

}  // namespace
}  // namespace intaglio::course
