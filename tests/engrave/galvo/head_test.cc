// The optics of a head against rays that are reflected at two mirrors.

#include "engrave/galvo/head.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/engrave/galvo/traced_head.h"

namespace intaglio::galvo {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Head LensOf721() {
  return {LensPlace::kBehindMirrors, {255.059, -1.365, 1.493, -18.087}, 0, 0};
}

TEST(ScanHead, WithTheLensBehindItsMirrorsPutsTheBeamWhereATracedRayArrives) {
  const Head head = LensOf721();
  for (int i = -4; i <= 4; ++i) {
    for (int j = -4; j <= 4; ++j) {
      const Vec2 angles = kDegree * 5 * Vec2(i, j);
      const Vec2 traced_mm = TracedThroughLens(angles.x(), angles.y(), head.heights_mm);
      // acos of the traced ray is exact to 1e-8 rad near the axis: 3e-6 mm.
      EXPECT_LT((FieldOf(angles, head) - traced_mm).norm(), 1e-5) << angles;
    }
  }
}

TEST(ScanHead, WithTheLensBeforeItsMirrorsPutsTheBeamWhereATracedRayArrives) {
  const Head head{LensPlace::kBeforeMirrors, {}, 100, 12};
  for (const double ax : {-20, -7, 0, 11, 20}) {
    for (const double ay : {-20, -9, 0, 4, 20}) {
      const Vec2 traced_mm = TracedWithoutLens(kDegree * ax, kDegree * ay, 100, 12);
      EXPECT_LT((FieldOf(kDegree * Vec2(ax, ay), head) - traced_mm).norm(), 1e-12)
          << ax << ", " << ay;
    }
  }
}

TEST(ScanHead, IsFourMillimetresOffWithThePrinted1InPlaceOfTheMirrorsDistance) {
  const Head right{LensPlace::kBeforeMirrors, {}, 100, 12};
  const Head printed{LensPlace::kBeforeMirrors, {}, 100, 1};
  const Vec2 angles = kDegree * Vec2(20, 20);
  EXPECT_NEAR((FieldOf(angles, right) - FieldOf(angles, printed)).x(), 4.0, 0.01);
}

TEST(ScanHead, FindsTheAnglesOfEveryPlace) {
  for (const Head& head : {LensOf721(), Head{LensPlace::kBeforeMirrors, {}, 100, 12}}) {
    for (int i = -10; i <= 10; ++i) {
      for (int j = -10; j <= 10; ++j) {
        const Vec2 place_mm = 10.1 * Vec2(i, j);
        const auto angles = AnglesFor(place_mm, head);
        ASSERT_TRUE(angles.has_value()) << angles.error().message;
        // 1e-12 of 143 mm.
        EXPECT_LT((FieldOf(*angles, head) - place_mm).norm(), 2e-10);
      }
    }
  }
}

TEST(ScanHead, RefusesAPlaceThatTheLensDoesNotReach) {
  const auto angles = AnglesFor({400, 0}, LensOf721());
  ASSERT_FALSE(angles.has_value());
  EXPECT_EQ(angles.error().message,
            "the lens has no height of 400 mm; give a place nearer the centre, or check "
            "the lens polynomial");
}

TEST(ScanHead, RefusesNumbersOutsideTheirRangesByName) {
  EXPECT_EQ(CheckHead({LensPlace::kBehindMirrors, {0, 0, 0, 0}, 0, 0}).error().message,
            "head: heights_mm[0] is 0; give the focal length, above 0");
  EXPECT_EQ(CheckHead({LensPlace::kBeforeMirrors, {}, -1, 0}).error().message,
            "head: distance_mm is -1; give more than 0");
  EXPECT_EQ(CheckHead({LensPlace::kBeforeMirrors, {}, 1, -2}).error().message,
            "head: mirror_gap_mm is -2; give 0 or more");
  EXPECT_TRUE(CheckHead(LensOf721()).has_value());
}

}  // namespace
}  // namespace intaglio::galvo
