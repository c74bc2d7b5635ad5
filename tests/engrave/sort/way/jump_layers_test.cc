#include "engrave/sort/jump_layers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "tests/engrave/sort/clouds.h"
#include "tests/engrave/sort/order_checks.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

using ::testing::HasSubstr;

constexpr double kIndex = 1.52, kStepMm = 0.066;

/// A telecentric lens, z in steps.
OrderOptions Telecentric() {
  OrderOptions options;
  options.method = Method::kJumpLayers;
  options.cone = {0.02, 0.02, 0.15};
  options.jump_layers.head_from_glass = [](const Vec3& p) {
    return Vec3(p.x(), p.y(), std::round(p.z() / kIndex / kStepMm) * kStepMm);
  };
  return options;
}

PointList HeadPlacesOf(const PointList& points_mm, const Order& order,
                       const OrderOptions& options) {
  PointList places_mm;
  for (const std::uint32_t i : order)
    places_mm.push_back(options.jump_layers.head_from_glass(points_mm[i]));
  return places_mm;
}

TEST(JumpLayers, MovesZOnceForEachLayerFromTheDeepestUp) {
  for (const auto& [name, points_mm] : Clouds(3000)) {
    const OrderOptions options = Telecentric();
    const Order order = MakeOrder(points_mm, options).value();
    ExpectEachOnce(order, points_mm.size());
    const PointList places_mm = HeadPlacesOf(points_mm, order, options);
    std::set<double> layers;
    for (std::size_t i = 0; i < places_mm.size(); ++i) {
      layers.insert(places_mm[i].z());
      if (i == 0) continue;
      ASSERT_GE(places_mm[i].z(), places_mm[i - 1].z()) << name;
    }
    EXPECT_EQ(TimeOfJumps(places_mm, {}).z_move_count, layers.size() - 1) << name;
  }
}

TEST(JumpLayers, FiresThroughNothing) {
  for (const auto& [name, points_mm] : Clouds(2000)) {
    const OrderOptions options = Telecentric();
    ExpectNoneShaded(points_mm, MakeOrder(points_mm, options).value(), options.cone);
  }
}

// Each beam leans: the pupil is 140 mm above the field, the block's face 60 mm above its
// bottom. By brute force, with the cone of each point about its own axis.
TEST(JumpLayers, FiresThroughNothingWhereBeamsLean) {
  constexpr double kPupilMm = 140, kHeightMm = 60, kTangent = 0.02;
  const auto slopes = [&](const Vec3& p) -> Vec2 {  // in the glass, downward
    const Vec2 in_air = p.head<2>() / kPupilMm;
    const double sine = in_air.norm() / std::hypot(1, in_air.norm()) / kIndex;
    return in_air.norm() > 0
               ? Vec2(in_air.normalized() * sine / std::sqrt(1 - sine * sine))
               : Vec2(0, 0);
  };
  OrderOptions options = Telecentric();
  options.cone = {kTangent, 0.02, 0.15};
  options.cone.lean = BeamLean{{kPupilMm, kPupilMm}, {0, 0}, kHeightMm, kIndex, 36};
  // Coddington's middle focus: deeper beside the axis at the same height.
  options.jump_layers.head_from_glass = [](const Vec3& p) {
    const double q =
        p.head<2>().squaredNorm() / (kPupilMm * kPupilMm) * (1 - 1 / (kIndex * kIndex));
    const double below_mm =
        (kHeightMm - p.z()) / (kIndex * std::sqrt(1 + q) * (1 + q / 2));
    return Vec3(p.x(), p.y(), -std::round(below_mm / kStepMm) * kStepMm);
  };
  PointList points_mm = RandomBox(6000, {50, 50, 5}, 4);
  for (Vec3& p : points_mm) p -= Vec3(25, 25, 0);
  // Some in the beams of others, so that a layer has what it has to keep apart.
  for (std::size_t i = 0; i + 1 < points_mm.size(); i += 4) {
    const Vec2 in_mm = 0.06 * slopes(points_mm[i]);
    points_mm[i + 1] = points_mm[i] + Vec3(-in_mm.x(), -in_mm.y(), 0.06);
  }
  const Order order = MakeOrder(points_mm, options).value();
  std::size_t shaded = 0, in_other_order = 0;
  const auto shades = [&](const Vec3& earlier, const Vec3& p) {
    const double up_mm = earlier.z() - p.z();
    if (up_mm <= 0 || up_mm > 6) return false;
    const Vec2 axis_mm = p.head<2>() - up_mm * slopes(p);  // it leans inward, upward
    return (earlier.head<2>() - axis_mm).norm() < kTangent * up_mm;
  };
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 &a = points_mm[order[j]], &b = points_mm[order[i]];
      shaded += shades(a, b);
      in_other_order += shades(b, a);
    }
  }
  EXPECT_EQ(shaded, 0);
  EXPECT_GT(in_other_order, 1000);  // a pair can be made in the wrong order
}

/// Rings of energy around the lens, as an oblique beam needs them.
std::uint32_t RingOf(const Vec3& p) {
  return static_cast<std::uint32_t>(p.head<2>().squaredNorm() / 60);
}

