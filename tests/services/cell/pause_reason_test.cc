#include "services/cell/pause_reason.h"

#include <gtest/gtest.h>

namespace intaglio::cell {
namespace {

TEST(PauseReason, OfWhatSpentAGrant) {
  EXPECT_EQ(PauseReasonOf(Missing::kNothing), intaglio_PAUSE_FAULT);
  EXPECT_EQ(PauseReasonOf(Missing::kEmergencyStop), intaglio_PAUSE_EMERGENCY_STOP);
  for (const Missing open : {Missing::kChain, Missing::kKey, Missing::kDoor,
                             Missing::kInput, Missing::kOpenedUnseen}) {
    EXPECT_EQ(PauseReasonOf(open), intaglio_PAUSE_INTERLOCK);
  }
  for (const Missing changed : {Missing::kPowerCycle, Missing::kNotWatched,
                                Missing::kLaserAway, Missing::kMotionAway}) {
    EXPECT_EQ(PauseReasonOf(changed), intaglio_PAUSE_MACHINE_CHANGED);
  }
}

// The job service lets a lost line go on by itself, and nothing else.
TEST(PauseReason, OnlyALostLineGoesOnByItself) {
  for (int bits = 0; bits < 8; ++bits) {
    const PausedEngraving paused{.faulted = (bits & 1) != 0,
                                 .lost_a_line = (bits & 2) != 0,
                                 .asks = (bits & 4) != 0,
                                 .spent_by = Missing::kDoor};
    const intaglio_PauseReason reason = PauseReasonOf(paused);
    EXPECT_EQ(reason == intaglio_PAUSE_NOT_ARMED, !paused.faulted) << bits;
    EXPECT_EQ(reason == intaglio_PAUSE_LINE_LOST, paused.faulted && paused.lost_a_line)
        << bits;
    EXPECT_EQ(reason == intaglio_PAUSE_UNCERTAIN_POINTS,
              paused.faulted && !paused.lost_a_line && paused.asks)
        << bits;
  }
}

}  // namespace
}  // namespace intaglio::cell
