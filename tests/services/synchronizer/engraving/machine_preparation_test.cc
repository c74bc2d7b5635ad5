#include "services/synchronizer/engraving/machine_preparation.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using link::LaserFrame;
using testing::HasSubstr;
using namespace std::chrono_literals;

class MachinePreparationTest : public testing::Test {
 protected:
  MachinePreparationTest() { job_.plan.rate_hz = FakeLaser::kRateHz; }
  void LightLampFor(std::chrono::milliseconds time) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      preparation_.LightLamp(bench_.now);
    }
  }

  EngravingJob job_;
  LaserBench bench_;
  MachinePreparation preparation_{job_, bench_.controller};
};

TEST_F(MachinePreparationTest, RefusesAnotherBlockAndALineThatIsDown) {
  EXPECT_EQ(preparation_.Refusal(), "");
  job_.block_misfit = "another block";
  EXPECT_EQ(preparation_.Refusal(), "another block");
  EXPECT_TRUE(preparation_.is_lost());
  job_.block_misfit.clear();
  bench_.CutLine(true);
  bench_.StepFor(600ms);
  EXPECT_THAT(preparation_.Refusal(), HasSubstr("laser line is down"));
}

// The job would wait for ever for a lamp that is warm at another rate.
TEST_F(MachinePreparationTest, RefusesARateThatTheLaserDoesNotHave) {
  job_.plan.rate_hz = 2 * FakeLaser::kRateHz;
  EXPECT_EQ(preparation_.Refusal(),
            fmt::format("the laser has no lamp sync rate of {} Hz but {} Hz: cancel the "
                        "job, correct laser.rates_hz of the machine profile, and submit "
                        "the job with one of these rates",
                        2 * FakeLaser::kRateHz, FakeLaser::kRateHz));
}

TEST_F(MachinePreparationTest, RefusesAnEnergyThatTheLaserDoesNotMake) {
  const auto refusal_of = [&](double min_mj, double max_mj, double asked_mj) {
    bench_.laser.min_energy_mj = min_mj;
    bench_.laser.max_energy_mj = max_mj;
    bench_.PowerCycle();
    bench_.StepFor(600ms);
    job_.energies.distinct_mj = {asked_mj};
    return preparation_.Refusal();
  };
  const std::string remedy =
      ": cancel the job, correct laser.pulse_energy_mj of the machine profile, and "
      "submit the job with an energy that the laser has";
  EXPECT_EQ(refusal_of(1, 30, 1), "");
  EXPECT_EQ(refusal_of(1, 30, 30), "");
  EXPECT_EQ(refusal_of(1, 30, 31),
            "the laser makes no pulses of 31 mJ but 1..30 mJ" + remedy);
  EXPECT_EQ(refusal_of(1, 30, 0.5),
            "the laser makes no pulses of 0.5 mJ but 1..30 mJ" + remedy);
  EXPECT_EQ(refusal_of(10, 10, 10), "");
  job_.energies = {{2, 10}, {1, 0, 1}};
  EXPECT_EQ(preparation_.Refusal(),
            "the laser makes no pulses of 2 mJ but 10 mJ alone" + remedy)
      << "of one point of several";
  EXPECT_EQ(refusal_of(10, 10, 2),
            "the laser makes no pulses of 2 mJ but 10 mJ alone" + remedy);
}

TEST_F(MachinePreparationTest, SwitchesTheLampOnOnceASession) {
  LightLampFor(200ms);
  EXPECT_TRUE(bench_.laser.lamp_on());
  EXPECT_EQ(bench_.ReceivedCount(LaserFrame::kLampCommand), 1u);
  bench_.PowerCycle();
  EXPECT_FALSE(bench_.laser.lamp_on());
  LightLampFor(200ms);
  EXPECT_TRUE(bench_.laser.lamp_on());
  EXPECT_EQ(bench_.ReceivedCount(LaserFrame::kLampCommand), 2u);
}

TEST_F(MachinePreparationTest, WaitsForTheLampAndThenForTheStage) {
  MotionView motion;
  motion.fault = intaglio_MOTION_OK;
  motion.fresh = true;
  LightLampFor(50ms);
  EXPECT_THAT(preparation_.WhatIsMissing(motion, true),
              HasSubstr("the lamp warms up: 0 %"));
  EXPECT_TRUE(preparation_.is_lost());
  bench_.PassTicks(30);
  bench_.StepFor(30ms);
  EXPECT_EQ(preparation_.WhatIsMissing(motion, true), "");
  EXPECT_FALSE(preparation_.is_lost());
  motion.fault = intaglio_MOTION_LINK_LOST;
  motion.message = "no cable";
  EXPECT_EQ(preparation_.WhatIsMissing(motion, true), "no cable");
  motion.fresh = false;
  EXPECT_EQ(preparation_.WhatIsMissing(motion, true), TextOf(Missing::kMotionState));
}

TEST_F(MachinePreparationTest, ALampThatIsOffAndWaitsForAGrantHidesNoFaultOfTheStage) {
  MotionView motion;
  EXPECT_EQ(preparation_.WhatIsMissing(motion, false), TextOf(Missing::kMotionState));
  motion.fresh = true;
  motion.fault = intaglio_MOTION_OK;
  EXPECT_EQ(preparation_.WhatIsMissing(motion, false), "");
}

TEST_F(MachinePreparationTest, NamesALampSyncThatIsTooShort) {
  MotionView motion;
  motion.fault = intaglio_MOTION_OK;
  motion.fresh = true;
  bench_.laser.short_sync = true;
  LightLampFor(50ms);
  EXPECT_THAT(preparation_.WhatIsMissing(motion, true), HasSubstr("min_sync_width_us"));
}

TEST_F(MachinePreparationTest, ALampOfAnotherRateIsNotReady) {
  bench_.WarmUp();
  job_.plan.rate_hz = 2 * FakeLaser::kRateHz;
  MotionView motion;
  motion.fresh = true;
  motion.fault = intaglio_MOTION_OK;
  EXPECT_THAT(preparation_.WhatIsMissing(motion, true), HasSubstr("warms up"));
}

TEST_F(MachinePreparationTest, ASafeStateIsResetByAGrantAlone) {
  bench_.laser.EnterSafeState();
  bench_.StepFor(30ms);
  ASSERT_TRUE(bench_.controller.Has(link::kSafeState));
  preparation_.LeaveSafeState(false, bench_.now);
  bench_.StepFor(30ms);
  EXPECT_EQ(bench_.ReceivedCount(LaserFrame::kLaserReset), 0u);
  preparation_.LeaveSafeState(true, bench_.now);
  bench_.StepFor(30ms);
  EXPECT_FALSE(bench_.controller.Has(link::kSafeState));
  preparation_.LeaveSafeState(true, bench_.now);
  bench_.StepFor(30ms);
  EXPECT_EQ(bench_.ReceivedCount(LaserFrame::kLaserReset), 1u) << "there is no need";
}

}  // namespace
}  // namespace intaglio::synchronizer
