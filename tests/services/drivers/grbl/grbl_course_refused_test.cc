// A grbl refuses any one line of a run of marks ("error:N"), and goes on with those that
// follow in its buffer: nothing is lit or cut beside the marks.

#include <gtest/gtest.h>

#include "tests/services/drivers/grbl/course_rig.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// The controller's arcs (grbl_course_test.cc) and a corner's braking leave this much.
constexpr double kNear_mm = 0.002;
// A busy computer stalls so long; enough for all that the driver sends ahead.
constexpr int kStall_ms = 200;

/// Corners, an arc, and chords far shorter than the driver's pieces.
mark::MarkSet Shapes(const mark::Pen& pen) {
  mark::MarkSet set{{pen}, {}};
  mark::Mark arc;
  arc.places = {{{6, 0}}, {{6, 2}, -0.8}, {{8, 2}}, {{8, 0.5}}};
  mark::Mark fine;
  for (int i = 0; i < 12; ++i)
    fine.places.push_back({{-2 + 0.15 * i, 3 + (i % 3 == 0 ? 0.1 : 0.0)}});
  set.marks = {SquareAt(1, 1, 1.5), arc, fine};
  return set;
}

class GrblCourseRefusedLine : public ::testing::TestWithParam<CourseToolKind> {
 protected:
  bool is_laser() const { return GetParam() == COURSE_TOOL_LASER; }

  /// The farthest place at work from every mark, mm, by the controller's own record.
  double OffTheMarks(const CourseRig& rig, const mark::MarkSet& set) const {
    constexpr int kPlaces = 20;
    const double steps_per_mm = 10000;
    double worst_mm = 0;
    Vec3 from = Vec3::Zero();
    for (const grbl::WayEnd& end : rig.machine.grbl.motion().way()) {
      const Vec3 to =
          Vec3(double(end.at[0]), double(end.at[1]), double(end.at[2])) / steps_per_mm;
      for (int i = 0; i <= kPlaces; ++i) {
        const Vec3 place = from + (to - from) * i / kPlaces;
        if (is_laser() ? !end.on || from == to : place.z() > -1e-3) continue;
        EXPECT_TRUE(end.on) << "the spindle rests in the work";
        double nearest_mm = 1e9;
        for (const mark::Mark& mark : set.marks)
          nearest_mm = std::min(nearest_mm, DistanceToMark(place.head<2>(), mark));
        worst_mm = std::max(worst_mm, nearest_mm);
      }
      from = to;
    }
    return worst_mm;
  }

  /// Nothing turns the host, so nothing stops what the controller has.
  static void Stall(CourseRig& rig) {
    for (int i = 0; i < kStall_ms; ++i) rig.machine.Advance();
  }
  /// False: the run had no such line.
  bool RefuseOne(std::uint64_t line) const {
    CourseRig rig(GetParam());
    EXPECT_TRUE(rig.Ready());
    mark::Pen pen = is_laser() ? LaserPen() : MillPen();
    pen.pass_count = is_laser() ? 1 : 2;
    const mark::MarkSet set = Shapes(pen);
    rig.machine.grbl.RefuseLineBehind(line);
    // The rest of what was appended is not begun behind the refused line.
    EXPECT_TRUE(rig.driver->Begin(1, set.pens));
    for (std::uint32_t i = 0; i < set.marks.size(); ++i)
      EXPECT_TRUE(rig.driver->Append({i, set.marks[i]}));
    EXPECT_TRUE(rig.driver->Finish());
    EXPECT_TRUE(rig.StepUntil(
        [&] { return !rig.machine.grbl.refuses() || rig.driver->state().settled; }));
    if (!rig.machine.grbl.refuses()) Stall(rig);
    EXPECT_TRUE(rig.StepUntil([&] { return rig.driver->state().settled; })) << line;
    rig.StepFor(500ms);
    EXPECT_LE(OffTheMarks(rig, set), kNear_mm) << "line " << line << " was refused";
    if (rig.machine.grbl.refuses()) return false;
    EXPECT_FALSE(rig.machine.grbl.spindle_on()) << line;
    EXPECT_NE(rig.driver->state().fault, "") << line;
    EXPECT_LT(rig.CountOf(MarkFate::kDone), set.marks.size() + (is_laser() ? 0U : 1U));
    return true;
  }
};

TEST_P(GrblCourseRefusedLine, ARowOfDotsIsNotOneOfContours) {
  CourseRig rig(GetParam());
  ASSERT_TRUE(rig.Ready());
  const mark::Mark row{0, false, 0, {{{0, 0}}, {{1, 0}, 0, true}, {{2, 0}}, {{3, 0}}}};
  ASSERT_TRUE(rig.driver->Begin(1, std::vector{is_laser() ? LaserPen() : MillPen()}));
  const auto refused = rig.driver->Append({0, row});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(refused.error().message.starts_with("mark 0: is a row of dots"));
}

TEST_P(GrblCourseRefusedLine, LightsAndCutsNothingBesideTheMarks) {
  std::uint64_t line = 0;
  while (!HasFailure() && RefuseOne(line)) ++line;
  EXPECT_GE(line, 39U) << "all lines of three marks";
}

INSTANTIATE_TEST_SUITE_P(, GrblCourseRefusedLine,
                         ::testing::Values(COURSE_TOOL_LASER, COURSE_TOOL_SPINDLE),
                         [](const auto& row) {
                           return row.param == COURSE_TOOL_LASER ? "Laser" : "Spindle";
                         });

}  // namespace
}  // namespace intaglio::drivers
