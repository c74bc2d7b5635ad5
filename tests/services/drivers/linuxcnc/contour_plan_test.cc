// Contours as setpoints of LinuxCNC's axes: judged by axes that are integrated here.
#include "services/drivers/linuxcnc/marks/contour_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "services/drivers/interface/mark_edges.h"
#include "services/drivers/linuxcnc/marks/course_profile.h"
#include "services/drivers/linuxcnc/marks/mark_rows.h"
#include "services/job/plan/course_motion.h"
#include "tests/services/drivers/linuxcnc/driven_axes.h"

namespace intaglio::drivers {
namespace {

using linuxcnc::Driven;
using ::testing::HasSubstr;

constexpr double kPeriod_s = 1e-3;

MachineSpec Cutter(double tolerance_um = 20) {
  MachineSpec machine;
  machine.set_name("cutter");
  machine.mutable_mark_line()->set_protocol("linuxcnc-course");
  machine.mutable_mark_line()->set_device("/run/intaglio-linuxcnc");
  for (AxisLimits* axis : {machine.mutable_x(), machine.mutable_y()}) {
    axis->set_travel_min_mm(-50);
    axis->set_travel_max_mm(50);
    axis->set_max_speed_mm_s(60);
    axis->set_max_acceleration_mm_s2(2000);
  }
  machine.set_position_tolerance_um(tolerance_um);
  machine.mutable_course_tool()->set_kind(COURSE_TOOL_LASER);
  return machine;
}

mark::Pen Pen(double speed_mm_s) {
  mark::Pen pen;
  pen.name = "cut";
  pen.speed_mm_s = speed_mm_s;
  pen.power_ratio = 1;
  return pen;
}

/// Eight corners, each of 90 degrees or more, and a half circle.
mark::Mark Comb() {
  mark::Mark mark;
  mark.places = {{{0, 0}}, {{6, 0}},    {{6, 4}}, {{2, 1}}, {{4, 6}},
                 {{1, 6}}, {{1, 9}, 1}, {{5, 9}}, {{9, 9}}, {{9, 0}}};
  return mark;
}

double DistanceTo(const contour::Edges& edges, const Vec2& at_mm) {
  double nearest_mm = 1e9;
  for (const contour::Edge& edge : edges)
    nearest_mm = std::min(nearest_mm, contour::DistanceTo(edge, at_mm));
  return nearest_mm;
}

/// All that is lit is within `tolerance_mm` of the contour, and all of it is lit.
void ExpectCut(const ContourPlan& plan, const std::vector<Vec2>& actual_mm,
               const contour::Edges& edges, double tolerance_mm) {
  contour::Edges lit;
  double worst_mm = 0;
  for (std::size_t i = plan.lit_begin; i + 1 < plan.lit_end; ++i) {
    worst_mm = std::max(worst_mm, DistanceTo(edges, actual_mm[i]));
    if ((actual_mm[i + 1] - actual_mm[i]).norm() > 1e-9)
      lit.push_back(contour::MakeLine(actual_mm[i], actual_mm[i + 1]));
  }
  EXPECT_LE(worst_mm, tolerance_mm);
  double missed_mm = 0;
  for (const contour::Edge& edge : edges) {
    for (int k = 0; k <= 20; ++k)
      missed_mm = std::max(
          missed_mm, DistanceTo(lit, contour::PointAt(edge, edge.length_mm * k / 20)));
  }
  EXPECT_LE(missed_mm, tolerance_mm);
}

TEST(ContourPlan, KeepsTheToleranceWithIdealAxesAndIsFasterThanStops) {
  const MachineSpec machine = Cutter();
  const auto plan = PlanContour(Comb(), Pen(50), machine, kPeriod_s);
  ASSERT_TRUE(plan) << plan.error().message;
  const contour::Edges edges = EdgesOfMark(Comb());
  ExpectCut(*plan, plan->setpoints_mm, edges, 0.0205);
  const auto path = CoursePathAlong(edges, 50).value();
  const std::vector<double> stops(path.node_count() - 2, 0);
  const double stopping_s = course::PlanSpeeds(path, stops, 2000).duration_s;
  EXPECT_LT(plan->duration_s, 0.95 * stopping_s);
  // The beam is on for the law, and for what the kernel smooths it by.
  const double lit_s = kPeriod_s * static_cast<double>(plan->lit_end - plan->lit_begin);
  EXPECT_NEAR(lit_s, plan->duration_s, 0.02);
}

TEST(ContourPlan, KeepsTheAccelerationOfTheAxes) {
  const auto plan = PlanContour(Comb(), Pen(50), Cutter(), kPeriod_s);
  ASSERT_TRUE(plan) << plan.error().message;
  const auto& c = plan->setpoints_mm;
  double worst = 0;
  for (std::size_t i = 1; i + 1 < c.size(); ++i)
    worst = std::max(worst, (c[i + 1] - 2 * c[i] + c[i - 1]).cwiseAbs().maxCoeff() /
                                (kPeriod_s * kPeriod_s));
  EXPECT_LE(worst, 2000 * 1.05);
  EXPECT_LT((c[1] - c[0]).norm(), 1e-6) << "it begins at rest";
  EXPECT_LT((c[c.size() - 1] - c[c.size() - 2]).norm(), 1e-6) << "it ends at rest";
}

TEST(ContourPlan, AccountsForTheDriveOfTheProfile) {
  MachineSpec machine = Cutter();
  machine.mutable_second_order()->set_natural_frequency_hz(25);
  machine.mutable_second_order()->set_damping_ratio(0.4);
  const auto plan = PlanContour(Comb(), Pen(50), machine, kPeriod_s);
  ASSERT_TRUE(plan) << plan.error().message;
  const contour::Edges edges = EdgesOfMark(Comb());
  const double natural_rad_s = 2 * std::numbers::pi * 25;
  ExpectCut(*plan, Driven(plan->setpoints_mm, natural_rad_s, 0.4, kPeriod_s), edges,
            0.022);
  // A plan for axes without a lag is far off on these.
  const auto ideal = PlanContour(Comb(), Pen(50), Cutter(), kPeriod_s);
  ASSERT_TRUE(ideal);
  double off_mm = 0;
  for (const Vec2& at_mm : Driven(ideal->setpoints_mm, natural_rad_s, 0.4, kPeriod_s))
    off_mm = std::max(off_mm, DistanceTo(edges, at_mm));
  EXPECT_GT(off_mm, 0.05);
}

TEST(ContourPlan, GivesTheRowsOfEveryPassInOrder) {
  const MachineSpec machine = Cutter();
  auto plan = PlanContour(Comb(), Pen(50), machine, kPeriod_s);
  ASSERT_TRUE(plan);
  const std::size_t lit_count = plan->lit_end - plan->lit_begin;
  const Vec2 origin_mm(3, -2);
  MarkRows rows(Vec3(60, 60, 0), Vec3(2000, 2000, 0));
  rows.Begin(std::make_shared<ContourPlan>(*plan), 2, Vec3(-20, 5, 7), origin_mm);
  std::size_t lit = 0, begins = 0;
  bool was_lit = false;
  Vec3 before_mm(-20, 5, 7);
  while (rows.active()) {
    const MarkRows::Row row = rows.Next(kPeriod_s);
    EXPECT_LE((row.place_mm - before_mm).cwiseAbs().maxCoeff(), 60 * kPeriod_s * 1.01);
    EXPECT_EQ(row.place_mm.z(), 7);
    if (row.lit && !was_lit) {
      ++begins;
      EXPECT_LT((before_mm.head<2>() - origin_mm - Vec2(0, 0)).norm(), 2e-3);
    }
    lit += row.lit ? 1 : 0;
    was_lit = row.lit;
    before_mm = row.place_mm;
    EXPECT_EQ(row.last, !rows.active());
  }
  EXPECT_EQ(begins, 2u);
  EXPECT_EQ(lit, 2 * lit_count);
}

TEST(ContourPlan, IsCancelled) {
  EXPECT_THROW((void)PlanContour(Comb(), Pen(1), Cutter(), kPeriod_s,
                                 [](std::uint64_t, std::uint64_t) { return false; }),
               std::runtime_error);
}

TEST(ContourPlan, NamesAToleranceThatCannotBeKept) {
  MachineSpec machine = Cutter(1);
  machine.mutable_second_order()->set_natural_frequency_hz(1);
  machine.mutable_second_order()->set_damping_ratio(0.02);
  const auto plan = PlanContour(Comb(), Pen(50), machine, kPeriod_s);
  if (plan) GTEST_SKIP() << "it can be kept";
  EXPECT_THAT(plan.error().message, HasSubstr("position_tolerance_um"));
}

TEST(LinuxcncCourseProfile, IsCheckedFieldByField) {
  EXPECT_TRUE(CheckLinuxcncCourseProfile(Cutter()).empty());
  const auto first = [](const MachineSpec& machine) {
    const auto errors = CheckLinuxcncCourseProfile(machine);
    return errors.empty() ? "" : errors.front().message;
  };
  MachineSpec machine = Cutter();
  machine.mutable_course_tool()->set_kind(COURSE_TOOL_SPINDLE);
  EXPECT_THAT(first(machine), HasSubstr("course_tool.kind: COURSE_TOOL_SPINDLE"));
  machine = Cutter();
  machine.clear_y();
  EXPECT_THAT(first(machine), HasSubstr("y: is missing"));
  machine = Cutter();
  machine.mutable_x()->set_max_speed_mm_s(0);
  EXPECT_THAT(first(machine), HasSubstr("x.max_speed_mm_s: 0 is not above 0"));
  machine = Cutter(0);
  EXPECT_THAT(first(machine), HasSubstr("position_tolerance_um: is missing"));
  machine = Cutter();
  machine.mutable_polar();
  EXPECT_THAT(first(machine), HasSubstr("linear axes"));
}

TEST(LinuxcncCourseProfile, RefusesPensAndMarksByName) {
  const MachineSpec machine = Cutter();
  EXPECT_TRUE(CheckBeamPen(Pen(60), machine));
  const auto why = [&](auto change) {
    mark::Pen pen = Pen(50);
    change(pen);
    const Status checked = CheckBeamPen(pen, machine);
    return checked ? "" : checked.error().message;
  };
  EXPECT_THAT(why([](mark::Pen& pen) { pen.power_ratio = 0.4; }),
              HasSubstr("a power of 0.4"));
  EXPECT_THAT(why([](mark::Pen& pen) { pen.depth_mm = 0.2; }),
              HasSubstr("a depth of 0.2 mm"));
  EXPECT_THAT(why([](mark::Pen& pen) { pen.frequency_hz = 500; }), HasSubstr("500 Hz"));
  EXPECT_THAT(why([](mark::Pen& pen) { pen.speed_mm_s = 61; }),
              HasSubstr("61 mm/s is more than the 60"));
  EXPECT_TRUE(CheckBeamMark({0, Comb()}, Pen(50), machine));
  mark::Mark far = Comb();
  far.places.back().at_mm.x() = 51;
  const Status outside = CheckBeamMark({3, far}, Pen(50), machine);
  ASSERT_FALSE(outside);
  EXPECT_THAT(outside.error().message, HasSubstr("mark 3: 51.000, 0.000 mm"));
  EXPECT_THAT(CheckBeamMark({4, Comb()}, Pen(0.01), machine).error().message,
              HasSubstr("a contour is planned up to 3600 s"));
  mark::Mark hole;
  hole.places = {{{1, 1}}};
  EXPECT_THAT(CheckBeamMark({0, hole}, Pen(50), machine).error().message,
              HasSubstr("make it a circle"));
}

}  // namespace
}  // namespace intaglio::drivers
