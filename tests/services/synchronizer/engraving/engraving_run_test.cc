#include "services/synchronizer/engraving/engraving_run.h"

#include <gmock/gmock.h>

#include "tests/services/synchronizer/fake_stage.h"
#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr std::uint32_t kRunPoints = 12;

/// A run between a fake laser and a fake stage in real time, 200 ticks a second. What is
/// in the glass is the oracle.
class EngravingRunTest : public testing::Test {
 protected:
  EngravingRunTest() {
    job_.uid = "job";
    for (std::uint32_t i = 0; i < kRunPoints; ++i) {
      job_.machine_points_mm.push_back(Vec3(0.05 * i, 0, 0));
    }
    job_.plan.rate_hz = FakeLaser::kRateHz;
    job_.max_missed_in_a_row = 3;
    (void)bench_.controller.Lamp(true, FakeLaser::kRateHz);
  }
  void Step() {
    bench_.Step();
    if (bench_.now >= next_tick_) {
      next_tick_ = bench_.now + 5ms;
      stage_.AdvanceTick(bench_.laser.tick() + 1);
      bench_.laser.AdvanceTick(stage_.in_position(), stage_.at_mm());
    }
    stage_.Poll(bench_.now, bench_.laser.tick());
    for (const auto& report : bench_.reports) parts_->ticks.Receive(report);
    bench_.reports.clear();
    inputs_.now = bench_.now;
    inputs_.motion = stage_.view();
    inputs_.motion.fresh = true;
    parts_->horizon.Observe(bench_.now);
  }
  /// With the lamp warm and its pace known.
  void Begin() {
    parts_.emplace(job_, bench_.controller, stage_, *journal_.writer, inputs_);
    for (int i = 0; i < 400; ++i) Step();
    ASSERT_TRUE(parts_->horizon.is_settled());
    BeginAgain();
  }
  void BeginAgain() {
    ASSERT_TRUE(parts_->shutters.Open(parts_->run.NextMask(), bench_.now));
    parts_->run.Begin(inputs_);
  }
  /// Until it is halted or finished.
  std::optional<HaltReason> TurnUntilItEnds() {
    for (int i = 0; i < 60'000; ++i) {
      Step();
      (void)parts_->shutters.UpdateSeenOpen();
      if (auto reason = parts_->run.Turn(inputs_)) return reason;
      journal_.AwaitDisk();
      if (parts_->run.is_finished(inputs_)) return std::nullopt;
    }
    return HaltReason{Missing::kNothing, "it does not end", true};
  }

  struct Parts {
    Parts(const EngravingJob& job, drivers::LaserController& laser, FakeStage& stage,
          JournalWriter& journal, const EngravingInputs& inputs)
        : record(kRunPoints, job.photosensor_feedback, journal,
                 [this](const PulseResult& r) { run.Note(r); }),
          feed([&](const auto& batch) { return stage.Receive(batch, inputs.now); },
               [&](const std::string& stream) { return stage.GrantOf(stream); }),
          ticks(laser, record),
          horizon(laser, job.plan.rate_hz),
          shutters(laser),
          run(job, feed, horizon, ticks, record, shutters) {}
    PulseRecord record;
    MotionFeed feed;
    TickWindows ticks;
    TickHorizon horizon;
    Shutters shutters;
    EngravingRun run;
  };

  EngravingJob job_;
  LaserBench bench_;
  FakeStage stage_;
  JournalBench journal_{kRunPoints};
  EngravingInputs inputs_;
  std::chrono::nanoseconds next_tick_{0};
  std::optional<Parts> parts_;
};

TEST_F(EngravingRunTest, MakesEachPointOnceAtItsPlace) {
  Begin();
  EXPECT_FALSE(TurnUntilItEnds());
  ASSERT_EQ(bench_.laser.cracks().size(), kRunPoints);
  for (std::uint32_t i = 0; i < kRunPoints; ++i) {
    EXPECT_LT((bench_.laser.cracks()[i].at_mm - job_.machine_points_mm[i]).norm(), 1e-6)
        << "positions travel in um as doubles";
  }
  EXPECT_EQ(parts_->record.run(), 1u);
  EXPECT_EQ(parts_->run.count(), 1u);
}

// The ticks of a short run have passed before a shutter counts as stuck.
TEST_F(EngravingRunTest, ArmsNothingBehindAShutterThatDoesNotOpen) {
  for (const double way : {1.0, 400.0}) {
    SCOPED_TRACE(way);
    bench_.laser.shutter_stuck = true;
    for (Vec3& point_mm : job_.machine_points_mm) point_mm *= way;
    Begin();
    const auto began_at = bench_.now;
    const auto reason = TurnUntilItEnds();
    ASSERT_TRUE(reason);
    EXPECT_EQ(reason->missing, Missing::kShutter) << reason->text;
    EXPECT_TRUE(reason->fault);
    EXPECT_GT(bench_.now - began_at, 2s);
    EXPECT_LT(bench_.now - began_at, 2100ms);
    EXPECT_EQ(bench_.laser.newest_arm_at(), 0ns);
  }
}

