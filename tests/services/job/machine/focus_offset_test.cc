#include "services/job/machine/focus_offset.h"

#include <gmock/gmock.h>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/machine/block_origin.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;

/// els-03 with lenses of 50 and 80 mm working distance, and a second channel beside.
MachineSpec Machine() {
  MachineSpec machine = GoodMachine();
  machine.mutable_lenses(0)->set_working_distance_mm(50);
  machine.mutable_lenses(1)->set_working_distance_mm(80);
  ChannelPosition& second = *machine.add_channel_positions();
  second.set_channel(2);
  second.mutable_offset_mm()->set_x(0.4);
  second.mutable_offset_mm()->set_y(-0.3);
  second.mutable_offset_mm()->set_z(0.1);
  machine.mutable_block_origin_mm()->set_x(10);
  return machine;
}

JobSpec Job(const MachineSpec& machine, std::initializer_list<std::uint32_t> channels,
            double focal_mm) {
  JobSpec job = GoodJob();
  job.mutable_laser()->clear_channels();
  for (const std::uint32_t channel : channels) job.mutable_laser()->add_channels(channel);
  job.mutable_lens()->set_focal_length_mm(focal_mm);
  return WithDefaults(job, machine);
}

Vec3 Origin(const MachineSpec& machine, std::initializer_list<std::uint32_t> channels,
            double focal_mm) {
  return BlockOriginOf(machine, Job(machine, channels, focal_mm));
}

// A head whose lens works 30 mm farther has its focus 30 mm lower: it has to be 30 mm
// higher for the same block, so the block is 30 mm higher for its axes.
TEST(FocusOffset, OfALensIsByItsWorkingDistance) {
  const MachineSpec machine = Machine();
  EXPECT_EQ(Origin(machine, {1}, 43), Vec3(10, 0, 0));
  EXPECT_EQ(Origin(machine, {1}, 70), Vec3(10, 0, 30));
  MachineSpec by_other = machine;
  by_other.set_zero_lens("f70");
  EXPECT_EQ(Origin(by_other, {1}, 43), Vec3(10, 0, -30));
  MachineSpec without = machine;
  without.mutable_lenses(1)->clear_working_distance_mm();
  EXPECT_EQ(Origin(without, {1}, 70), Vec3(10, 0, 0));
}

// The crack of channel N is `offset` from where it is to be: the axes go so far less.
TEST(FocusOffset, OfAChannelIsTakenBack) {
  const MachineSpec machine = Machine();
  EXPECT_EQ(Origin(machine, {2}, 43), Vec3(9.6, 0.3, -0.1));
  EXPECT_EQ(Origin(machine, {3}, 43), Vec3(10, 0, 0));
}

TEST(FocusOffset, ReachesTheAxesOfAJob) {
  FrozenJob frozen;
  *frozen.mutable_machine() = Machine();
  *frozen.mutable_job() = Job(Machine(), {2}, 70);
  frozen.mutable_optics()->set_stage_per_glass_ratio(1);
  EXPECT_LT(
      (MachineFromGlassOf(frozen).ToMachine({1, 2, 3}) - Vec3(10.6, 2.3, 32.9)).norm(),
      1e-12);
}

TEST(FocusOffset, ChannelsThatMeetElsewhereAreRefusedInOneJob) {
  const MachineSpec machine = Machine();
  const auto found = CheckJobOnMachine(Job(machine, {1, 2}, 43), machine);
  EXPECT_THAT(found, Contains(Field(&Finding::message,
                                    HasSubstr("models[0].channels: 2 has a zero that is "
                                              "0.5099 mm"))));
  EXPECT_TRUE(CheckJobOnMachine(Job(machine, {1, 3}, 43), machine).empty());
  MachineSpec near = machine;
  near.mutable_channel_positions(0)->mutable_offset_mm()->CopyFrom({});
  near.mutable_channel_positions(0)->mutable_offset_mm()->set_x(0.029);
  EXPECT_TRUE(CheckJobOnMachine(Job(near, {1, 2}, 43), near).empty());
}

TEST(FocusOffset, ATaughtZeroPrecedes) {
  MachineSpec machine = Machine();
  TaughtZero& zero = *machine.mutable_taught()->add_zeros();
  zero.set_channel(2);
  zero.set_lens("f70");
  zero.mutable_block_origin_mm()->set_y(7);
  EXPECT_EQ(Origin(machine, {2}, 70), Vec3(0, 7, 0));
  EXPECT_EQ(Origin(machine, {2}, 43), Vec3(9.6, 0.3, -0.1));
}

TEST(FocusOffset, TheMountedLensIsThatOfJobsThatNameNone) {
  MachineSpec machine = Machine();
  JobSpec job = GoodJob();
  job.clear_lens();
  EXPECT_EQ(WithDefaults(job, machine).lens().focal_length_mm(), 43);
  machine.set_mounted_lens("f70");
  EXPECT_EQ(WithDefaults(job, machine).lens().focal_length_mm(), 70);
  EXPECT_EQ(WithDefaults(job, machine).lens().numerical_aperture(), 5.0 / 140);
}

}  // namespace
}  // namespace intaglio
