// Slots and holes against copper and against each other; the oracle is dense sampling.

#include "services/job/course/course_holes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "services/job/course/course_files.h"

namespace intaglio {
namespace {

using std::numbers::pi;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

contour::Element Straight(const Vec2& begin, const Vec2& end, double width_mm) {
  return {contour::Track{begin, end, width_mm}};
}
contour::Element Round(const Vec2& center, double radius_mm, double sweep_rad,
                       double width_mm) {
  return {
      contour::ArcTrack{contour::MakeArc(center, radius_mm, 0.4, sweep_rad), width_mm}};
}
contour::Element Pad(const Vec2& center, double diameter_mm) {
  return {contour::Circle{center, diameter_mm}};
}

Warnings Of(const DrilledFile& file, const std::vector<contour::Element>& copper) {
  const auto warnings = WarningsOfHoles({file}, copper);
  EXPECT_TRUE(warnings) << warnings.error().message;
  return warnings.value_or(Warnings());
}

TEST(CourseHoles, SlotsBesideAllCopperAreAWarningWithFigures) {
  // In a pad by an end, by its middle, by its width alone, and beside by 0.1 mm.
  const DrilledFile file{
      "a.drl",
      {{{0, 0}, 0.8}},
      {Straight({0, 0}, {3, 0}, 0.8), Straight({-5, 10}, {5, 10}, 0.8),
       Straight({-5, 11.3}, {5, 11.3}, 0.8), Straight({-5, 11.5}, {5, 11.5}, 0.8),
       Round({0, 20}, 3, 2 * pi, 0.8)}};
  const Warnings warnings = Of(file, {Pad({0, 0}, 2), Pad({0, 10}, 2)});
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_EQ(warnings[0].weight, WarningWeight::kWarning);
  EXPECT_THAT(warnings[0].text,
              AllOf(HasSubstr("a.drl: 2 of 1 hole and 5 slots lie beside all copper"),
                    HasSubstr("the first a slot of 0.8 mm from (-5, 11.5) to (5, 11.5)"),
                    HasSubstr("copper from (-1, -1) to (1, 11) mm")));
  // The hole and the first slot; the slots at 11.3 and 11.5.
  EXPECT_THAT(warnings[1].text,
              AllOf(HasSubstr("a.drl: 2 pairs of holes and slots lie over each other"),
                    HasSubstr("by up to 0.8 mm"),
                    HasSubstr("0.8 mm at (0, 0) and a slot "
                              "of 0.8 mm from (0, 0)")));
}

TEST(CourseHoles, ARouteIsNotOverItself) {
  DrilledFile route{"a.drl", {}, {}};
  for (int k = 0; k < 40; ++k)
    route.slots.push_back(Straight(
        {5 * std::cos(k * pi / 20), 5 * std::sin(k * pi / 20)},
        {5 * std::cos((k + 1) * pi / 20), 5 * std::sin((k + 1) * pi / 20)}, 1.5));
  EXPECT_THAT(Of(route, {}), IsEmpty());
  route.slots.push_back(route.slots.front());
  route.slots.front() = Straight({5, 0}, {5, 1}, 1.5);
  EXPECT_THAT(Of(route, {}), SizeIs(1)) << "a slot more lies over the route";
}

/// The shortest distance of two middles by points on both, and how wrong it may be.
double Sampled_mm(const contour::Edge& a, const contour::Edge& b) {
  double nearest = 1e300;
  for (int i = 0; i <= 400; ++i)
    for (int k = 0; k <= 400; ++k)
      nearest = std::min(nearest, (contour::PointAt(a, a.length_mm * i / 400) -
                                   contour::PointAt(b, b.length_mm * k / 400))
                                      .norm());
  return nearest;
}

TEST(CourseHoles, PairsAreThoseOfDenseSampling) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 6), turn(-6, 6), width(0.3, 1);
  const auto any = [&] {
    const Vec2 at(place(random), place(random));
    if (random() % 2 == 0) return Straight(at, {place(random), place(random)}, 0.5);
    return Round(at, width(random), turn(random), width(random));
  };
  int over = 0, apart = 0;
  for (int k = 0; k < 300; ++k) {
    const contour::Element a = any(), b = any();
    const double free_mm = Sampled_mm(MiddleOfSlot(a), MiddleOfSlot(b)) -
                           (WidthOfSlot_mm(a) + WidthOfSlot_mm(b)) / 2;
    if (std::abs(free_mm) < 0.03) continue;  // half a step of both samplings
    const DrilledFile file{"a.drl", {}, {a, b}};
    EXPECT_EQ(Of(file, {}).size(), free_mm < 0 ? 1U : 0U) << k;
    (free_mm < 0 ? over : apart) += 1;
    // The same of one of them as copper.
    EXPECT_EQ(Of({"a.drl", {}, {a}}, {b}).size(), free_mm < 0 ? 0U : 1U) << k;
  }
  EXPECT_GT(over, 30);
  EXPECT_GT(apart, 30);
}

constexpr const char* kBoard = R"((kicad_pcb (version 20221018) (generator pcbnew)
  (layers (0 "F.Cu" signal) (31 "B.Cu" signal) (44 "Edge.Cuts" user)) (net 0 "") (net 1 "A")
  (footprint "x" (layer "F.Cu") (at 10 10)
    (pad "1" thru_hole oval (at 0 0) (size 2 4) (drill oval 1 3) (layers "*.Cu") (net 1 "A"))
    (pad "2" thru_hole circle (at 0 1.2) (size 2 2) (drill 0.8) (layers "*.Cu") (net 1 "A"))
    (pad "" np_thru_hole circle (at 9 9) (size 1 1) (drill 1) (layers "*.Cu")))
))";

// The end of the slot's middle is at 1 mm from its pad's, the hole at 1.2 mm: 0.2 mm
// apart, and their radii are 0.5 and 0.4 mm.
TEST(CourseHoles, AHoleOverASlotOfABoardOfKicadIsAWarning) {
  Course course;
  course.add_files("a.kicad_pcb");
  Warnings warnings;
  const auto files = CourseFilesOf(course, {kBoard}, {}, warnings);
  ASSERT_TRUE(files) << files.error().message;
  ASSERT_THAT(warnings, SizeIs(2));
  EXPECT_THAT(warnings[1].text, AllOf(HasSubstr("1 pair of holes and slots"),
                                      HasSubstr("by up to 0.7 mm")));
}

}  // namespace
}  // namespace intaglio
