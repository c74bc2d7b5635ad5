#include "engrave/machine/clearance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "engrave/optics/focus.h"
#include "engrave/optics/machine_frame.h"

namespace intaglio::machine {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// By sampling, and without a formula of the code: whether a body with its axis through
/// `focus` has a point within the box, on rings of its lowest face and what is above it.
bool Overlaps(const BeamBody& body, const Box3& box, const Vec3& focus_mm,
              double raised_mm) {
  const double bottom_mm = focus_mm.z() + body.bottom_above_focus_mm + raised_mm;
  // Without an upper end: the part of it at the height of the box is what may meet it.
  if (bottom_mm >= box.max_mm.z()) return false;
  const double z_mm = std::max(bottom_mm, box.min_mm.z());
  for (int ring = 0; ring <= 60; ++ring) {
    const double radius_mm = body.radius_mm * ring / 60;
    for (int i = 0; i < 180; ++i) {
      const double turn = 2 * std::numbers::pi * i / 180;
      if (box.Contains(Vec3(focus_mm.x() + radius_mm * std::cos(turn),
                            focus_mm.y() + radius_mm * std::sin(turn), z_mm)))
        return true;
    }
  }
  return false;
}

/// How far the body has to be raised at this place, by steps of 0.01 mm.
double RaisedFree(const BeamBody& body, const Box3& box, const Vec3& focus_mm) {
  if (!Overlaps(body, box, focus_mm, 0)) return 0;
  double low_mm = 0, high_mm = 1000;
  while (high_mm - low_mm > 0.01) {
    const double middle_mm = (low_mm + high_mm) / 2;
    (Overlaps(body, box, focus_mm, middle_mm) ? low_mm : high_mm) = middle_mm;
  }
  return high_mm;
}

// The lens f43 of the published engraver over a block of 100 mm: the published case.
TEST(Clearance, ALensGoesIntoTheBlockByTheWayOfItsFocusInAirLessItsDistance) {
  const double ratio = optics::StagePerGlassRatio(1.51947, 2.5 / 43);
  const optics::MachineFromGlass frame{Vec3::Zero(), Vec3(50, 50, 100), ratio};
  const Clearance clearance({{43}}, {{Vec3::Zero(), Vec3(50, 50, 100)}});
  const auto deep = clearance.At(frame.ToMachine(Vec3(25, 25, 5)));
  ASSERT_TRUE(deep);
  // 95 mm of glass are 62.5 mm of air.
  EXPECT_NEAR(deep->overlap_mm, 19.5, 0.05);
  EXPECT_FALSE(clearance.At(frame.ToMachine(Vec3(25, 25, 100 - 43 / ratio + 1e-3))));
  EXPECT_TRUE(clearance.At(frame.ToMachine(Vec3(25, 25, 100 - 43 / ratio - 1e-3))));
}

// Where the lens has to be is found by rays alone: a marginal ray leaves the lens's edge,
// bends at the face by Snell's law and meets the axis at the depth wanted. The height of
// the lens over the face for that is searched, and the lens is in the glass when it is
// below 0.
TEST(Clearance, AgreesWithARayThatLeavesTheLens) {
  constexpr double kFocalMm = 43, kHeightMm = 120;
  for (const double index : {1.0, 1.46, 1.52, 1.9}) {
    for (const double aperture : {0.058, 0.2, 0.4}) {
      const double angle = std::asin(aperture), inside = std::asin(aperture / index);
      const double edge_mm = kFocalMm * std::tan(angle);
      const auto depth_at = [&](double lens_above_face_mm) {
        // Negative heights: the face as if the lens could pass through it.
        return (edge_mm - lens_above_face_mm * std::tan(angle)) / std::tan(inside);
      };
      const Clearance clearance({{kFocalMm}}, {{Vec3::Zero(), Vec3(50, 50, kHeightMm)}});
      const optics::MachineFromGlass frame{Vec3::Zero(), Vec3(50, 50, kHeightMm),
                                           optics::StagePerGlassRatio(index, aperture)};
      for (double depth_mm = 1; depth_mm < 119; depth_mm += 1.7) {
        double low_mm = -200, high_mm = 200;
        for (int i = 0; i < 80; ++i) {
          const double middle_mm = (low_mm + high_mm) / 2;
          (depth_at(middle_mm) > depth_mm ? low_mm : high_mm) = middle_mm;
        }
        const auto found =
            clearance.At(frame.ToMachine(Vec3(20, 20, kHeightMm - depth_mm)));
        ASSERT_EQ(found.has_value(), low_mm < -1e-5)
            << index << " " << aperture << " " << depth_mm;
        if (!found) continue;
        EXPECT_NEAR(found->overlap_mm, -low_mm, 1e-6);
      }
    }
  }
}

TEST(Clearance, IsThatOfSampledBodiesAtAPlace) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> side(-20, 20), up(-10, 60), size(1, 20);
  int met = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 low_mm(side(random), side(random), up(random));
    const Box3 box{low_mm, low_mm + Vec3(size(random), size(random), size(random))};
    const BeamBody body{size(random), size(random)};
    const Vec3 focus_mm(side(random), side(random), up(random));
    const double wanted_mm = RaisedFree(body, box, focus_mm);
    const auto found = Clearance({body}, {box}).At(focus_mm);
    // A sampled disc is smaller than the true one by up to a sixtieth of its radius.
    BeamBody wider = body;
    wider.radius_mm *= 1.04;
    if (!found) {
      EXPECT_EQ(wanted_mm, 0) << i;
      continue;
    }
    ++met;
    EXPECT_NEAR(found->overlap_mm, RaisedFree(wider, box, focus_mm), 0.02) << i;
  }
  EXPECT_GT(met, 40);
}