/// By an order in which each point is made once, and none through an earlier crack.
JumpTime TimeBy(const PointList& points_mm, const OrderOptions& options) {
  const Order order = MakeOrder(points_mm, options).value();
  ExpectEachOnce(order, points_mm.size());
  ExpectNoneShaded(points_mm, order, options.cone);
  std::vector<std::uint32_t> energies;
  for (const std::uint32_t i : order) energies.push_back(RingOf(points_mm[i]));
  JumpTimes times;
  times.max_list_points = 32;
  return TimeOfJumps(HeadPlacesOf(points_mm, order, options), times, energies);
}

// Ten thousand points in thirty layers, twenty energies: with 5 ms for each list more, an
// energy after the other is far quicker, though its jumps are longer.
TEST(JumpLayers, GathersThePointsOfAnEnergy) {
  PointList points_mm = RandomBox(10'000, {50, 50, 3}, 7);
  for (Vec3& p : points_mm) p -= Vec3(25, 25, 0);
  OrderOptions options = Telecentric();
  options.cone = {0.2, 0.02, 0.15};  // steep enough to keep points of a layer apart
  const JumpTime before = TimeBy(points_mm, options);
  options.jump_layers.energy_from_glass = RingOf;
  const JumpTime after = TimeBy(points_mm, options);
  EXPECT_LT(after.energy_change_count, before.energy_change_count / 3);
  EXPECT_LT(after.jump_s, 3 * before.jump_s);
  const auto seconds = [](const JumpTime& time) {
    return time.jump_s + 0.005 * static_cast<double>(time.list_count);
  };
  EXPECT_LT(seconds(after), 0.7 * seconds(before));
}

// A list that costs nothing is no reason for a longer way.
TEST(JumpLayers, GathersNothingWhereAListTakesNoTime) {
  PointList points_mm = RandomBox(2000, {50, 50, 1}, 8);
  for (Vec3& p : points_mm) p -= Vec3(25, 25, 0);
  OrderOptions options = Telecentric();
  const double alone_s = TimeBy(points_mm, options).jump_s;
  options.jump_layers.energy_from_glass = RingOf;
  options.jump_layers.change_s = 0;
  EXPECT_LE(TimeBy(points_mm, options).jump_s, alone_s * (1 + 1e-12));
}

// A list has one height, one energy, and no more points than it may have.
TEST(JumpLayers, CountsListsAndChangesOfEnergy) {
  JumpTimes times;
  times.max_list_points = 2;
  const PointList places_mm = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0},
                               {3, 0, 0}, {4, 0, 1}, {5, 0, 1}};
  const std::vector<std::uint32_t> energies = {0, 0, 0, 1, 0, 0};
  const JumpTime time = TimeOfJumps(places_mm, times, energies);
  EXPECT_EQ(time.list_count, 4) << "two, one, one of another energy, two higher up";
  EXPECT_EQ(time.energy_change_count, 1) << "with z the list ends anyway";
  times.max_list_points = 0;
  EXPECT_EQ(TimeOfJumps(places_mm, times).list_count, 2);
}

TEST(JumpLayers, CountsEachPartOfTheTime) {
  const JumpTimes times{2000, 0.0002, 0.0005, 10, 1000, 0.1};
  // Jumps of 3, 4 and 2 mm; z goes 0.04 mm, which it does not do at full speed, then 1
  // mm.
  const PointList places_mm = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0.04}, {3, 6, 1.04}};
  const JumpTime time = TimeOfJumps(places_mm, times);
  EXPECT_DOUBLE_EQ(time.jump_s, 9.0 / 2000);
  EXPECT_DOUBLE_EQ(time.delay_s, 4 * 0.0002);
  EXPECT_DOUBLE_EQ(time.dwell_s, 4 * 0.0005);
  EXPECT_EQ(time.z_move_count, 2);
  EXPECT_NEAR(time.z_s, 2 * std::sqrt(0.04 / 1000) + 0.1 + 0.1 + 0.01 + 0.1, 1e-12);
  EXPECT_DOUBLE_EQ(time.total_s(), time.jump_s + time.delay_s + time.dwell_s + time.z_s);
  EXPECT_EQ(time.pause_s, 0);
}

TEST(JumpLayers, CountsThePausesBetweenItsPoints) {
  JumpTimes times;
  times.pause_after_points = 3;
  times.pause_s = 0.5;
  const auto pause_s = [&times](std::size_t count) {
    return TimeOfJumps(PointList(count, Vec3::Zero()), times).pause_s;
  };
  EXPECT_EQ(pause_s(0), 0);
  EXPECT_EQ(pause_s(3), 0) << "none behind the last";
  EXPECT_EQ(pause_s(4), 0.5);
  EXPECT_EQ(pause_s(7), 1);
}

TEST(JumpLayers, IsRefusedForAnotherMachine) {
  OrderOptions options;
  options.method = Method::kJumpLayers;
  const auto order = MakeOrder(RandomBox(10, {1, 1, 1}, 1), options);
  ASSERT_FALSE(order.has_value());
  EXPECT_THAT(order.error().message, HasSubstr("head_over_block.jump_and_dwell"));
}

}  // namespace
}  // namespace intaglio::sort
