// Beams that lean, against rays that are refracted here by Snell's law in vectors, and
// orders under them against every pair.

#include "engrave/sort/beam/beam_lean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engrave/core/check.h"
#include "engrave/sort/beam/beam_cone.h"
#include "engrave/sort/beam/precedence.h"
#include "engrave/sort/cone_order.h"
#include "tests/engrave/sort/order_checks.h"

namespace intaglio::sort::beam_lean_test {
namespace {

constexpr double kIndex = 1.519473, kTopMm = 70;

BeamLean LensA() {
  BeamLean lean;
  lean.pupil_mm = {140, 135};
  lean.axis_mm = {30, 31};
  lean.top_mm = kTopMm;
  lean.refractive_index = kIndex;
  lean.widest_mm = 60;
  return lean;
}

/// The ray of a command into the glass: the way down of its unit vector, by Snell's law.
Vec3 InGlass(const Vec2& field_mm, const BeamLean& lean) {
  Vec3 down(field_mm.x() / lean.pupil_mm.x(), field_mm.y() / lean.pupil_mm.y(), 1);
  down.normalize();
  const Vec2 across = down.head<2>() / lean.refractive_index;
  return {across.x(), across.y(), std::sqrt(1 - across.squaredNorm())};
}

// The place of a command at some depth lies on its ray; on the way up the axis of the
// cone is that ray. The command is found again from the place alone.
TEST(BeamLean, IsTheRayOfThePlace) {
  const BeamLean lean = LensA();
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vec2 field_mm(35 * unit(random), 35 * unit(random));
    const double below_mm = 30 + 29 * unit(random);
    // Where two rays beside each other meet in the plane of incidence, and across it: the
    // focus lies in the middle (the reference's closed forms are not used).
    const Vec2 face_mm = field_mm - below_mm * field_mm.cwiseQuotient(lean.pupil_mm);
    const Vec3 ray = InGlass(field_mm, lean);
    // A pencil towards the focus in air: depths of both foci from its neighbours.
    const auto depth_of = [&](const Vec2& aside) {
      Vec3 near(field_mm.x() / lean.pupil_mm.x() + aside.x(),
                field_mm.y() / lean.pupil_mm.y() + aside.y(), 1);
      const Vec2 near_face_mm = field_mm - below_mm * near.head<2>();
      near.normalize();
      const Vec2 across = near.head<2>() / kIndex;
      const Vec3 in_glass(across.x(), across.y(), std::sqrt(1 - across.squaredNorm()));
      const Vec2 start_mm = near_face_mm - face_mm;
      const Vec2 slope = in_glass.head<2>() / in_glass.z() - ray.head<2>() / ray.z();
      return -start_mm.dot(aside) / slope.dot(aside);
    };
    const Vec2 radial = field_mm.cwiseQuotient(lean.pupil_mm);
    if (radial.norm() < 1e-3) continue;
    const Vec2 along = 1e-6 * radial.normalized(), beside(-along.y(), along.x());
    const double depth_mm = 0.5 * (depth_of(along) + depth_of(beside));
    const Vec2 place_mm = face_mm + depth_mm * ray.head<2>() / ray.z();
    const Vec2 upward =
        lean.UpwardAt({place_mm.x() + 30, place_mm.y() + 31, kTopMm - depth_mm});
    // As the header has it, to 20 degrees and 59 mm in air.
    EXPECT_NEAR(upward.x(), -ray.x() / ray.z(), 1e-6);
    EXPECT_NEAR(upward.y(), -ray.y() / ray.z(), 1e-6);
    EXPECT_LE(upward.norm(), lean.Steepest());
  }
}

TEST(BeamLean, IsThatInAirAboveTheFaceAndNoneOfATelecentricLens) {
  BeamLean lean = LensA();
  const Vec2 upward = lean.UpwardAt({44, 31, kTopMm + 1});
  EXPECT_NEAR(upward.x(), -0.1, 1e-15);
  EXPECT_EQ(upward.y(), 0);
  lean.pupil_mm = Vec2::Constant(INFINITY);
  EXPECT_TRUE(lean.UpwardAt({50, 10, 5}).isZero(0));
  EXPECT_EQ(lean.Steepest(), 0);
}

// The same place in a frame whose heights are those in air.
TEST(BeamLean, CountsHeightsOfAnotherFrame) {
  const BeamLean glass = LensA();
  BeamLean air = glass;
  air.depth_ratio = kIndex;
  const Vec3 place_mm(50, 40, 20);
  const Vec3 in_air(50, 40, kTopMm - (kTopMm - 20) / kIndex);
  EXPECT_TRUE(air.UpwardAt(in_air).isApprox(kIndex * glass.UpwardAt(place_mm), 1e-12));
}

BeamCone Leaning(double radius_mm = 0) {
  BeamCone cone(0.02, radius_mm, 0.15);
  cone.lean = LensA();
  return cone;
}

/// Columns along leaning beams and upright ones, so that each lean has its pairs.
PointList Columns(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const BeamLean lean = LensA();
  PointList points_mm;
  while (points_mm.size() < count) {
    const Vec3 foot(60 * unit(random), 60 * unit(random), 5);
    const Vec2 upward = unit(random) < 0.8 ? lean.UpwardAt(foot) : Vec2(0, 0);
    for (int i = 0; i < 6; ++i) {
      const double up_mm = 60 * unit(random);
      points_mm.emplace_back(foot.x() + upward.x() * up_mm, foot.y() + upward.y() * up_mm,
                             foot.z() + up_mm);
    }
  }
  return points_mm;
}

TEST(LeaningCone, TheCountOfAnyOrderIsThatOfAllPairs) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    PointList made_mm = Columns(400, seed);
    for (const BeamCone& cone : {Leaning(), Leaning(0.035), Leaning(0.5)}) {
      const auto all_pairs = CountShadowViolationsBruteForce(made_mm, cone);
      EXPECT_EQ(CountShadowViolations(made_mm, cone), all_pairs) << seed;
      EXPECT_GT(all_pairs, 0u);
      BeamCone upright = cone;
      upright.lean.reset();
      EXPECT_LT(CountShadowViolations(made_mm, upright), all_pairs)
          << "the lean makes no difference";
    }
  }
}