TEST(Clearance, OfAWayIsTheWorstOfItsPlaces) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> side(-40, 40), up(-10, 40), size(1, 20);
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 low_mm(side(random), side(random), up(random));
    const Clearance clearance(
        {{size(random), size(random)}, {10 + size(random), 10 + size(random)}},
        {{low_mm, low_mm + Vec3(size(random), size(random), size(random))},
         {low_mm + Vec3(15, 0, 0), low_mm + Vec3(25, 5, 9)}});
    const Vec3 from_mm(side(random), side(random), up(random));
    const Vec3 to_mm(side(random), side(random), up(random));
    double worst_mm = 0;
    for (int k = 0; k <= 1500; ++k) {
      const auto at = clearance.At(from_mm + k / 1500.0 * (to_mm - from_mm));
      if (at) worst_mm = std::max(worst_mm, at->overlap_mm);
    }
    const auto found = clearance.Along(from_mm, to_mm);
    const double found_mm = found ? found->overlap_mm : 0;
    // A step of the way goes up to 0.035 mm down.
    EXPECT_GE(found_mm, worst_mm - 1e-9) << i;
    EXPECT_NEAR(found_mm, worst_mm, 0.04) << i;
    if (!found) continue;
    ++met;
    // Where it says, within rounding at the edge of the body.
    EXPECT_NEAR((found->focus_mm - from_mm).cross(to_mm - from_mm).norm(), 0, 1e-6);
  }
  EXPECT_GT(met, 60);
}

TEST(Clearance, OfAnUnknownWidthOrAnEndlessTableRegardsTheHeightAlone) {
  const Box3 clamp{Vec3(1000, 1000, 0), Vec3(1010, 1010, 40)};
  EXPECT_TRUE(Clearance({{30}}, {clamp}).At(Vec3(0, 0, 5)));
  EXPECT_FALSE(Clearance({{30}}, {clamp}).At(Vec3(0, 0, 10)));
  const Box3 table{Vec3::Constant(-kInfinite), Vec3(kInfinite, kInfinite, 0)};
  const Clearance on_table({{30, 5}}, {table});
  EXPECT_FALSE(on_table.Along(Vec3(-9, 3, -30), Vec3(80, 7, -29)));
  const auto below = on_table.Along(Vec3(-9, 3, -29), Vec3(80, 7, -31));
  ASSERT_TRUE(below);
  EXPECT_NEAR(below->overlap_mm, 1, 1e-9);
  EXPECT_EQ(below->focus_mm, Vec3(80, 7, -31));
}

TEST(Clearance, NamesTheBodyAndTheSolidThatMeetDeepest) {
  const Clearance clearance({{40, 5}, {60, 50}}, {{Vec3::Zero(), Vec3(50, 50, 50)},
                                                  {Vec3(70, 0, 0), Vec3(80, 50, 90)}});
  // The lens is free of the block at the height 10; the head reaches the clamp.
  const auto clash = clearance.At(Vec3(45, 25, 10));
  ASSERT_TRUE(clash);
  EXPECT_EQ(clash->body, 1u);
  EXPECT_EQ(clash->solid, 1u);
  EXPECT_NEAR(clash->overlap_mm, 20, 1e-9);
  EXPECT_FALSE(clearance.At(Vec3(15, 25, 10)));
  EXPECT_FALSE(Clearance().At(Vec3::Zero()));
}

TEST(Clearance, RefusesWhatIsNoBodyAndNoSolid) {
  EXPECT_ANY_THROW(Clearance({{std::nan(""), 5}}, {}));
  EXPECT_ANY_THROW(Clearance({{30, -1}}, {}));
  EXPECT_ANY_THROW(Clearance({}, {Box3{}}));
}

}  // namespace
}  // namespace intaglio::machine
