#include "services/host/stop_latch.h"

#include <gtest/gtest.h>

namespace intaglio::host {
namespace {

TEST(StopLatch, IsReleasedOnlyByAHigherNumber) {
  StopLatch stop;
  EXPECT_FALSE(stop.pressed());
  EXPECT_TRUE(stop.Take(true, 5));
  EXPECT_FALSE(stop.Take(true, 5)) << "repeated";
  for (const std::uint64_t number : {0u, 4u, 5u}) {
    stop.Take(false, number);
    EXPECT_TRUE(stop.pressed()) << number;
  }
  stop.Take(false, 6);
  EXPECT_FALSE(stop.pressed());
}

TEST(StopLatch, EveryPressCountsAndTheHighestHasToBeReset) {
  StopLatch stop;
  stop.Take(true, 9);
  stop.Take(true, 3);
  EXPECT_EQ(stop.number(), 9u);
  stop.Take(false, 8);
  EXPECT_TRUE(stop.pressed());
  stop.Take(false, 10);
  EXPECT_FALSE(stop.pressed());
  // Retained from an earlier day: it stops all the same.
  EXPECT_TRUE(stop.Take(true, 2));
  EXPECT_TRUE(stop.pressed());
}

TEST(StopLatch, AResetThatComesFirstIsNoAdvance) {
  StopLatch stop;
  stop.Take(false, 100);
  EXPECT_FALSE(stop.pressed());
  stop.Take(true, 1);
  EXPECT_TRUE(stop.pressed());
}

}  // namespace
}  // namespace intaglio::host
