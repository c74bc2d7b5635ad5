#include "services/job/head/point_pulses.h"

#include <gmock/gmock.h>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_defaults.h"
#include "tests/services/job/finding_matcher.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// 30 kHz, 0.5 ms a point.
MachineSpec BoardOfPulses() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/bjjcz-glass.textproto")
      .value();
}

JobSpec SmallJob() {
  JobSpec job = GoodJob();
  job.clear_lens();
  job.clear_laser();
  job.clear_motion();
  job.mutable_discretization()->clear_min_spacing_mm();
  Vector3& size_mm = *job.mutable_block()->mutable_size_mm();
  size_mm.set_x(50), size_mm.set_y(50), size_mm.set_z(40);
  return job;
}

TEST(PointPulses, AreThoseOfTheDwellWhereTheJobAsksForNone) {
  const JobSpec job = WithDefaults(SmallJob(), BoardOfPulses());
  EXPECT_EQ(job.laser().pulses_per_point(), 15);
  EXPECT_DOUBLE_EQ(JumpTimesOf(BoardOfPulses(), job.laser()).dwell_s, 0.0005);
  const MachineSpec galvo =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/galvo-glass.textproto")
          .value();
  EXPECT_FALSE(WithDefaults(SmallJob(), galvo).laser().has_pulses_per_point());
}

TEST(PointPulses, OfTheJobDecideHowLongAPointTakes) {
  JobSpec job = SmallJob();
  job.mutable_laser()->set_pulses_per_point(45);
  job = WithDefaults(job, BoardOfPulses());
  EXPECT_THAT(CheckJobOnMachine(job, BoardOfPulses(), 0.658), IsEmpty());
  EXPECT_NEAR(JumpTimesOf(BoardOfPulses(), job.laser()).dwell_s, 45 / 30000.0, 1e-12);
}

TEST(PointPulses, OfAMachineThatCannotMakeThemAreRefused) {
  const auto message_on = [](const MachineSpec& machine, std::uint32_t pulses) {
    return WhyNotSoManyPulses(machine, pulses);
  };
  MachineSpec machine = BoardOfPulses();
  // 151 ms with the longest jump; a list ends by itself within 140 ms.
  EXPECT_THAT(message_on(machine, 3000), HasSubstr("at most 0.14 s is possible"));
  // 2 us a pulse: 10 us are five, and not three.
  machine.mutable_bjjcz_board()->set_point_frequency_hz(500'000);
  EXPECT_THAT(message_on(machine, 3), HasSubstr("ask for a multiple of 5"));
  EXPECT_EQ(message_on(machine, 10), "");
  machine.mutable_bjjcz_board()->clear_point_frequency_hz();
  EXPECT_THAT(message_on(machine, 2), HasSubstr("makes a point by one pulse"));
  EXPECT_EQ(message_on(machine, 1), "");
  JobSpec job = SmallJob();
  job.mutable_laser()->set_pulses_per_point(3000);
  EXPECT_THAT(
      CheckJobOnMachine(job, WithMachineDefaults(BoardOfPulses()), 0.658),
      Contains(Field(&Error::message, HasSubstr("laser.pulses_per_point: 3000 take"))));
}

}  // namespace
}  // namespace intaglio
