// Marks of a distorted grid, turned, with gaps and dust, against the nodes they came
// from.

#include "engrave/galvo/grid_match.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "engrave/galvo/calibration_grid.h"
#include "tests/engrave/galvo/traced_head.h"

namespace intaglio::galvo {
namespace {

struct Scan {
  std::vector<Vec2> marks_mm;
  std::vector<std::pair<Vec2, Vec2>> nodes_mm;  // command, measured
};

Scan ScanOf(const WrongField& field, int nodes, double pitch_mm, double turn_deg,
            double missing_share, int dust) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> share(0, 1), place(-55, 55);
  const Eigen::Rotation2Dd turn(turn_deg / 57.29577951);
  Scan scan;
  const int half = nodes / 2;
  for (int j = -half; j <= half; ++j) {
    for (int i = -half; i <= half; ++i) {
      const Vec2 command_mm = pitch_mm * Vec2(i, j);
      const Vec2 at_mm = turn * field.Arrive(command_mm) + Vec2(300, 200);
      const bool inner = std::abs(i) < half && std::abs(j) < half && (i != 0 || j != 0);
      if (inner && share(random) < missing_share) continue;
      scan.marks_mm.push_back(at_mm);
      scan.nodes_mm.emplace_back(command_mm, at_mm);
    }
  }
  for (int k = 0; k < dust; ++k)
    scan.marks_mm.push_back(
        turn * (pitch_mm * Vec2(k - 2, k - 1) + Vec2(0.45, 0.5) * pitch_mm) +
        Vec2(300, 200));
  std::shuffle(scan.marks_mm.begin(), scan.marks_mm.end(), random);
  return scan;
}

TEST(GridMatch, FindsEachNodeOfADistortedAndTurnedGridAmongDustAndGaps) {
  const WrongField field(100, .03, 20);
  for (const double turn_deg : {-15., -2., 0., 8., 15.}) {
    const Scan scan = ScanOf(field, 17, 6, turn_deg, 0.05, 5);
    const auto match = MatchGrid(scan.marks_mm, 17, 6);
    ASSERT_TRUE(match.has_value()) << turn_deg << ": " << match.error().message;
    EXPECT_EQ(match->marks.size(), scan.nodes_mm.size());
    EXPECT_EQ(match->left_out_count, 5U);
    EXPECT_EQ(match->not_found_count, 17 * 17 - scan.nodes_mm.size());
    for (const GridMark& mark : match->marks) {
      const auto node = std::find_if(
          scan.nodes_mm.begin(), scan.nodes_mm.end(), [&](const auto& known) {
            return (known.first - mark.command_mm).norm() < 1e-9;
          });
      ASSERT_NE(node, scan.nodes_mm.end());
      // Gaps turn the grid a little: 1 mrad of 50 mm.
      EXPECT_LT((field.Arrive(mark.command_mm) - field.Arrive({0, 0}) - mark.measured_mm)
                    .norm(),
                0.05);
    }
  }
}

/// As a grid with its disc of direction lies on a scanner.
std::vector<Vec2> Laid(const WrongField& field, double turn_deg, bool mirrored,
                       bool centre = true) {
  const Eigen::Rotation2Dd turn(turn_deg / 57.29577951);
  std::vector<Vec2> marks_mm;
  std::vector<Vec2> commands_mm = CalibrationGrid(9, 12);
  commands_mm.push_back(DirectionDisc(12));
  for (const Vec2& command_mm : commands_mm) {
    if (!centre && command_mm.norm() == 0) continue;
    const Vec2 at_mm = field.Arrive(command_mm);
    marks_mm.emplace_back(turn * Vec2(mirrored ? -at_mm.x() : at_mm.x(), at_mm.y()));
  }
  return marks_mm;
}

TEST(GridMatch, TurnsAPieceBackByTheDiscOfDirection) {
  const WrongField field(100, .03, 20);
  for (int quarters = 0; quarters < 4; ++quarters) {
    for (const double askew_deg : {-12., 0., 12.}) {
      const auto match = MatchGrid(Laid(field, 90 * quarters + askew_deg, false), 9, 12);
      ASSERT_TRUE(match.has_value()) << match.error().message;
      ASSERT_TRUE(match->quarter_turns.has_value());
      EXPECT_EQ(*match->quarter_turns, quarters);
      EXPECT_EQ(match->left_out_count, 0U);
      for (const GridMark& mark : match->marks) {
        // Turned by least squares: a shear of the head turns it by some mrad.
        EXPECT_LT(
            (field.Arrive(mark.command_mm) - field.Arrive({0, 0}) - mark.measured_mm)
                .norm(),
            0.05)
            << quarters << " " << askew_deg << " " << mark.command_mm.transpose();
      }
    }
  }
}

TEST(GridMatch, RefusesAMirrorImage) {
  const WrongField field(100, .03, 20);
  for (const double turn_deg : {0., 90., 180., 270.}) {
    const auto match = MatchGrid(Laid(field, turn_deg, true), 9, 12);
    ASSERT_FALSE(match.has_value());
    EXPECT_TRUE(match.error().message.starts_with("the marks are a mirror image"));
  }
}

// The mark nearest to the middle is then the disc of direction, which has no neighbours.
TEST(GridMatch, DoesNotNeedTheMarkInTheMiddle) {
  const WrongField field(100, .03, 20);
  const auto match = MatchGrid(Laid(field, 180, false, false), 9, 12);
  ASSERT_TRUE(match.has_value()) << match.error().message;
  EXPECT_EQ(match->quarter_turns, 2);
  EXPECT_EQ(match->not_found_count, 1U);
}

TEST(GridMatch, RefusesAGridOfAnotherSize) {
  const Scan scan = ScanOf(WrongField(100, .03, 20), 9, 12, 0, 0, 0);
  EXPECT_EQ(MatchGrid(scan.marks_mm, 11, 12).error().message,
            "9 columns and 9 rows of marks are connected, 11 are expected; check nodes, "
            "pitch and the scale of the picture");
  EXPECT_FALSE(MatchGrid(scan.marks_mm, 9, 6).has_value());
  EXPECT_FALSE(MatchGrid(scan.marks_mm, 8, 12).has_value());
  EXPECT_FALSE(MatchGrid({}, 9, 12).has_value());
}

// A picture of noise: from some of its marks the same ones are reached again and again.
TEST(GridMatch, OfMarksInReachOfEachOtherEachIsOneNodeAtMost) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-3, 3);
  for (int i = 0; i < 200; ++i) {
    std::vector<Vec2> marks_mm(60);
    for (Vec2& mark : marks_mm) mark = Vec2(place(random), place(random));
    const auto match = MatchGrid(marks_mm, 5, 1);
    if (match) {
      EXPECT_EQ(
          match->marks.size() + match->left_out_count + (match->quarter_turns ? 1 : 0),
          marks_mm.size());
    }
  }
}

}  // namespace
}  // namespace intaglio::galvo
