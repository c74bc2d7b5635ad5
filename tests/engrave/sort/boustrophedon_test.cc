#include "engrave/sort/boustrophedon.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/engrave/sort/order_checks.h"

namespace intaglio::sort {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

OrderOptions Rows(double turn_rad) {
  OrderOptions options;
  options.method = Method::kBoustrophedon;
  options.boustrophedon = {0.4, 0.5, turn_rad};
  return options;
}

/// The lattice of solids in a cube, by its definition, shuffled.
PointList Lattice(double distance_mm, double side_mm) {
  PointList points_mm;
  const int n = static_cast<int>(2 * side_mm / distance_mm);
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = -n; i < n; ++i) {
        const int third = k % 3;
        const Vec3 p =
            distance_mm * Vec3(i + 0.5 * j + 0.5 * third,
                               std::sqrt(0.75) * j + third * 0.5 / std::numbers::sqrt3,
                               std::sqrt(2.0 / 3) * k);
        if (p.minCoeff() >= 0 && p.maxCoeff() <= side_mm) points_mm.push_back(p);
      }
    }
  }
  std::shuffle(points_mm.begin(), points_mm.end(), std::mt19937(1));
  return points_mm;
}

// Clouds without two points that are equally far along a row, which rounding would swap.
TEST(Boustrophedon, RowsThatAreTurnedAreRowsAlongXOfACloudTurnedBack) {
  const PointList clouds[] = {RandomBox(2000, {10, 12, 9}, 1),
                              RandomBox(2000, {60, 60, 0.5}, 3), DentedSphere(2000, 4)};
  for (const PointList& points_mm : clouds) {
    for (const double turn_rad : {-pi, -0.3, 0.01, pi / 3, pi / 2, 2.5}) {
      const Eigen::AngleAxisd back(-turn_rad, Vec3::UnitZ());
      PointList turned_mm;
      for (const Vec3& p : points_mm) turned_mm.push_back(back * p);
      EXPECT_EQ(MakeOrder(points_mm, Rows(turn_rad)).value(),
                MakeOrder(turned_mm, Rows(0)).value())
          << turn_rad;
    }
  }
}

// The lattice has rows along x, and as well 60 and 120 degrees from it: nearly all
// steps are the distance long, in that direction.
TEST(Boustrophedon, GoesToAndFroAlongTheRowsOfALattice) {
  constexpr double kDistanceMm = 0.3;
  const PointList points_mm = Lattice(kDistanceMm, 9);
  for (const double turn_rad : {0.0, pi / 3, 2 * pi / 3}) {
    OrderOptions options = Rows(turn_rad);
    options.boustrophedon.layer_thickness_mm = std::sqrt(2.0 / 3) * kDistanceMm;
    options.boustrophedon.row_width_mm = std::sqrt(0.75) * kDistanceMm;
    const PointList path_mm = InOrder(points_mm, MakeOrder(points_mm, options).value());
    const Vec3 step_mm = kDistanceMm * Vec3(std::cos(turn_rad), std::sin(turn_rad), 0);
    std::size_t along = 0, forward = 0;
    for (std::size_t i = 1; i < path_mm.size(); ++i) {
      const Vec3 move_mm = path_mm[i] - path_mm[i - 1];
      const bool there = (move_mm - step_mm).norm() < 1e-9;
      if (there || (move_mm + step_mm).norm() < 1e-9) ++along;
      if (there) ++forward;
    }
    // A row has 30 points, in the corners fewer.
    EXPECT_GT(along, 0.95 * static_cast<double>(path_mm.size())) << turn_rad;
    EXPECT_NEAR(static_cast<double>(forward), 0.5 * static_cast<double>(along),
                0.02 * static_cast<double>(along))
        << turn_rad;
  }
}

TEST(Boustrophedon, GoesThroughNoEarlierCrackWhereverTheCloudHasHoles) {
  PointList points_mm;
  for (const Vec3& p : Lattice(0.5, 8)) {
    const Vec2 from_hole_mm = p.head<2>() - Vec2(3, 4);
    if (from_hole_mm.norm() > 2 && std::abs(p.z() - 5) > 0.6) points_mm.push_back(p);
  }
  for (const double turn_rad : {0.0, pi / 3, -1.0}) {
    for (const double layer_mm : {0.4, 1.3}) {
      OrderOptions options = Rows(turn_rad);
      options.boustrophedon.layer_thickness_mm = layer_mm;
      options.cone = {0.4, 0.1, 0.2};
      const Order order = MakeOrder(points_mm, options).value();
      ExpectEachOnce(order, points_mm.size());
      ExpectNoneShaded(points_mm, order, options.cone);
    }
  }
}

TEST(Boustrophedon, RefusesADirectionBeyondHalfATurn) {
  for (const double turn_rad : {-3.15, 3.15, std::nan("")}) {
    const auto order = MakeOrder(RandomBox(10, {1, 1, 1}, 1), Rows(turn_rad));
    ASSERT_FALSE(order.has_value());
    EXPECT_EQ(order.error().code, ErrorCode::kInvalidValue);
    EXPECT_THAT(order.error().message, HasSubstr("boustrophedon.row_turn_rad"));
    EXPECT_THAT(order.error().message, HasSubstr("-pi..pi"));
  }
}

}  // namespace
}  // namespace intaglio::sort
