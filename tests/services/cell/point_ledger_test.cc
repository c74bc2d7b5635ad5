#include "services/cell/point_ledger.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"

namespace intaglio::cell {
namespace {

using formats::PointOutcome;

TEST(PointLedger, CountsEveryPointInExactlyOneState) {
  PointLedger ledger(5);
  ledger.Arm(0);
  ledger.Arm(1);
  ledger.Arm(2);
  ledger.Resolve(0, PointOutcome::kMade);
  ledger.Resolve(1, PointOutcome::kSkipped);
  EXPECT_EQ(ledger.count(PointState::kMade), 1u);
  EXPECT_EQ(ledger.count(PointState::kSkipped), 1u);
  EXPECT_EQ(ledger.count(PointState::kArmed), 1u);
  EXPECT_EQ(ledger.count(PointState::kPlanned), 2u);
  EXPECT_FALSE(ledger.all_ended());
}

TEST(PointLedger, NoPointThatMayHaveFiredIsArmedAgain) {
  for (const PointOutcome outcome :
       {PointOutcome::kMade, PointOutcome::kMissed, PointOutcome::kUncertain}) {
    PointLedger ledger(1);
    ledger.Arm(0);
    ledger.Resolve(0, outcome);
    EXPECT_FALSE(ledger.NextOpen(0).has_value());
    EXPECT_TRUE(ledger.all_ended());
    EXPECT_THROW(ledger.Arm(0), PreconditionError);
  }
}

TEST(PointLedger, ArmedPointIsNotArmedTwice) {
  PointLedger ledger(2);
  ledger.Arm(0);
  EXPECT_THROW(ledger.Arm(0), PreconditionError);
  EXPECT_EQ(ledger.NextOpen(0), 1u);
}

TEST(PointLedger, SkippedPointIsOpenAgain) {
  PointLedger ledger(3);
  for (std::uint32_t i = 0; i < 3; ++i) ledger.Arm(i);
  ledger.Resolve(0, PointOutcome::kMade);
  ledger.Resolve(1, PointOutcome::kSkipped);
  ledger.Resolve(2, PointOutcome::kMade);
  EXPECT_EQ(ledger.NextOpen(0), 1u);
  EXPECT_FALSE(ledger.NextOpen(2).has_value());
  ledger.Arm(1);
  ledger.Resolve(1, PointOutcome::kMade);
  EXPECT_TRUE(ledger.all_ended());
}

TEST(PointLedger, AnUncertainPointIsOpenAgainByAConsentAlone) {
  PointLedger ledger(2);
  EXPECT_THROW(ledger.Reopen(0), PreconditionError) << "planned";
  ledger.Arm(0);
  EXPECT_THROW(ledger.Reopen(0), PreconditionError) << "armed";
  ledger.Resolve(0, PointOutcome::kUncertain);
  EXPECT_EQ(ledger.NextOpen(0), 1u);
  ledger.Reopen(0);
  EXPECT_EQ(ledger.NextOpen(0), 0u);
  EXPECT_EQ(ledger.count(PointState::kUncertain), 0u);
  ledger.Arm(0);
  ledger.Resolve(0, PointOutcome::kMade);
  EXPECT_THROW(ledger.Reopen(0), PreconditionError) << "made";
  EXPECT_EQ(ledger.NextOpen(0), 1u);
}

// It stays unknown as before, until it is fired.
TEST(PointLedger, AReopenedPointIsUncertainUntilItIsFired) {
  PointLedger ledger(3);
  for (std::uint32_t i = 0; i < 3; ++i) ledger.Arm(i);
  ledger.Resolve(0, PointOutcome::kUncertain);
  ledger.Resolve(1, PointOutcome::kUncertain);
  ledger.Resolve(2, PointOutcome::kSkipped);
  EXPECT_EQ(ledger.unknown_count(), 0u);
  ledger.Reopen(0);
  ledger.Reopen(1);
  EXPECT_EQ(ledger.unknown_count(), 2u);
  ledger.Arm(0);
  EXPECT_EQ(ledger.unknown_count(), 1u);
  ledger.Resolve(0, PointOutcome::kSkipped);
  EXPECT_EQ(ledger.unknown_count(), 2u);
  ledger.LeaveOut(0);
  EXPECT_EQ(ledger.unknown_count(), 2u);
  ledger.Arm(1);
  ledger.Resolve(1, PointOutcome::kMade);
  EXPECT_EQ(ledger.unknown_count(), 1u);
}

TEST(PointLedger, ResolvesOnlyWhatIsArmed) {
  PointLedger ledger(1);
  EXPECT_THROW(ledger.Resolve(0, PointOutcome::kMade), PreconditionError);
  ledger.Arm(0);
  EXPECT_THROW(ledger.Resolve(0, PointOutcome::kNone), PreconditionError);
}

}  // namespace
}  // namespace intaglio::cell