TEST_F(EngravingRunTest, ArmsNothingTheStageHasNoMotionFor) {
  stage_.deaf = true;
  Begin();
  // It begins again by itself a few times, each with twice the lead.
  for (int i = 0; i < 5; ++i) {
    const auto reason = TurnUntilItEnds();
    ASSERT_TRUE(reason);
    EXPECT_TRUE(reason->starts_again()) << i;
    EXPECT_THAT(reason->text, HasSubstr("its start was too late"));
    (void)parts_->ticks.DropUnsent();
    BeginAgain();
  }
  const auto reason = TurnUntilItEnds();
  ASSERT_TRUE(reason);
  EXPECT_TRUE(reason->fault);
  EXPECT_EQ(reason->missing, Missing::kMotionState) << reason->text;
  EXPECT_EQ(bench_.laser.newest_arm_at(), 0ns);
}

TEST_F(EngravingRunTest, APointThatWasPassedByEndsTheRun) {
  Begin();
  stage_.behind = true;
  const auto reason = TurnUntilItEnds();
  ASSERT_TRUE(reason);
  EXPECT_TRUE(reason->starts_again());
  EXPECT_THAT(reason->text, HasSubstr("pulses were skipped"));
  EXPECT_GT(parts_->run.passed_by_tick(), 0u);
  EXPECT_TRUE(bench_.laser.cracks().empty());
}

TEST_F(EngravingRunTest, WhenTheMachineHeldAPulseBackItIsAFault) {
  Begin();
  for (int i = 0; i < 400 && bench_.laser.cracks().empty(); ++i) {
    Step();
    (void)parts_->shutters.UpdateSeenOpen();
    ASSERT_FALSE(parts_->run.Turn(inputs_));
    journal_.AwaitDisk();
  }
  bench_.laser.door_closed = false;
  const auto reason = TurnUntilItEnds();
  ASSERT_TRUE(reason);
  EXPECT_TRUE(reason->fault);
  EXPECT_THAT(reason->text, HasSubstr("an interlock of the machine"));
}

TEST_F(EngravingRunTest, TooManyPulsesWithoutACrackInARowAreAFault) {
  bench_.laser.blind = true;
  Begin();
  const auto reason = TurnUntilItEnds();
  ASSERT_TRUE(reason);
  EXPECT_TRUE(reason->fault);
  EXPECT_THAT(reason->text, HasSubstr("no crack was detected for 3 pulses"));
}

TEST_F(EngravingRunTest, EndsWhereTheShuttersChange) {
  job_.masks.assign(kRunPoints, 1);
  for (std::uint32_t i = 5; i < kRunPoints; ++i) job_.masks[i] = 2;
  Begin();
  EXPECT_FALSE(TurnUntilItEnds());
  parts_->run.Finish();
  EXPECT_EQ(bench_.laser.cracks().size(), 5u);
  EXPECT_EQ(parts_->run.NextMask(), 2);
  BeginAgain();
  EXPECT_FALSE(TurnUntilItEnds());
  EXPECT_EQ(bench_.laser.cracks().size(), kRunPoints);
  EXPECT_EQ(bench_.laser.cracks().back().channels, 2);
}

TEST_F(EngravingRunTest, TwoFinishedRunsThatMadeNothingAreEnough) {
  Begin();
  EXPECT_FALSE(TurnUntilItEnds());
  parts_->run.Finish();
  EXPECT_FALSE(parts_->run.is_fruitless());
  for (int i = 0; i < 2; ++i) {
    EXPECT_FALSE(parts_->run.is_fruitless()) << i;
    BeginAgain();
    EXPECT_FALSE(TurnUntilItEnds());
    parts_->run.Finish();
  }
  EXPECT_TRUE(parts_->run.is_fruitless());
  parts_->run.ForgetFruitless();
  EXPECT_FALSE(parts_->run.is_fruitless());
}

TEST_F(EngravingRunTest, CountsItsChangesOfSpeed) {
  inputs_.speed_percent = 40;
  Begin();
  EXPECT_FALSE(TurnUntilItEnds());
  inputs_.speed_percent = 70;
  parts_->run.Finish();
  BeginAgain();
  EXPECT_EQ(parts_->run.min_speed_percent(), 40u);
  EXPECT_EQ(parts_->run.max_speed_percent(), 100u);
  EXPECT_EQ(parts_->run.speed_changes(), 2u);
}

}  // namespace
}  // namespace intaglio::synchronizer
