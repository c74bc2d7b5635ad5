// The stage that carries the block under a scan head, of a profile and of jobs. The
// oracle of places is the geometry, written here once more.

#include <gmock/gmock.h>

#include <cmath>
#include <functional>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/machine_defaults.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;

AxisLimits StageAxis(double min_mm, double max_mm) {
  AxisLimits axis;
  axis.set_travel_min_mm(min_mm);
  axis.set_travel_max_mm(max_mm);
  axis.set_max_speed_mm_s(50);
  axis.set_max_acceleration_mm_s2(500);
  return axis;
}

MachineSpec WithStage() {
  MachineSpec machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-glass.textproto")
          .value();
  BlockStage& stage = *machine.mutable_head_over_block()->mutable_block_stage();
  *stage.mutable_x() = StageAxis(-90, 10);
  *stage.mutable_y() = StageAxis(-50, 0);
  return machine;
}

JobSpec WideJob(double x_mm, double y_mm) {
  JobSpec job = GoodJob();
  job.clear_lens();
  job.clear_laser();
  job.clear_motion();
  job.mutable_discretization()->clear_min_spacing_mm();
  Vector3& size_mm = *job.mutable_block()->mutable_size_mm();
  size_mm.set_x(140);
  size_mm.set_y(100);
  size_mm.set_z(40);
  job.mutable_block_place()->set_x_mm(x_mm);
  job.mutable_block_place()->set_y_mm(y_mm);
  return job;
}

std::vector<Finding> Check(const JobSpec& job, const MachineSpec& machine) {
  return CheckJobOnMachine(job, WithMachineDefaults(machine), 0.658);
}

TEST(BlockPlace, MovesTheBlockByTheJobsWay) {
  const MachineSpec machine = WithMachineDefaults(WithStage());
  const JobSpec here = WithDefaults(WideJob(0, 0), machine),
                there = WithDefaults(WideJob(-80, -40), machine);
  EXPECT_EQ(BlockOriginOf(machine, there),
            BlockOriginOf(machine, here) + Vec3(-80, -40, 0));
  EXPECT_EQ(BlockOriginOf(machine, 1, "f100"), BlockOriginOf(machine, here))
      << "what is taught is of the stage at zero";
}

// A stage 0.4 % too long in x, turned by 3 mrad, with its y 2 mrad from a right angle:
// its axes are those whose ways add up to the place.
TEST(BlockPlace, IsReachedByTheStageAsItIsMeasured) {
  MachineSpec machine = WithStage();
  BlockStage& stage = *machine.mutable_head_over_block()->mutable_block_stage();
  stage.set_x_scale_ratio(1.004);
  stage.set_rotation_rad(0.003);
  stage.set_squareness_xy_rad(0.002);
  const Vec2 at_mm = BlockStageAt(machine, Vec2(-80, -40));
  const Vec2 along_x(1.004 * std::cos(0.003), 1.004 * std::sin(0.003));
  const double y_turn_rad = 0.003 - 0.002;
  const Vec2 along_y(-std::sin(y_turn_rad), std::cos(y_turn_rad));
  EXPECT_NEAR((at_mm.x() * along_x + at_mm.y() * along_y - Vec2(-80, -40)).norm(), 0,
              1e-9);
  FrozenJob frozen;
  *frozen.mutable_machine() = machine;
  *frozen.mutable_job() = WideJob(-80, -40);
  EXPECT_EQ(BlockStageOf(frozen), at_mm);
  frozen.mutable_machine()->mutable_head_over_block()->clear_block_stage();
  EXPECT_FALSE(BlockStageOf(frozen));
}

TEST(BlockPlace, ABlockWiderThanTheFieldIsTakenWithAStageAlone) {
  EXPECT_THAT(Check(WideJob(-80, -40), WithStage()), IsEmpty());
  JobSpec without = WideJob(0, 0);
  without.clear_block_place();
  EXPECT_THAT(Check(without, WithStage()), IsEmpty());
  MachineSpec machine = WithStage();
  machine.mutable_head_over_block()->clear_block_stage();
  EXPECT_THAT(
      Check(without, machine),
      Contains(Field(&Error::message, HasSubstr("does not fit in the field of"))));
}

