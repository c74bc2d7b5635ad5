#include "engrave/machine/arm_length.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace intaglio::machine {
namespace {

using std::numbers::pi;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

const Box3 kAnyTravel{Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)};

Box3 BoxAt(double x_mm, double y_mm, double width_mm, double depth_mm) {
  return {Vec3(x_mm, y_mm, 0), Vec3(x_mm + width_mm, y_mm + depth_mm, 0)};
}

// Fig. 60: without a margin the shortest arm ends at the nearest edge of the piece, or it
// would not reach the farthest corner.
TEST(ArmLength, OfThePublishedPieceEndsAtItsNearestEdgeOrItsFarthestCorner) {
  PolarOptions options;
  options.axis_distance_mm = 200;
  options.singular_margin_rad = 0.01;
  // Table 6: a = 50, y2 = 70; the nearest edge is 70 mm from the table's axis, 130 mm
  // from the arm's, and the farthest corner 122.6 mm from the table's.
  const auto piece = ArmLengthsOver(options, BoxAt(-25, 70, 50, 50), kAnyTravel);
  ASSERT_TRUE(piece.has_value());
  EXPECT_NEAR(piece->min_mm, 130, 0.1);
  EXPECT_NEAR(piece->max_mm, 270, 0.1);
  // Beyond the arm's axis: its distance to the farthest corner decides.
  const auto far = ArmLengthsOver(options, BoxAt(-50, 250, 100, 100), kAnyTravel);
  ASSERT_TRUE(far.has_value());
  EXPECT_NEAR(far->min_mm, std::hypot(50, 350) - 200, 0.1);
  // Fig. 59: the table's axis is inside the piece, where only an arm as long as the
  // distance of both axes comes, folded, and the margin refuses that.
  EXPECT_FALSE(ArmLengthsOver(options, BoxAt(-25, -25, 50, 50), kAnyTravel).has_value());
}

/// Whether an arm brings the beam to places all over the edge of a box, by the crossing
/// of its circle with that of each place, found on the line between both axes.
bool Reaches(const PolarOptions& options, double r1_mm, const Box3& box,
             const Box3& travel) {
  constexpr int kPerEdge = 64;
  const double d_mm = options.axis_distance_mm;
  const double sign = options.side == ArmSide::kLeft ? -1 : 1;
  const Vec3 size_mm = box.max_mm - box.min_mm;
  std::vector<Vec2> edge;
  for (int i = 0; i < 4 * kPerEdge; ++i) {
    const double s = static_cast<double>(i % kPerEdge) / kPerEdge;
    const Vec2 shares[] = {{s, 0}, {1, s}, {1 - s, 1}, {0, 1 - s}};
    edge.push_back(box.min_mm.head<2>() +
                   shares[i / kPerEdge].cwiseProduct(size_mm.head<2>()));
  }
  double before = 0, min_turn = kInfinity, max_turn = -kInfinity;
  for (const Vec2& place : edge) {
    const double r_mm = place.norm();
    // The beam from the table's axis: `along` the line to the arm's axis, and aside.
    const double along = (r_mm * r_mm - r1_mm * r1_mm + d_mm * d_mm) / (2 * d_mm);
    const double square = r_mm * r_mm - along * along;
    if (!(square > 0)) return false;
    // At table angle 0 the arm's axis is at +y; on the left the beam is at -x.
    const Vec2 beam(sign * std::sqrt(square), along);
    // From the direction to the table's axis, counterclockwise.
    double arm = std::atan2(beam.x(), d_mm - beam.y());
    arm += 2 * pi * std::round((travel.center_mm().x() - arm) / (2 * pi));
    if (std::abs(std::sin(arm)) < std::sin(options.singular_margin_rad)) return false;
    if (arm < travel.min_mm.x() || arm > travel.max_mm.x()) return false;
    double turn = std::atan2(beam.y(), beam.x()) - std::atan2(place.y(), place.x()) -
                  options.frame_turn_rad;
    const bool is_first = min_turn > max_turn;
    const double near = is_first ? travel.center_mm().y() : before;
    turn += 2 * pi * std::round((near - turn) / (2 * pi));
    min_turn = std::min(min_turn, turn);
    max_turn = std::max(max_turn, turn);
    before = turn;
  }
  return min_turn >= travel.min_mm.y() && max_turn <= travel.max_mm.y();
}

// With each of many arms, the edges are reached where the result says it, and with no
// shorter one.
TEST(ArmLength, OfRandomBlocksAgreesWithATrialOfManyArms) {
  std::mt19937 random(7);
  const auto between = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  int reached = 0, refused = 0, cut_by_table = 0;
  for (int trial = 0; trial < 90; ++trial) {
    PolarOptions options;
    options.axis_distance_mm = between(100, 300);
    options.side = trial % 2 == 0 ? ArmSide::kLeft : ArmSide::kRight;
    options.singular_margin_rad = between(0.05, 0.3);
    options.frame_turn_rad = trial % 3 == 0 ? between(-3, 3) : 0;
    const Box3 box =
        BoxAt(between(-150, 100), between(10, 200), between(10, 120), between(10, 120));
    const double middle = options.side == ArmSide::kLeft ? 1.5 * pi : 0.5 * pi;
    const double half_arm = between(0.9, 1.6), half_table = between(0.8, 3);
    const double table = between(-1.5, 1.5);
    const Box3 travel{Vec3(middle - half_arm, table - half_table, -1),
                      Vec3(middle + half_arm, table + half_table, 1)};
    const auto found = ArmLengthsOver(options, box, travel);
    (found ? reached : refused) += 1;
    const auto without = ArmLengthsOver(
        options, box, {Vec3(travel.min_mm.x(), -20, -1), Vec3(travel.max_mm.x(), 20, 1)});
    if (found && without && found->max_mm < without->max_mm - 1) ++cut_by_table;
    for (double r1_mm = 2; r1_mm < 900; r1_mm += 3) {
      // Points of the edge are some millimetres apart, those of AxesOver less.
      if (found &&
          (std::abs(r1_mm - found->min_mm) < 2 || std::abs(r1_mm - found->max_mm) < 2))
        continue;
      const bool expected = found && r1_mm > found->min_mm && r1_mm < found->max_mm;
      // Beyond a range there may be another one: the table a turn on, or the arm's angle
      // passed twice.
      if (found && r1_mm > found->max_mm) break;
      ASSERT_EQ(Reaches(options, r1_mm, box, travel), expected)
          << "trial " << trial << ", " << r1_mm << " mm, found "
          << (found ? found->min_mm : 0) << " to " << (found ? found->max_mm : 0);
    }
    // Right beyond the longest there is none.
    if (!found) continue;
    EXPECT_FALSE(Reaches(options, found->max_mm + 2, box, travel)) << "trial " << trial;
  }
  EXPECT_GT(reached, 30);
  EXPECT_GT(refused, 15);
  EXPECT_GT(cut_by_table, 5);
}

}  // namespace
}  // namespace intaglio::machine
