#include "services/job/teach/test_points.h"

#include <gmock/gmock.h>

#include "services/job/files/job_file.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/teach/teaching.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::HasSubstr;

constexpr double kTestRatio = 0.65;
const Vec3 kTestBlock(50, 40, 30);

MachineSpec MovingTable() {
  MachineSpec machine = GoodMachine();
  for (LinearAxis* axis : {machine.mutable_cartesian()->mutable_x(),
                           machine.mutable_cartesian()->mutable_y()}) {
    axis->set_moves(AXIS_MOVES_TABLE);
  }
  return machine;
}

/// Axes with the focus at a place of the block's surroundings, by hand: origin at 0.
Vec3 AxesAbove(const MachineSpec& machine, const Vec3& place_mm) {
  return machine.has_cartesian() ? Vec3(-place_mm.x(), -place_mm.y(), place_mm.z())
                                 : place_mm;
}

optics::MachineFromGlass FrameAtZero(const MachineSpec& machine) {
  optics::MachineFromGlass frame =
      TestFrame(machine, 1, machine.lenses(0).name(), kTestBlock, kTestRatio);
  frame.block_origin_mm = Vec3::Zero();
  return frame;
}

TEST(TestPoints, APulseIsWhereTheFocusIsAlsoUnderAMovingTable) {
  for (const MachineSpec& machine : {GoodMachine(), MovingTable()}) {
    // 6.5 mm of air below the face are 10 mm of glass.
    const auto point = PointUnderFocus(machine, AxesAbove(machine, Vec3(12, 7, 23.5)),
                                       FrameAtZero(machine));
    ASSERT_TRUE(point) << point.error().message;
    EXPECT_LT((*point - Vec3(12, 7, 20)).norm(), 1e-9);
  }
}

TEST(TestPoints, APulseOutsideTheBlockIsRefusedWithTheWay) {
  const MachineSpec machine = GoodMachine();
  const auto frame = FrameAtZero(machine);
  const auto above = PointUnderFocus(machine, Vec3(12, 7, 32), frame);
  ASSERT_FALSE(above);
  EXPECT_THAT(above.error().message, HasSubstr("2.000 mm above the block"));
  EXPECT_FALSE(PointUnderFocus(machine, Vec3(12, 7, 1), frame));
  const auto beside = PointUnderFocus(machine, Vec3(51, 7, 25), frame);
  ASSERT_FALSE(beside);
  EXPECT_THAT(beside.error().message, HasSubstr("x would be 51.000 mm"));
}

TEST(TestPoints, ASeriesGoesDownFromTheFace) {
  const MachineSpec machine = GoodMachine();
  const FocusSeries series{0.1, 5, 0.4};
  const auto points =
      FocusSeriesPoints(machine, Vec3(10, 20, 3), FrameAtZero(machine), series);
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT(((*points)[i] - Vec3(10 + 0.4 * i, 20, 30 - 0.1 * (i + 1))).norm(), 1e-9);
  }
  const auto frame = FrameAtZero(machine);
  EXPECT_FALSE(FocusSeriesPoints(machine, Vec3(49, 20, 3), frame, series));
  EXPECT_FALSE(FocusSeriesPoints(machine, Vec3(10, 20, 3), frame, {10, 5, 0.4}));
  EXPECT_FALSE(FocusSeriesPoints(machine, Vec3(10, 20, 3), frame, {0.1, 1, 0.4}));
  EXPECT_FALSE(FocusSeriesPoints(machine, Vec3(10, 20, 3), frame, {0, 5, 0.4}));
}

// The oracle is the way of the light: the true face is `off_mm` of air below the nominal
// one, and a crack forms where the focus in air is below it.
TEST(TestPoints, TheFirstCrackPutsTheZeroWithinHalfAStepOfTheFace) {
  MachineSpec machine = GoodMachine();
  const std::string lens = machine.lenses(0).name();
  const double step_mm = 0.1;
  for (double off_mm = 0.07; off_mm < 1.2; off_mm += 0.013) {
    const auto frame = FrameAtZero(machine);
    const PointList points =
        FocusSeriesPoints(machine, Vec3(5, 20, 3), frame, {step_mm, 20, 0.4}).value();
    std::uint32_t first = 1;
    for (const Vec3& point : points) {
      if (frame.ToMachine(point).z() < kTestBlock.z() - off_mm) break;
      ++first;
    }
    ASSERT_LE(first, points.size());
    const auto move = ZeroMoveOfFirstCrack(points, kTestBlock.z(), kTestRatio, first);
    ASSERT_TRUE(move) << move.error().message;
    EXPECT_NEAR(*move, -off_mm, kTestRatio * step_mm / 2 + 1e-9) << off_mm;
  }
}

TEST(TestPoints, ASeriesThatBeganInTheGlassTeachesNothing) {
  const PointList points = {{0, 0, 29.9}, {1, 0, 29.8}, {2, 0, 29.7}};
  const auto move = ZeroMoveOfFirstCrack(points, 30, kTestRatio, 1);
  ASSERT_FALSE(move);
  EXPECT_THAT(move.error().message, HasSubstr("raise the zero"));
  EXPECT_FALSE(ZeroMoveOfFirstCrack(points, 30, kTestRatio, 0));
  EXPECT_FALSE(ZeroMoveOfFirstCrack(points, 30, kTestRatio, 4));
}

}  // namespace
}  // namespace intaglio
