// What the comparison of cuts finds: ways of a tool that are right, and each with one
// planted fault. Areas by formulas of the swept shapes.

#include "engrave/proof/cut_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace intaglio::proof {
namespace {

using std::numbers::pi;

/// A square of 10 mm about the origin, and a hole beside it.
mark::MarkSet SquareAndHole() {
  mark::Mark square, hole;
  square.closed = true;
  square.places = {{{-5, -5}}, {{5, -5}}, {{5, 5}}, {{-5, 5}}};
  hole.pen = 1;
  hole.places = {{{9, 0}}};
  mark::Pen contours, holes;
  contours.pass_count = 2;
  contours.depth_mm = 0.4;
  holes.depth_mm = 0.4;
  return {{contours, holes}, {square, hole}};
}

/// A tool that makes it, as a controller would; what a test plants is a field.
struct Miller {
  double z_mm = 0, shift_mm = 0;
  int passes = 2;
  bool makes_hole = true, spins = true;
  double end_ratio = 1;  ///< of the last side

  formats::ToolWay way{{1, 1.6, 0, false}, {}, 0};

  void To(double x, double y, double z) {
    us += 1000;
    way.steps.push_back({us, {x + shift_mm, y, z}, 10000, spins});
  }
  formats::ToolWay Make() {
    To(-5, -5, 5);
    for (int pass = 1; pass <= passes; ++pass) {
      const double z = z_mm - 0.2 * pass;
      To(-5, -5, z);
      To(5, -5, z);
      To(5, 5, z);
      To(-5, 5, z);
      To(-5, 5 - 10 * end_ratio, z);
      if (end_ratio < 1) {
        To(-5, 5 - 10 * end_ratio, 5);
        To(-5, -5, 5);
      }
    }
    if (end_ratio == 1) To(-5, -5, 5);
    if (!makes_hole) return way;
    To(9, 0, 5);
    To(9, 0, z_mm - 0.4);
    To(9, 0, 5);
    return way;
  }
  std::uint64_t us = 0;
};

CutComparison Compared(const formats::ToolWay& way, double diameter_mm = 1) {
  const auto compared = CompareCuts(SquareAndHole(), {diameter_mm, true, 0.02}, way);
  if (!compared) throw std::runtime_error(compared.error().message);
  return *compared;
}

bool IsRight(const CutFigures& f) {
  return f.pieces_left == f.pieces_planned && f.pieces_joined == 0 &&
         f.pieces_split == 0 && f.beside_mm2 == 0 && f.uncut_mm2 == 0 &&
         f.too_deep_mm2 == 0 && f.through_mm2 == 0 && f.stray_mm == 0 &&
         f.idle_in_sheet_mm == 0;
}

TEST(CutComparison, AWayThatIsRightHasNoFault) {
  const CutComparison compared = Compared(Miller().Make());
  EXPECT_TRUE(IsRight(compared.figures));
  EXPECT_EQ(compared.marks.made_count, 2U);
  // Within the square, and around it.
  EXPECT_EQ(compared.figures.pieces_left, 2U);
  EXPECT_NEAR(compared.figures.deepest_mm, 0.4, 1e-9);
  // A frame 1 mm wide with round outer corners, and a disc of 1 mm.
  const double area_mm2 = 4 * 10 * 1 - 4 * 0.25 + pi * 0.25 + pi * 0.25;
  EXPECT_NEAR(compared.figures.cleared_mm2, area_mm2, 0.05);
  for (const BurntMark& mark : compared.marks.marks) {
    EXPECT_LT(mark.offset_mm.norm(), 1e-6);
    EXPECT_LT(mark.shape_um, 1e-3);
  }
}

TEST(CutComparison, AWiderToolClearsBesideThePlanAndANarrowerOneLeavesOfIt) {
  Miller wide, narrow;
  wide.way.header.tool_diameter_mm = 1.2;
  narrow.way.header.tool_diameter_mm = 0.8;
  const CutFigures more = Compared(wide.Make()).figures;
  // 0.1 mm less the tolerance, on both sides of the square.
  EXPECT_NEAR(more.beside_mm2, 2 * 40 * 0.08, 1);
  EXPECT_EQ(more.uncut_mm2, 0);
  const CutFigures less = Compared(narrow.Make()).figures;
  EXPECT_NEAR(less.uncut_mm2, 2 * 40 * 0.08, 1);
  EXPECT_EQ(less.beside_mm2, 0);
}

TEST(CutComparison, DepthsAreCompared) {
  Miller deep, shallow;
  deep.z_mm = -0.04;
  shallow.z_mm = 0.04;
  EXPECT_GT(Compared(deep.Make()).figures.too_deep_mm2, 39);
  EXPECT_GT(Compared(shallow.Make()).figures.uncut_mm2, 38.4);
}

TEST(CutComparison, AnOpenContourJoinsWhatIsToBeApart) {
  Miller miller;
  miller.end_ratio = 0.7;
  const CutComparison compared = Compared(miller.Make());
  EXPECT_EQ(compared.figures.pieces_left, 1U);
  EXPECT_EQ(compared.figures.pieces_planned, 2U);
  EXPECT_EQ(compared.figures.pieces_joined, 2U);
  EXPECT_NEAR(compared.marks.marks[0].pass_count, 2 * 0.925, 0.02);
}

TEST(CutComparison, WhatIsMissingOrDoubledIsNamed) {
  Miller once, thrice, without;
  once.passes = 1;
  without.makes_hole = false;
  EXPECT_EQ(Compared(once.Make()).marks.marks[0].fate, BurntFate::kIncomplete);
  EXPECT_EQ(Compared(without.Make()).marks.marks[1].fate, BurntFate::kMissed);
  formats::ToolWay twice = thrice.Make();
  const auto steps = twice.steps;
  twice.steps.insert(twice.steps.end(), steps.begin(), steps.end());
  const CutComparison compared = Compared(twice);
  EXPECT_EQ(compared.marks.marks[0].fate, BurntFate::kDoubled);
  EXPECT_EQ(compared.marks.marks[1].fate, BurntFate::kDoubled);
}

TEST(CutComparison, AShiftIsAnErrorOfPlaceAlone) {
  Miller miller;
  miller.shift_mm = 0.015;
  const CutComparison compared = Compared(miller.Make());
  EXPECT_NEAR(compared.marks.marks[0].offset_mm.x(), 0.015, 1e-6);
  EXPECT_LT(compared.marks.marks[0].shape_um, 1e-3);
  EXPECT_NEAR(compared.marks.marks[1].offset_mm.x(), 0.015, 1e-6);
}

TEST(CutComparison, WayBesideTheMarksAndASpindleAtRestAreFaults) {
  Miller stray, still;
  formats::ToolWay way = stray.Make();
  way.steps.push_back({way.steps.back().end_us + 1, {9, 5, 5}, 10000, true});
  way.steps.push_back({way.steps.back().end_us + 1, {9, 5, -0.4}, 10000, true});
  way.steps.push_back({way.steps.back().end_us + 1, {12, 5, -0.4}, 10000, true});
  EXPECT_GE(Compared(way).figures.stray_mm, 3);
  still.spins = false;
  EXPECT_GT(Compared(still.Make()).figures.idle_in_sheet_mm, 80);
}

TEST(CutComparison, ASheetThatIsToHoldIsNotCutThrough) {
  Miller thin;
  thin.way.header.sheet_thickness_mm = 0.3;
  const formats::ToolWay way = thin.Make();
  const auto cut = CompareCuts(SquareAndHole(), {1, true, 0.02}, way);
  const auto isolated = CompareCuts(SquareAndHole(), {1, false, 0.02}, way);
  ASSERT_TRUE(cut && isolated);
  EXPECT_EQ(cut->figures.through_mm2, 0);
  EXPECT_NEAR(isolated->figures.through_mm2, isolated->figures.cleared_mm2, 1e-9);
}

TEST(CutComparison, ALaserIsAtWorkWhereItIsOn) {
  mark::MarkSet set = SquareAndHole();
  set.marks.pop_back();
  formats::ToolWay way{{0.2, 1.6, 0, true}, {}, 0};
  std::uint64_t us = 0;
  const auto to = [&](double x, double y, bool on) {
    way.steps.push_back({++us, {x, y, 0}, 600, on});
  };
  to(-5, -5, false);
  for (int pass = 0; pass < 2; ++pass) {
    to(5, -5, true), to(5, 5, true), to(-5, 5, true), to(-5, -5, true);
  }
  to(0, 0, false);
  const auto right = CompareCuts(set, {0.2, true, 0.02}, way);
  ASSERT_TRUE(right);
  EXPECT_TRUE(IsRight(right->figures));
  EXPECT_EQ(right->marks.made_count, 1U);
  way.steps.back().is_on = true;  // it burns on its way
  const auto wrong = CompareCuts(set, {0.2, true, 0.02}, way);
  ASSERT_TRUE(wrong);
  EXPECT_GT(wrong->figures.stray_mm, 7);
  EXPECT_GT(wrong->figures.beside_mm2, 1);
}

}  // namespace
}  // namespace intaglio::proof
