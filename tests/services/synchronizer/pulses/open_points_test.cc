#include "services/synchronizer/pulses/open_points.h"

#include <gtest/gtest.h>

#include <random>

#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;

void End(PointLedger& ledger, std::uint32_t point, PointOutcome outcome) {
  ledger.Arm(point);
  ledger.Resolve(point, outcome);
}

TEST(OpenPoints, AreTheOrderWhileNothingWasPassedBy) {
  const PointList points = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
  PointLedger ledger(3);
  OpenPoints open(points, ledger, 0.2);
  EXPECT_EQ(open.Next(), 0u);
  EXPECT_EQ(open.Next(), 1u);
  EXPECT_EQ(open.Next(), 2u);
  EXPECT_EQ(open.Next(), std::nullopt);
  open.Rewind();
  EXPECT_EQ(open.Next(), 0u);
}

TEST(OpenPoints, OneUnderALaterCrackStaysOpen) {
  const PointList points = {{0, 0, 0}, {1, 0, 0}, {0, 0.1, 1}};
  for (const auto outcome :
       {PointOutcome::kMade, PointOutcome::kMissed, PointOutcome::kUncertain}) {
    PointLedger ledger(3);
    End(ledger, 0, PointOutcome::kSkipped);
    End(ledger, 1, PointOutcome::kSkipped);
    End(ledger, 2, outcome);
    OpenPoints open(points, ledger, 0.2);
    EXPECT_EQ(open.Next(), 1u);
    EXPECT_EQ(open.Next(), std::nullopt);
    // In a narrower beam it is free.
    OpenPoints narrow(points, ledger, 0.09);
    EXPECT_EQ(narrow.Next(), 0u);
  }
}

TEST(OpenPoints, ARunEndsWhereTheChannelsChange) {
  const PointList points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const std::vector<ChannelMask> masks = {1, 1, 2, 1};
  PointLedger ledger(4);
  OpenPoints open(points, ledger, 0.2, masks);
  open.Rewind();
  EXPECT_EQ(open.mask(), 1);
  EXPECT_EQ(open.Next(), 0u);
  EXPECT_EQ(open.Next(), 1u);
  EXPECT_EQ(open.Next(), std::nullopt);
  EXPECT_EQ(open.Next(), std::nullopt) << "and does not pass over the change";
  End(ledger, 0, PointOutcome::kMade);
  End(ledger, 1, PointOutcome::kMade);
  open.Rewind();
  EXPECT_EQ(open.mask(), 2);
  EXPECT_EQ(open.Next(), 2u);
  EXPECT_EQ(open.Next(), std::nullopt);
  for (const std::uint32_t point : {2, 3}) End(ledger, point, PointOutcome::kMade);
  open.Rewind();
  EXPECT_EQ(open.mask(), 0);
  EXPECT_EQ(open.Next(), std::nullopt);
}

TEST(OpenPoints, OnlyCracksOfItsOwnChannelsAreInTheWay) {
  const PointList points = {{0, 0, 0}, {0, 0, 1}};
  for (const ChannelMask later : {ChannelMask{2}, ChannelMask{3}}) {
    const std::vector<ChannelMask> masks = {1, later};
    PointLedger ledger(2);
    End(ledger, 1, PointOutcome::kMade);
    OpenPoints open(points, ledger, 0.2, masks);
    open.Rewind();
    EXPECT_EQ(open.Next().has_value(), later == 2);
  }
}

// Whatever is skipped in whatever passes: what is made in the end has no violation, by
// the independent checker.
TEST(OpenPoints, RandomSkipsNeverLeadThroughACrack) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const double tangent = 0.5;
  for (int trial = 0; trial < 50; ++trial) {
    PointList cloud;
    for (int i = 0; i < 300; ++i) {
      cloud.emplace_back(2 * unit(random), 2 * unit(random), 2 * unit(random));
    }
    PointList points;
    const auto order = sort::MakeOrder(cloud, {}, {});
    ASSERT_TRUE(order.has_value());
    for (const std::uint32_t i : *order) points.push_back(cloud[i]);
    PointLedger ledger(points.size());
    OpenPoints open(points, ledger, tangent);
    PointList made;
    for (int pass = 0; pass < 6; ++pass) {
      open.Rewind();
      while (const auto point = open.Next()) {
        const bool skip = unit(random) < 0.2;
        End(ledger, *point, skip ? PointOutcome::kSkipped : PointOutcome::kMade);
        if (!skip) made.push_back(points[*point]);
      }
    }
    EXPECT_EQ(sort::CountShadowViolationsBruteForce(made, tangent), 0u);
    EXPECT_GT(made.size(), 200u);
  }
}

}  // namespace
}  // namespace intaglio::synchronizer
