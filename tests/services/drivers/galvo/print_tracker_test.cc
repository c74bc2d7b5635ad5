// Print marks and repeats, against rows of places that are written here.

#include "services/drivers/galvo/print_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::drivers {
namespace {

using PrintState = PrintTracker::State;
using ::testing::HasSubstr;

constexpr PrintEye kTrackedEye{.pitch_mm = 30, .tolerance_mm = 2, .max_missing = 2};

/// A print of 30 mm was seen at 0, and a run begins at 10.
PrintTracker BegunAt10(const PrintEye& eye = kTrackedEye) {
  PrintTracker tracker;
  tracker.See(0);
  tracker.PassTo(10);
  tracker.Begin(eye);
  return tracker;
}

TEST(PrintTracker, GivesEachRepeatItsOwnPrintMark) {
  PrintTracker tracker = BegunAt10();
  EXPECT_EQ(tracker.StateOf(0), PrintState::kAwaited);
  const double places[] = {30, 61.5, 90, 119, 150.9};
  for (const double place : places) tracker.See(place);
  for (std::uint32_t i = 0; i < 5; ++i) {
    ASSERT_EQ(tracker.StateOf(i), PrintState::kSeen) << i;
    EXPECT_EQ(tracker.PlaceOf(i), places[i]) << i;
  }
  EXPECT_EQ(tracker.StateOf(5), PrintState::kAwaited);
  EXPECT_EQ(tracker.ignored_count(), 0u);
}

TEST(PrintTracker, UsesNothingThatWasSeenBeforeTheRun) {
  PrintTracker tracker;
  for (const double place : {0.0, 30.0, 60.0}) tracker.See(place);
  tracker.Begin(kTrackedEye);
  // It had passed by then, and was reported later.
  tracker.See(90, false);
  EXPECT_EQ(tracker.StateOf(0), PrintState::kAwaited);
  tracker.See(120);
  EXPECT_EQ(tracker.PlaceOf(0), 120);
}

// Dirt that comes first is no print mark: nothing lies a pitch before it.
TEST(PrintTracker, FindsThePrintBehindDirt) {
  PrintTracker tracker;
  tracker.Begin(kTrackedEye);
  tracker.See(5);
  tracker.See(12);
  EXPECT_EQ(tracker.StateOf(0), PrintState::kAwaited);
  tracker.See(42);
  EXPECT_EQ(tracker.PlaceOf(0), 42);
}

TEST(PrintTracker, IgnoresWhatLiesElsewhere) {
  PrintTracker tracker = BegunAt10();
  for (const double place : {30.0, 41.0, 57.9, 60.0, 61.0, 90.0}) tracker.See(place);
  EXPECT_EQ(tracker.PlaceOf(1), 60);
  EXPECT_EQ(tracker.PlaceOf(2), 90);
  EXPECT_EQ(tracker.ignored_count(), 3u);
}

TEST(PrintTracker, LeavesOutARepeatWhosePrintMarkIsMissing) {
  PrintTracker tracker = BegunAt10();
  tracker.See(30);
  tracker.PassTo(61.9);
  EXPECT_EQ(tracker.StateOf(1), PrintState::kAwaited);
  tracker.PassTo(62.1);
  EXPECT_EQ(tracker.StateOf(1), PrintState::kMissing);
  EXPECT_EQ(tracker.StateOf(2), PrintState::kAwaited);
  tracker.See(91);
  EXPECT_EQ(tracker.PlaceOf(2), 91);
  tracker.See(121.5);
  EXPECT_EQ(tracker.PlaceOf(3), 121.5);
}

TEST(PrintTracker, IsLostBehindMoreMissingThanMayBe) {
  PrintTracker tracker = BegunAt10();
  tracker.See(30);
  tracker.PassTo(122);
  EXPECT_EQ(tracker.StateOf(2), PrintState::kMissing);
  EXPECT_EQ(tracker.StateOf(3), PrintState::kAwaited);
  tracker.PassTo(122.1);
  EXPECT_EQ(tracker.StateOf(0), PrintState::kSeen);
  EXPECT_EQ(tracker.StateOf(2), PrintState::kMissing);
  EXPECT_EQ(tracker.StateOf(3), PrintState::kLost);
  EXPECT_THAT(
      tracker.LossText(),
      HasSubstr("3 print marks missing in a row, and "
                "marks.web.eye.max_missing is 2; the last one was that of repeat 1"));
  // Nothing begins at what comes later, before another run.
  tracker.See(150);
  EXPECT_EQ(tracker.StateOf(4), PrintState::kLost);
  PrintEye again = kTrackedEye;
  again.first_repeat = 3;
  tracker.Begin(again);
  tracker.See(180);
  EXPECT_EQ(tracker.PlaceOf(3), 180);
}

TEST(PrintTracker, IsLostWithoutAnyPrint) {
  PrintTracker tracker;
  tracker.Begin(kTrackedEye);
  tracker.PassTo(150);
  EXPECT_EQ(tracker.StateOf(0), PrintState::kAwaited);
  tracker.PassTo(151);
  EXPECT_EQ(tracker.StateOf(0), PrintState::kLost);
  EXPECT_THAT(tracker.LossText(), HasSubstr("no print mark 30 mm behind another one"));
}

}  // namespace
}  // namespace intaglio::drivers