TEST(LeaningCone, DeepestFirstIsAlwaysRight) {
  PointList made_mm = Columns(900, 3);
  std::sort(made_mm.begin(), made_mm.end(),
            [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  EXPECT_EQ(CountShadowViolationsBruteForce(made_mm, Leaning(0.035)), 0u);
}

// From the top down every order has to be changed.
TEST(LeaningCone, AnyOrderCanBeMadeToObeyIt) {
  PointList points_mm = Columns(600, 4);
  std::sort(points_mm.begin(), points_mm.end(),
            [](const Vec3& a, const Vec3& b) { return a.z() > b.z(); });
  Order order(points_mm.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  for (const BeamCone& cone : {Leaning(), Leaning(0.035)}) {
    EXPECT_GT(CountShadowViolationsBruteForce(points_mm, cone), 0u);
    const Order kept = KeepToCone(points_mm, order, cone);
    ExpectEachOnce(kept, points_mm.size());
    ExpectNoneShaded(points_mm, kept, cone);
  }
}

TEST(LeaningCone, EveryMethodButThePublishedObeysIt) {
  const PointList points_mm = Columns(300, 5);
  for (const Method method : {Method::kKdz, Method::kLayers, Method::kSmooth,
                              Method::kAnneal, Method::kBoustrophedon, Method::kSweep}) {
    OrderOptions options;
    options.method = method;
    options.cone = Leaning(0.035);
    options.sweep.slab_mm = options.layers.layer_thickness_mm = 2;
    const Order order = MakeOrder(points_mm, options).value();
    ExpectEachOnce(order, points_mm.size());
    ExpectNoneShaded(points_mm, order, options.cone);
  }
}

// At one height of the lens the focus is the deeper the more its beam leans: a slab of
// the sweep bends down by millimetres towards the corners of the field.
TEST(LeaningCone, SlabsOfASweepAreOfEqualHeightsOfTheLens) {
  const BeamLean lean = LensA();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  PointList points_mm;
  std::vector<double> below_mm;
  for (int i = 0; i < 1000; ++i) {
    const Vec2 field_mm(25 * unit(random), 25 * unit(random));
    below_mm.push_back(36 + 0.5 * std::floor(6 * unit(random)));
    const double q =
        field_mm.cwiseQuotient(lean.pupil_mm).squaredNorm() * (1 - 1 / (kIndex * kIndex));
    const double depth_mm = kIndex * below_mm.back() * std::sqrt(1 + q) * (1 + 0.5 * q);
    const Vec2 aside_mm =
        0.5 * q * below_mm.back() * field_mm.cwiseQuotient(lean.pupil_mm);
    points_mm.emplace_back(30 + field_mm.x() + aside_mm.x(),
                           31 + field_mm.y() + aside_mm.y(), kTopMm - depth_mm);
  }
  OrderOptions options;
  options.method = Method::kSweep;
  options.cone = Leaning();
  // Less than the distance of the heights, in depths of the glass.
  options.sweep.slab_mm = 0.35 * kIndex;
  const Order order = MakeOrder(points_mm, options).value();
  ExpectNoneShaded(points_mm, order, options.cone);
  for (std::size_t i = 1; i < order.size(); ++i) {
    ASSERT_LE(below_mm[order[i]], below_mm[order[i - 1]]) << i;
  }
}

TEST(LeaningCone, PairsOfPrecedenceAreThoseOfTheCone) {
  const PointList points_mm = Columns(200, 6);
  const BeamCone cone = Leaning(0.035);
  const Precedence precedence(points_mm, cone);
  for (std::uint32_t p = 0; p < points_mm.size(); ++p) {
    // Whether above is reached from p by kept pairs.
    std::vector<bool> reached(points_mm.size(), false);
    std::vector<std::uint32_t> open{p};
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      for (const std::uint32_t above : precedence.After(at)) {
        EXPECT_TRUE(cone.Shades(points_mm[at], points_mm[above]));
        if (!reached[above]) open.push_back(above);
        reached[above] = true;
      }
    }
    for (std::uint32_t above = 0; above < points_mm.size(); ++above) {
      const Vec3 up = points_mm[above] - points_mm[p];
      const Vec2 axis_mm = up.z() * cone.LeanAt(points_mm[p]);
      if (cone.Shades((up.head<2>() - axis_mm).norm(), up.z())) {
        EXPECT_TRUE(reached[above]) << p << ", " << above;
      }
    }
  }
}

TEST(LeaningCone, RefusesALensWithoutADistance) {
  BeamCone cone = Leaning();
  cone.lean->pupil_mm.x() = 0;
  EXPECT_THROW(RequireUsable(cone), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort::beam_lean_test
