#include "engrave/machine/axes_from_glass.h"

#include <gtest/gtest.h>

namespace intaglio::machine {
namespace {

// The corner is 100 mm beyond the beam when the axes are at zero: the table brings it
// there at +100, and the lens goes down by the depth over the index.
TEST(AxesFromGlass, TakesFocusDepthFirstAndDirectionsThen) {
  const CartesianOptions table{{.moves_table = true}, {}, {.reversed = true}};
  const AxesFromGlass axes_from_glass({Vec3(-100, 20, 5), Vec3(50, 50, 30), 0.5},
                                      MakeKinematics(table));
  const Vec3 glass_mm(10, 4, 26);
  const Vec3 axes = axes_from_glass.ToAxes(glass_mm, Vec3::Zero()).value();
  EXPECT_EQ(axes, Vec3(90, 24, -33));
  EXPECT_EQ(axes_from_glass.ToGlass(axes), glass_mm);
}

TEST(AxesFromGlass, OfNothingIsTheGlassItself) {
  EXPECT_EQ(AxesFromGlass().ToAxes(Vec3(1, 2, 3), Vec3::Zero()).value(), Vec3(1, 2, 3));
  EXPECT_EQ(AxesFromGlass().ToGlass(Vec3(1, 2, 3)), Vec3(1, 2, 3));
}

}  // namespace
}  // namespace intaglio::machine
