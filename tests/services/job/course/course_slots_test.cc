#include "services/job/course/course_slots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "engrave/post/tab_parts.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/course/course_work.h"
namespace intaglio {
namespace {

using std::numbers::pi;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::SizeIs;

Course SlotCourse(CourseMake make, double tool_mm) {
  Course course;
  course.set_make(make);
  course.set_tool_diameter_mm(tool_mm);
  course.set_depth_mm(1.7);
  return course;
}

struct Added {
  CourseFiles files;
  Warnings warnings;
};

Added Add(const Course& course, const std::vector<contour::Element>& slots) {
  Added added;
  const Status done = AddSlots(course, "a.drl", slots, added.files, added.warnings);
  EXPECT_TRUE(done) << done.error().message;
  return added;
}

contour::Element Straight(double length_mm, double width_mm) {
  return {contour::Track{{1, 1}, {1 + length_mm, 1}, width_mm}};
}
contour::Element Round(double radius_mm, double sweep_rad, double width_mm) {
  return {
      contour::ArcTrack{contour::MakeArc({3, 2}, radius_mm, 0.4, sweep_rad), width_mm}};
}

contour::Edge MiddleOf(const contour::Element& slot) {
  if (const auto* arc = std::get_if<contour::ArcTrack>(&slot.shape)) return arc->arc;
  const auto& track = std::get<contour::Track>(slot.shape);
  return contour::MakeLine(track.begin_mm, track.end_mm);
}

// The oracle: a raster of points. One in the slot by more than a twentieth of its width
// is in a hole, and one beside it in none.
TEST(CourseSlots, RowsOfHolesLeaveCuspsOfATwentieth) {
  for (const double width_mm : {0.6, 1.0, 3.0}) {
    for (const contour::Element& slot :
         {Straight(0.1, width_mm), Straight(2.5, width_mm), Straight(40, width_mm),
          Round(1.6, 1, width_mm), Round(1.6, 2 * pi, width_mm)}) {
      const Added added =
          Add(SlotCourse(COURSE_MAKE_ISOLATION, 0.2), {contour::Element{slot.shape}});
      const contour::Edge middle = MiddleOf(slot);
      for (double x = -2; x < 44; x += 0.037) {
        for (double y = -3; y < 7; y += 0.037) {
          const double depth_mm = width_mm / 2 - contour::DistanceTo(middle, Vec2(x, y));
          bool cut = false;
          for (const contour::Hole& hole : added.files.holes)
            cut |= (hole.center_mm - Vec2(x, y)).norm() <= hole.diameter_mm / 2;
          if (depth_mm > 0.0501 * width_mm) {
            ASSERT_TRUE(cut) << x << " " << y;
          }
          if (depth_mm < -1e-9) {
            ASSERT_FALSE(cut) << x << " " << y;
          }
        }
      }
    }
  }
}

/// What a drill of this diameter finds drilled on its left less on its right along x.
double OneSided_mm2(const std::vector<Vec2>& drilled, const Vec2& at, double width_mm) {
  constexpr int kSteps = 60;
  const double step_mm = width_mm / kSteps;
  double sum = 0;
  for (double x = step_mm / 2; x < width_mm / 2; x += step_mm) {
    for (double y = step_mm / 2 - width_mm / 2; y < width_mm / 2; y += step_mm) {
      if (x * x + y * y > width_mm * width_mm / 4) continue;
      for (const double side : {-1.0, 1.0}) {
        const Vec2 place = at + Vec2(side * x, y);
        for (const Vec2& hole : drilled) {
          if ((hole - place).norm() > width_mm / 2) continue;
          sum -= side * step_mm * step_mm;
          break;
        }
      }
    }
  }
  return sum;
}

// The oracle: a raster of what the drill finds at each hole, in the order of the program.
TEST(CourseSlots, ADrillHasAsMuchMaterialOnBothSides) {
  for (const double length_mm : {0.9, 1.6, 2.1, 3.0, 4.4, 11.0, 40.0}) {
    Course course = SlotCourse(COURSE_MAKE_ISOLATION, 0.2);
    const Added added = Add(course, {Straight(length_mm, 1)});
    const auto tools = contour::PlanDrilling(added.files.holes, Vec2::Zero());
    ASSERT_THAT(tools, SizeIs(1));
    std::vector<Vec2> drilled;
    for (const std::uint32_t k : tools[0].holes) {
      const Vec2& at = added.files.holes[k].center_mm;
      const double sided_mm2 = OneSided_mm2(drilled, at, 1);
      drilled.push_back(at);
      // The second end of a slot shorter than its width is beside the first one.
      if (drilled.size() == 2 && length_mm < 1) continue;
      EXPECT_NEAR(sided_mm2, 0, 0.01) << "a slot of " << length_mm << " at " << at.x();
    }
  }
}

TEST(CourseSlots, ANoteHasTheHolesAndTheirCusps) {
  const Added added =
      Add(SlotCourse(COURSE_MAKE_ISOLATION, 0.2), {Straight(3, 0.8), Straight(0, 0.8)});
  // 9 parts of at most 0.43 * 0.8 mm, so 12, and their ends; the slot of no length is a
  // hole.
  EXPECT_THAT(added.files.holes, SizeIs(14));
  ASSERT_THAT(added.warnings, SizeIs(1));
  EXPECT_EQ(added.warnings[0].weight, WarningWeight::kNote);
  // (0.8 - sqrt(0.8^2 - (1 / 4)^2)) / 2
  EXPECT_THAT(added.warnings[0].text,
              AllOf(HasSubstr("a.drl: 2 slots of 0.8 mm are drilled as 14 holes"),
                    HasSubstr("ends first"), HasSubstr("cusps of up to 0.02 mm"),
                    HasSubstr("--make curves")));
}

TEST(CourseSlots, AToolAsWideFollowsTheMiddle) {
  const Added added =
      Add(SlotCourse(COURSE_MAKE_CURVES, 0.8), {Straight(3, 0.8), Round(2, 1, 0.8)});
  EXPECT_TRUE(added.files.holes.empty());
  ASSERT_THAT(added.files.curves, SizeIs(2));
  EXPECT_FALSE(added.files.curves[0].closed);
  EXPECT_EQ(added.files.curves[0].edges[0].end_mm, Vec2(4, 1));
  EXPECT_NEAR(contour::LengthOf(added.files.curves[1].edges), 2, 1e-9);
}

// By geometry: along the wall the tool's centre is (width - tool) / 2 from the middle.
TEST(CourseSlots, ASmallerToolFollowsTheWall) {
  for (const contour::Element& slot :
       {Straight(3, 1.5), Straight(0, 1.5), Round(2, 1, 1.5), Round(2, 2 * pi, 1.5)}) {
    const Added added = Add(SlotCourse(COURSE_MAKE_CURVES, 0.6), {slot});
    ASSERT_FALSE(added.files.curves.empty());
    double length_mm = 0;
    for (const DrawnCurve& curve : added.files.curves) {
      EXPECT_TRUE(curve.closed);
      length_mm += contour::LengthOf(curve.edges);
      for (const contour::Edge& edge : curve.edges) {
        for (const double part : {0.0, 0.3, 0.7}) {
          const Vec2 place = contour::PointAt(edge, part * edge.length_mm);
          const contour::Edge middle = MiddleOf(slot);
          const double from_mm = middle.length_mm == 0
                                     ? (place - middle.begin_mm).norm()
                                     : contour::DistanceTo(middle, place);
          EXPECT_NEAR(from_mm, 0.45, 1e-5);
        }
      }
    }
    EXPECT_GT(length_mm, 2 * MiddleOf(slot).length_mm);
    EXPECT_THAT(added.warnings[0].text,
                AllOf(HasSubstr("1 slot of 1.5 mm is cut with the tool of 0.6 mm"),
                      HasSubstr("1.7 mm deep")));
  }
}

TEST(CourseSlots, HaveNoTabs) {
  Course course = SlotCourse(COURSE_MAKE_CURVES, 0.6);
  course.set_tab_count(1);
  course.set_tab_width_mm(2);
  Added added = Add(course, {Straight(30, 1.5)});
  const auto work = MakeContourWork(WithDefaults(course), added.files, Vec2::Zero());
  ASSERT_TRUE(work) << work.error().message;
  ASSERT_THAT(work->paths, SizeIs(1));
  EXPECT_FALSE(post::HasTabs(work->paths[0]));
  // The same as a curve of a drawing.
  added.files.curves[0].opening = false;
  const auto part = MakeContourWork(WithDefaults(course), added.files, Vec2::Zero());
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_TRUE(post::HasTabs(part->paths[0]));
}

TEST(CourseSlots, AWiderToolAndALaserAreWarningsWithFigures) {
  const Added wide =
      Add(SlotCourse(COURSE_MAKE_CURVES, 1), {Straight(3, 0.8), Straight(3, 0.7)});
  EXPECT_TRUE(wide.files.curves.empty());
  ASSERT_THAT(wide.warnings, SizeIs(1));
  EXPECT_EQ(wide.warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(wide.warnings[0].text,
              AllOf(HasSubstr("2 slots of 0.7 to 0.8 mm are left out"),
                    HasSubstr("the tool of 1 mm is wider; use one of 0.7 mm or less")));
  Course laser = SlotCourse(COURSE_MAKE_ISOLATION, 0.1);
  laser.set_power_ratio(0.5);
  const Added burnt = Add(laser, {Straight(3, 0.8)});
  EXPECT_TRUE(burnt.files.holes.empty());
  ASSERT_THAT(burnt.warnings, SizeIs(1));
  EXPECT_EQ(burnt.warnings[0].weight, WarningWeight::kWarning);
}

}  // namespace
}  // namespace intaglio
