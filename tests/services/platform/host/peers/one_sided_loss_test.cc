#include "services/platform/host/peers/one_sided_loss.h"

#include <gtest/gtest.h>

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;

const OneSidedLoss::Time kBegin{100s};

TEST(OneSidedLoss, LeavesNobodyWhoAnswers) {
  OneSidedLoss loss;
  for (auto t = 0ms; t < 60s; t += 200ms) EXPECT_FALSE(loss.Turn(true, kBegin + t));
}

// A dead peer is dropped after its lease; a late one acknowledges after all.
TEST(OneSidedLoss, AnAcknowledgementNowAndThenIsEnough) {
  OneSidedLoss loss;
  for (auto t = 0ms; t < 60s; t += 200ms) {
    EXPECT_FALSE(loss.Turn(t % 2800ms == 0ms, kBegin + t));
  }
}

TEST(OneSidedLoss, LeavesWhenNothingIsAcknowledgedAnyMore) {
  OneSidedLoss loss;
  EXPECT_FALSE(loss.Turn(true, kBegin));
  auto t = 0ms;
  while (!loss.Turn(false, kBegin + t)) {
    t += 200ms;
    ASSERT_LT(t, 10s);
  }
  EXPECT_GE(t, OneSidedLoss::kNotice);
  EXPECT_LE(t, OneSidedLoss::kNotice + 200ms);
  // Away, and then as long again: the other one may still be behind a cut cable.
  const auto left = t;
  do {
    t += 200ms;
    ASSERT_LT(t, 20s);
  } while (!loss.Turn(false, kBegin + t));
  EXPECT_GE(t - left, OneSidedLoss::kAway + OneSidedLoss::kNotice);
}

// A peer that acknowledges nothing at all costs an absence now and then.
TEST(OneSidedLoss, WhoIsNotCuredByItIsLeftEverMoreRarely) {
  OneSidedLoss loss;
  int left = 0;
  for (auto t = 0ms; t < 1h; t += 200ms) left += loss.Turn(t == 0ms, kBegin + t) ? 1 : 0;
  // 3, 6, 12, 24, 48 s, and then a minute each, besides the absences.
  EXPECT_LE(left, 5 + 3600 / 62);
  EXPECT_GE(left, 50);
  // Who acknowledged in between is missed as soon as at first.
  const auto again = kBegin + 2h;
  EXPECT_FALSE(loss.Turn(true, again));
  EXPECT_FALSE(loss.Turn(false, again + 2900ms));
  EXPECT_TRUE(loss.Turn(false, again + OneSidedLoss::kNotice));
}

}  // namespace
}  // namespace intaglio::host
