#include "services/virtual_engraver/stations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "engrave/machine/kinematics.h"
#include "services/virtual_engraver/positioner.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr double kNoMm = 1e-9;

// In air, so that the focus is where the beam's axis and its height say.
BlockInMachine InAir() { return {Vec3(-25, 90, 0), Vec3(50, 50, 30), 1, 0}; }

TEST(Stations, TheBeamIsInTheBlockThatItMeets) {
  const std::vector<StationInMachine> further = {{Vec3(60, 0, 0)}, {Vec3(0, 70, -5)}};
  const Vec3 in_block(10, 20, 12);
  const Vec3 corner = InAir().origin_mm;
  for (int station = 1; station <= 3; ++station) {
    const Vec3 offset = station == 1
                            ? Vec3(Vec3::Zero())
                            : further[static_cast<std::size_t>(station) - 2].offset_mm;
    const auto found = TraceFocus(corner + offset + in_block, InAir(), further);
    EXPECT_EQ(found.station, station);
    EXPECT_TRUE(found.focus.in_glass);
    EXPECT_LT((found.focus.position_mm - in_block).norm(), kNoMm);
  }
}

TEST(Stations, BesideAllBlocksItIsBesideTheNearest) {
  const std::vector<StationInMachine> further = {{Vec3(60, 0, 0)}};
  const auto left = TraceFocus(Vec3(26, 100, 5), InAir(), further);
  EXPECT_EQ(left.station, 1);
  EXPECT_FALSE(left.focus.in_glass);
  EXPECT_EQ(TraceFocus(Vec3(34, 100, 5), InAir(), further).station, 2);
}

// The services' kinematics turns the frame of the places, the engraver its blocks.
TEST(Stations, OfATurntableAgreeWithTheKinematics) {
  PositionerOptions positioner;
  positioner.has_arm = true;
  positioner.pivot_distance_mm = 200;
  positioner.arm_length_mm = 150;
  std::vector<StationInMachine> further;
  for (int i = 1; i < 4; ++i) further.push_back({Vec3::Zero(), i * std::numbers::pi / 2});
  for (int station = 1; station <= 4; ++station) {
    machine::PolarOptions options;
    options.frame_turn_rad = (station - 1) * std::numbers::pi / 2;
    const auto kinematics = machine::MakeKinematics(options);
    for (const Vec3& in_block : {Vec3(1, 2, 3), Vec3(49, 3, 20), Vec3(20, 48, 10)}) {
      const auto axes = kinematics->ToAxes(InAir().origin_mm + in_block, Vec3(5, 0, 0));
      ASSERT_TRUE(axes) << axes.error().message;
      const auto found = TraceFocus(FocusAt(positioner, *axes), InAir(), further);
      EXPECT_EQ(found.station, station);
      EXPECT_LT((found.focus.position_mm - in_block).norm(), kNoMm);
    }
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
