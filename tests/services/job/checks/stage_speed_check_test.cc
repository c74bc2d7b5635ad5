#include "services/job/checks/stage_speed_check.h"

#include <gmock/gmock.h>

#include "services/job/files/job_file.h"

namespace intaglio {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(StageSpeed, NamesEachAxisThatIsFasterThanItsSteps) {
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
  EXPECT_THAT(CompareStageSpeed(machine, Vec3(80, 80, 80)), IsEmpty());
  EXPECT_THAT(CompareStageSpeed(machine, Vec3(100, 200, 4000)), IsEmpty());
  const auto faster = CompareStageSpeed(machine, Vec3(79.999999, 79.99, 40));
  ASSERT_THAT(faster, SizeIs(2));
  EXPECT_EQ(faster[0].message,
            "y.max_speed_mm_s: 80 mm/s is faster than the stage controller can step this "
            "axis; reduce it to at most 79.99 mm/s in the machine profile");
  EXPECT_THAT(faster[1].message, HasSubstr("z.max_speed_mm_s: 80 mm/s"));
  EXPECT_THAT(faster[1].message, HasSubstr("at most 40 mm/s"));
}

TEST(StageSpeed, OfAnAxisThatTurnsIsInRadians) {
  MachineSpec machine;
  machine.mutable_polar()->mutable_arm()->set_max_speed_rad_s(2);
  machine.mutable_polar()->mutable_table()->set_max_speed_rad_s(3.5);
  const auto faster = CompareStageSpeed(machine, Vec3(2, 3, 1));
  ASSERT_THAT(faster, SizeIs(1));
  EXPECT_THAT(faster[0].message,
              HasSubstr("polar.table.max_speed_rad_s: 3.5 rad/s is faster"));
}

}  // namespace
}  // namespace intaglio
