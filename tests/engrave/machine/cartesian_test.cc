#include "engrave/machine/cartesian.h"

#include <gtest/gtest.h>

#include <bit>

namespace intaglio::machine {
namespace {

LinearAxis AxisOf(int bits) { return {(bits & 1) != 0, (bits & 2) != 0}; }

// By moving both parts: the focus in the block is where the head is, seen from the block.
Vec3 FocusInBlock(const CartesianOptions& options, const Vec3& axes) {
  Vec3 head_mm = Vec3::Zero(), table_mm = Vec3::Zero();
  const LinearAxis* all[] = {&options.x, &options.y, &options.z};
  for (int i = 0; i < 3; ++i) {
    const double moved_mm = all[i]->reversed ? -axes[i] : axes[i];
    (all[i]->moves_table ? table_mm : head_mm)[i] = moved_mm;
  }
  return head_mm - table_mm;
}

// Head or table, up or down, of each axis.
TEST(Cartesian, EveryArrangementBringsTheFocusToThePlace) {
  const Vec3 place_mm(12.5, -3.25, 40.0625);
  for (int arrangement = 0; arrangement < 64; ++arrangement) {
    const CartesianOptions options{AxisOf(arrangement), AxisOf(arrangement >> 2),
                                   AxisOf(arrangement >> 4)};
    const auto axes = MakeCartesian(options)->ToAxes(place_mm, Vec3::Zero());
    ASSERT_TRUE(axes);
    EXPECT_EQ(FocusInBlock(options, *axes), place_mm) << arrangement;
  }
}

TEST(Cartesian, ATableGoesTheOtherWayThanAHead) {
  const CartesianOptions table{{.moves_table = true}, {.moves_table = true}, {}};
  EXPECT_EQ(MakeCartesian(table)->ToAxes(Vec3(1, 2, 3), Vec3::Zero()).value(),
            Vec3(-1, -2, 3));
}

// A profile that names nothing gets the very numbers it got before there were directions.
TEST(Cartesian, TheDefaultKeepsEveryBit) {
  const auto head = MakeKinematics(CartesianOptions{});
  const Vec3 place_mm(0.1, -0.0, 1e-300);
  const Vec3 axes = head->ToAxes(place_mm, Vec3::Constant(7)).value();
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(axes[i]),
              std::bit_cast<std::uint64_t>(place_mm[i]));
  }
}

}  // namespace
}  // namespace intaglio::machine
