#include "services/cell/machine_watch.h"

#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "services/cell/permission_chain.h"
#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::cell {
namespace {

using namespace std::chrono_literals;
using Sight = MachineWatch::Sight;

constexpr MachineCounters kFirst{7, 2};

Sight Seen(const MachineCounters& counters) { return {true, true, counters, true}; }

TEST(MachineWatch, TheFirstCountersOfAProcessAreNoOldAcquaintance) {
  MachineWatch watch;
  EXPECT_EQ(watch.Update({}, 1s), UnseenEvent::kNone) << "the line is not up yet";
  EXPECT_EQ(watch.Update(Seen(kFirst), 2s), UnseenEvent::kNotWatched);
  EXPECT_EQ(watch.Update(Seen(kFirst), 3s), UnseenEvent::kNone);
  EXPECT_EQ(watch.counters(), kFirst);
}

TEST(MachineWatch, AnOpeningIsNoticedOnceItIsClosedAgain) {
  MachineWatch watch;
  watch.Expect(kFirst);
  EXPECT_EQ(watch.Update(Seen({7, 3}), 1s), UnseenEvent::kOpened);
  EXPECT_EQ(watch.Update(Seen({7, 3}), 2s), UnseenEvent::kNone);
  // Open at this moment: the interlock itself shows it.
  EXPECT_EQ(watch.Update({true, false, {7, 4}, true}, 3s), UnseenEvent::kNone);
  EXPECT_EQ(watch.Update(Seen({7, 4}), 4s), UnseenEvent::kNone);
}

TEST(MachineWatch, AnotherPowerUpIsAnEventWhateverItsCount) {
  for (const std::uint32_t openings : {0u, 2u, 5u}) {
    MachineWatch watch;
    watch.Expect(kFirst);
    EXPECT_EQ(watch.Update({false, true, {}, true}, 1s), UnseenEvent::kNone);
    EXPECT_EQ(watch.Update(Seen({8, openings}), 2s), UnseenEvent::kPowerCycle);
    EXPECT_EQ(watch.Update(Seen({8, openings}), 3s), UnseenEvent::kNone);
  }
}

TEST(MachineWatch, NoCountersInTheJournalMeanThatNobodyKnows) {
  MachineWatch watch;
  watch.Expect(kFirst);
  EXPECT_EQ(watch.Update(Seen(kFirst), 1s), UnseenEvent::kNone);
  watch.Expect({});
  EXPECT_EQ(watch.Update(Seen(kFirst), 2s), UnseenEvent::kNotWatched);
}

TEST(MachineWatch, SilenceBeyondTheLimitIsAnEventAsLongAsItLasts) {
  for (const bool laser : {true, false}) {
    MachineWatch watch;
    watch.Expect(kFirst);
    Sight silent = Seen(kFirst);
    (laser ? silent.laser_line_up : silent.motion_seen) = false;
    const UnseenEvent away = laser ? UnseenEvent::kLaserAway : UnseenEvent::kMotionAway;
    EXPECT_EQ(watch.Update(silent, 10s), UnseenEvent::kNone);
    EXPECT_EQ(watch.Update(silent, 10s + host::kMaxAbsence), UnseenEvent::kNone);
    EXPECT_EQ(watch.Update(silent, 11s + host::kMaxAbsence), away);
    EXPECT_EQ(watch.Update(silent, 12s + host::kMaxAbsence), away);
    EXPECT_EQ(watch.Update(Seen(kFirst), 100s), UnseenEvent::kNone);
    EXPECT_EQ(watch.Update(silent, 200s), UnseenEvent::kNone) << "it begins anew";
  }
}

// 25 s away, 1 s back, 25 s away: nobody has watched the block for 50 s.
TEST(MachineWatch, SilencesAreAddedUpUntilItSpeaksForTheLimitWithoutAGap) {
  for (const bool laser : {true, false}) {
    Sight silent = Seen(kFirst);
    (laser ? silent.laser_line_up : silent.motion_seen) = false;
    const UnseenEvent away = laser ? UnseenEvent::kLaserAway : UnseenEvent::kMotionAway;
    for (const auto back : {1s, 29s, 30s}) {
      MachineWatch watch;
      watch.Expect(kFirst);
      EXPECT_EQ(watch.Update(silent, 10s), UnseenEvent::kNone);
      EXPECT_EQ(watch.Update(Seen(kFirst), 35s), UnseenEvent::kNone);
      EXPECT_EQ(watch.Update(silent, 35s + back), UnseenEvent::kNone);
      EXPECT_EQ(watch.Update(silent, 40s + back), UnseenEvent::kNone);
      EXPECT_EQ(watch.Update(silent, 41s + back),
                back < host::kMaxAbsence ? away : UnseenEvent::kNone);
    }
  }
}

TEST(MachineWatch, AnArmJudgesTheSilencesThatHaveEnded) {
  MachineWatch watch;
  watch.Expect(kFirst);
  Sight silent = Seen(kFirst);
  silent.laser_line_up = false;
  (void)watch.Update(silent, 10s);
  (void)watch.Update(Seen(kFirst), 35s);
  watch.AcceptSilences(36s);
  EXPECT_EQ(watch.Update(silent, 37s), UnseenEvent::kNone);
  watch.AcceptSilences(38s);
  EXPECT_EQ(watch.Update(silent, 67s), UnseenEvent::kNone);
  EXPECT_EQ(watch.Update(silent, 68s), UnseenEvent::kLaserAway) << "it lasts since 37 s";
}

// As the permission chain has it: a line that is lost twice costs the arm, though a
// person would not have been asked for either loss.
TEST(MachineWatch, TwoSilencesThatTogetherExceedTheLimitSpendTheGrant) {
  PermissionChain chain;
  ChainLinks whole;
  whole.permission_fresh = whole.permission_granted = whole.stop_not_pressed = true;
  whole.laser_line_up = whole.key_on = whole.door_closed = whole.stop_released = true;
  whole.motion_fresh = true;
  whole.counters = kFirst;
  chain.Watch(whole, 1s);
  whole.grant = {4, 0};
  EXPECT_EQ(chain.Turn(whole, 2s), Missing::kNothing);
  ChainLinks silent = whole;
  silent.laser_line_up = false;
  EXPECT_EQ(chain.Turn(silent, 10s), Missing::kNothing);
  EXPECT_EQ(chain.Turn(whole, 35s), Missing::kNothing);
  EXPECT_EQ(chain.Turn(silent, 36s), Missing::kNothing);
  EXPECT_EQ(chain.Turn(silent, 42s), Missing::kLaserAway);
  EXPECT_TRUE(chain.has_lost(whole.grant));
  // A greater grant does not inherit what was before it.
  chain.Turn(whole, 61s);
  whole.grant = {5, 0};
  chain.Turn(whole, 62s);
  silent.grant = whole.grant;
  EXPECT_EQ(chain.Turn(silent, 63s), Missing::kNothing);
  EXPECT_FALSE(chain.has_lost(whole.grant));
}

// Against a machine that is watched by an oracle that misses nothing: whatever happens
// while the line is down is an event at the first sight of it.
TEST(MachineWatch, NothingThatHappensOutOfSightIsMissed) {
  std::mt19937 random(3);
  for (int round = 0; round < 2000; ++round) {
    MachineWatch watch;
    MachineCounters machine{1, 0};
    watch.Expect(machine);
    bool happened = false;
    for (int turn = 0; turn < 50; ++turn) {
      const bool up = random() % 3 != 0;
      if (!up && random() % 4 == 0) {
        machine = random() % 2 == 0
                      ? MachineCounters{machine.power_up + 1, 0}
                      : MachineCounters{machine.power_up, machine.openings + 1};
        happened = true;
      }
      const UnseenEvent event =
          watch.Update({up, true, up ? machine : MachineCounters{}, true},
                       std::chrono::milliseconds(turn));
      ASSERT_EQ(event != UnseenEvent::kNone, up && happened) << "round " << round;
      if (up) happened = false;
    }
  }
}

}  // namespace
}  // namespace intaglio::cell