FrozenJob FrozenAt(const JobSpec& job, const MachineSpec& machine) {
  FrozenJob frozen;
  *frozen.mutable_machine() = WithMachineDefaults(machine);
  *frozen.mutable_job() = WithDefaults(job, frozen.machine());
  frozen.mutable_optics()->set_stage_per_glass_ratio(0.658);
  frozen.mutable_optics()->set_refractive_index(1.519);
  return frozen;
}

// The middle of a block of 900 mm is far beyond what any beam reaches. Limits and scales
// are those of the part in the field: as of a block that just fills it.
TEST(BlockPlace, PlansWithTheScalesOfTheFieldHoweverWideTheBlockIs) {
  MachineSpec machine = WithStage();
  machine.mutable_head_over_block()
      ->mutable_block_stage()
      ->mutable_x()
      ->set_travel_min_mm(-900);
  JobSpec wide = WideJob(-100, 0);
  wide.mutable_block()->mutable_size_mm()->set_x(900);
  EXPECT_THAT(Check(wide, machine), IsEmpty());
  const FrozenJob frozen = FrozenAt(wide, machine);
  JobSpec filling = WideJob(0, 0);
  filling.clear_block_place();
  filling.mutable_block()->mutable_size_mm()->set_x(70);
  filling.mutable_block()->mutable_size_mm()->set_y(65);  // of 100 from -30 on
  machine.mutable_head_over_block()->clear_block_stage();
  machine.mutable_block_origin_mm()->set_x(-35);
  const FrozenJob narrow = FrozenAt(filling, machine);
  EXPECT_LT((ScaleBoundsOf(frozen).axis_mm - ScaleBoundsOf(narrow).axis_mm).norm(), 1e-9);
  EXPECT_NEAR(ScaleBoundsOf(frozen).any_mm, ScaleBoundsOf(narrow).any_mm, 1e-9);
  const Vec3 limits = GlassLimitsOf(frozen).max_speed_mm_s,
             expected = GlassLimitsOf(narrow).max_speed_mm_s;
  EXPECT_LT((limits - expected).norm(), 1e-6 * expected.norm());
}

TEST(BlockPlace, IsRefusedWithItsValueAndARemedy) {
  struct Case {
    std::function<void(JobSpec&, MachineSpec&)> spoil;
    const char *field, *text;
  };
  const std::vector<Case> cases = {
      {[](JobSpec&, MachineSpec& m) { m.mutable_head_over_block()->clear_block_stage(); },
       "block_place", "-80, -40 mm is of a machine with head_over_block.block_stage"},
      {[](JobSpec& j, MachineSpec&) { j.mutable_block_place()->set_x_mm(-91); },
       "block_place.x_mm",
       "-91 is beyond the reach of galvo-glass: the stage that carries the block would "
       "have to go to -91 mm, its travel is -90 to 10"},
      {[](JobSpec& j, MachineSpec&) { j.mutable_block_place()->set_y_mm(0.1); },
       "block_place.y_mm", "to go to 0.1 mm, its travel is -50 to 0"},
  };
  for (const Case& one : cases) {
    JobSpec job = WideJob(-80, -40);
    MachineSpec machine = WithStage();
    one.spoil(job, machine);
    EXPECT_THAT(Check(job, machine),
                Contains(testing::AllOf(Field(&Finding::field, one.field),
                                        Field(&Finding::message, HasSubstr(one.text)))))
        << one.text;
  }
}

TEST(BlockPlace, AStageOfAProfileHasBothAxesAndItsZero) {
  EXPECT_THAT(CheckMachine(WithStage()), IsEmpty());
  MachineSpec machine = WithStage();
  machine.mutable_head_over_block()->mutable_block_stage()->clear_y();
  EXPECT_THAT(CheckMachine(machine),
              Contains(Field(&Error::message,
                             HasSubstr("head_over_block.block_stage.y: is missing"))));
  machine = WithStage();
  machine.mutable_head_over_block()
      ->mutable_block_stage()
      ->mutable_x()
      ->set_travel_max_mm(-1);
  EXPECT_THAT(CheckMachine(machine),
              Contains(Field(&Error::message,
                             HasSubstr("block_stage.x.travel_min_mm: -90 to "
                                       "travel_max_mm, -1, is no travel with 0 in it"))));
}

}  // namespace
}  // namespace intaglio
