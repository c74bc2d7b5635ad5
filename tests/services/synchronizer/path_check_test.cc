#include "services/synchronizer/path_check.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/services/synchronizer/good_task.h"

namespace intaglio::synchronizer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kRatio = 0.65;
const Vec3 kBlockMm(50, 40, 30);
// The stage reaches depths of 20 mm in the glass.
const Box3 kTravel{Vec3(-1, -1, 30 - 20 * kRatio), Vec3(45, 100, 100)};

machine::AxesFromGlass Straight() {
  return {{Vec3::Zero(), kBlockMm, kRatio},
          machine::MakeKinematics(machine::CartesianOptions{})};
}

std::string RefusalOf(const PointList& points_mm) {
  PointCloud path;
  for (const Vec3& p : points_mm) path.Add(p, 0);
  const auto status =
      CheckedAxes(path, {{Vec3::Zero(), kBlockMm}}, {Straight()}, kTravel);
  if (status) return "";
  EXPECT_EQ(status.error().code, ErrorCode::kOutsideBlock);
  return status.error().message;
}

TEST(PathCheck, PointsInBlockAndTravelPassToTheirVeryEdges) {
  EXPECT_EQ(RefusalOf({Vec3(0, 0, 10), Vec3(45, 40, 30), Vec3(20, 20, 20)}), "");
  EXPECT_EQ(RefusalOf({Vec3(-0.0009, 40.0009, 30.0009)}), "");
}

TEST(PathCheck, OnePointOutsideTheBlockIsRefusedWithItsPlace) {
  EXPECT_THAT(
      RefusalOf({Vec3(1, 1, 20), Vec3(1, 40.002, 20)}),
      AllOf(HasSubstr("1 of 2 points"), HasSubstr("point 1 of the order"),
            HasSubstr("outside the block"), HasSubstr("y 40.002"), HasSubstr("0 to 40")));
  EXPECT_NE(RefusalOf({Vec3(-0.002, 1, 20)}), "");
  EXPECT_NE(RefusalOf({Vec3(1, 1, 30.002)}), "");
}

TEST(PathCheck, AllPointsThatFailAreCountedAndTheFirstIsNamed) {
  EXPECT_THAT(RefusalOf({Vec3(1, 1, 20), Vec3(1, 1, 31), Vec3(60, 1, 20), Vec3(1, 1, 9)}),
              AllOf(HasSubstr("3 of 4 points"), HasSubstr("point 1 of the order")));
}

// z by the focus: a point 21 mm deep takes the stage 21 * 0.65 mm down.
TEST(PathCheck, APointThatTheStageCannotReachIsRefusedWithTheTravel) {
  EXPECT_THAT(RefusalOf({Vec3(1, 1, 9)}),
              AllOf(HasSubstr("outside the stage's travel"), HasSubstr("z 16.35"),
                    HasSubstr("17 to 100")));
  EXPECT_THAT(RefusalOf({Vec3(46, 1, 20)}), HasSubstr("x 46"));
}

TEST(PathCheck, ACoordinateThatIsNoNumberIsRefused) {
  for (const double wrong : {std::nan(""), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()}) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 p(1, 1, 20);
      p[axis] = wrong;
      EXPECT_NE(RefusalOf({p}), "") << wrong;
    }
  }
}

TEST(PathCheck, ABlockThatIsNoNumberLetsNothingPass) {
  PointCloud path;
  path.Add(Vec3(1, 1, 20), 0);
  const Box3 no_number{Vec3::Zero(), Vec3::Constant(std::nan(""))};
  EXPECT_FALSE(CheckedAxes(path, {no_number}, {Straight()}, kTravel));
}

TEST(PathCheck, PointsOfAModelStayInTheBlockOfItsChannel) {
  JobSpec job = GoodTask().job();
  job.mutable_laser()->clear_channels();
  job.mutable_laser()->add_channels(1);
  *job.add_models() = job.models(0);
  job.mutable_models(1)->add_channels(2);
  ChannelBlock& small = *job.add_channel_blocks();
  small.set_channel(2);
  *small.mutable_size_mm() = job.block().size_mm();
  small.mutable_size_mm()->set_x(10);
  const std::vector<Box3> blocks = BlocksOfModels(job);
  ASSERT_EQ(blocks.size(), 2);
  PointCloud path;
  path.Add(Vec3(20, 1, 20), 0);
  EXPECT_TRUE(CheckedAxes(path, blocks, {Straight()}, kTravel));
  path.Add(Vec3(20, 1, 20), 1);
  const auto status = CheckedAxes(path, blocks, {Straight()}, kTravel);
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("point 1 of the order"));
}

TEST(PathCheck, AxesAreThoseOfTheFocusInAir) {
  PointCloud path;
  path.Add(Vec3(1, 2, 20), 0);
  const auto axes = CheckedAxes(path, {{Vec3::Zero(), kBlockMm}}, {Straight()}, kTravel);
  ASSERT_TRUE(axes);
  EXPECT_EQ(*axes, PointList{Vec3(1, 2, 30 - 10 * kRatio)});
}

// An arm of 120 mm, 200 mm from the axis of the table on which the block's edge lies 60
// mm away: places nearer than 82 mm are not served, and the table may turn by 0.6 rad.
TEST(PathCheck, ReachAndTravelOfAnArmAndATable) {
  machine::PolarOptions options;
  options.axis_distance_mm = 200;
  options.arm_length_mm = 120;
  const machine::AxesFromGlass polar({Vec3(-25, 60, 0), kBlockMm, 1},
                                     machine::MakeKinematics(options));
  const Box3 travel{Vec3(3, -0.2, 0), Vec3(6.3, 0.6, 30)};
  const auto refusal = [&](const PointList& points_mm) {
    PointCloud path;
    for (const Vec3& p : points_mm) path.Add(p, 0);
    const auto axes = CheckedAxes(path, {{Vec3::Zero(), kBlockMm}}, {polar}, travel);
    return axes ? "" : axes.error().message;
  };
  EXPECT_EQ(refusal({Vec3(25, 39, 5), Vec3(26, 39, 5)}), "");
  EXPECT_THAT(refusal({Vec3(25, 39, 5), Vec3(25, 10, 5)}),
              AllOf(HasSubstr("1 of 2 points"), HasSubstr("point 1 of the order"),
                    HasSubstr("out of reach"), HasSubstr("block_origin_mm")));
  EXPECT_THAT(refusal({Vec3(50, 39, 5)}),
              AllOf(HasSubstr("outside the stage's travel"), HasSubstr("rad"),
                    HasSubstr("-0.2 to 0.6")));
}

}  // namespace
}  // namespace intaglio::synchronizer
