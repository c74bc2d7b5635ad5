#include "services/cell/work_clock.h"

#include <gtest/gtest.h>

namespace intaglio::cell {
namespace {

using namespace std::chrono_literals;

TEST(WorkClock, WhatAJobWaitsForIsNotWork) {
  WorkClock clock;
  clock.Begin(10s);
  clock.Turn(12s, true, 0);
  clock.Turn(50s, false, 20);
  clock.Turn(51s, true, 20);
  EXPECT_DOUBLE_EQ(clock.ElapsedSeconds(30), 3);
}

// 15 000 of 30 000 were made before: by the bare time of this process 4 s would be left
// of 300 behind its first 300 points.
TEST(WorkClock, WhatAnEarlierProcessMadeCountsAtThePaceOfThisOne) {
  WorkClock clock;
  clock.Begin(0s);
  EXPECT_EQ(clock.ElapsedSeconds(15000), 0);
  clock.Turn(1s, false, 15000);
  clock.Turn(2s, true, 15000);
  EXPECT_EQ(clock.ElapsedSeconds(15000), 0) << "its pace is not known yet";
  clock.Turn(4s, true, 15300);
  EXPECT_DOUBLE_EQ(clock.ElapsedSeconds(15300), 3.0 * 15300 / 300);
}

}  // namespace
}  // namespace intaglio::cell
