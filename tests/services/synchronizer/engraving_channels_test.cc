// Points of several channels: each is fired with its own shutters open and no other, in
// runs that follow one another without anybody's help.

#include <gmock/gmock.h>

#include <set>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr std::uint32_t kChannelPoints = 120;
constexpr std::uint32_t kGroups = 8;  // of MasksInStretches

class Channels : public testing::TestWithParam<bool> {
 protected:
  CellOptions Options() const {
    return {.points = kChannelPoints,
            .lockstep = GetParam(),
            .masks = MasksInStretches(kChannelPoints)};
  }
};

INSTANTIATE_TEST_SUITE_P(Engraving, Channels, testing::Bool(), [](const auto& param) {
  return std::string(param.param ? "Lockstep" : "RealTime");
});

TEST_P(Channels, ARunForEachGroupUnderOneGrant) {
  FakeCell cell(Options());
  cell.Grant();
  std::set<std::string> messages;
  ASSERT_TRUE(cell.StepUntil([&] {
    EXPECT_FALSE(cell.engraving->started() && cell.engraving->waits());
    if (cell.engraving->started()) messages.insert(cell.engraving->message());
    return cell.done();
  })) << cell.Description();
  EXPECT_EQ(messages, std::set<std::string>{""});
  EXPECT_EQ(cell.made(), kChannelPoints);
  EXPECT_EQ(cell.engraving->run_count(), kGroups);
  cell.StepFor(5ms);
  EXPECT_EQ(cell.laser.shutters(), 0);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  for (std::size_t i = 1; i < cell.laser.cracks().size(); ++i) {
    EXPECT_EQ(cell.results[i].point, i) << "in the order of the plan";
  }
}

TEST_P(Channels, ShuttersThatTakeTheirTime) {
  FakeCell cell(Options());
  cell.laser.shutter_travel = 80ms;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.made(), kChannelPoints);
  EXPECT_EQ(cell.engraving->run_count(), kGroups);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

TEST_P(Channels, AnotherShutterThatOpensEndsTheRun) {
  FakeCell cell(Options());
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20));  // in channel 1 alone
  cell.laser.stuck_open = 4;
  cell.StepFor(2s);
  EXPECT_EQ(cell.phase(), Engraving::Phase::kWaiting);
  EXPECT_TRUE(cell.engraving->faulted());
  const std::size_t cracks = cell.laser.cracks().size();
  cell.GrantAnew();
  cell.StepFor(3s);
  EXPECT_EQ(cell.laser.cracks().size(), cracks) << "not while it is open";
  EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("does not close"));
  cell.laser.stuck_open = 0;
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.made(), kChannelPoints);
}

TEST_P(Channels, APauseInMidGroupGoesOnThere) {
  FakeCell cell(Options());
  cell.Grant();
  for (const std::uint64_t made : {5, 17, 18, 40, 118}) {
    ASSERT_TRUE(cell.StepUntilMade(made)) << cell.Description();
    cell.Withdraw();
    cell.StepFor(300ms);
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
    cell.Grant();
  }
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.made(), kChannelPoints);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

// Who takes it up knows the masks from the job alone.
TEST_P(Channels, KilledAtAnyInstantItIsTakenUpInTheRightChannels) {
  for (int instant_ms = 3;; instant_ms += GetParam() ? 13 : 931) {
    FakeCell cell(Options());
    cell.Grant();
    cell.StepFor(std::chrono::milliseconds(instant_ms));
    if (cell.done()) break;
    SCOPED_TRACE(testing::Message() << "killed after " << instant_ms << " ms");
    cell.DieAndTakeUp();
    cell.GrantAnew();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
    EXPECT_EQ(cell.made(), kChannelPoints);
    if (testing::Test::HasFailure()) return;
  }
}

TEST_P(Channels, WhatTheOperatorLeavesOutMayBeWholeGroups) {
  FakeCell cell(Options());
  cell.first_point = 60;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.Count(PointState::kLeftOut), 60u);
  EXPECT_EQ(cell.made(), kChannelPoints - 60);
  EXPECT_EQ(cell.engraving->run_count(), kGroups - 3);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

}  // namespace
}  // namespace intaglio::synchronizer
