#include "services/sorter/order_memo.h"

#include <gtest/gtest.h>

#include <vector>

namespace intaglio::sorter {
namespace {

TEST(OrderMemo, KeepsTheNewestOrders) {
  OrderMemo memo(10);
  memo.Keep("a", {3, 1, 2, 0});
  memo.Keep("b", {0, 1, 2});
  EXPECT_EQ(memo.Find("a"), (sort::Order{3, 1, 2, 0}));
  memo.Keep("c", {4, 3, 2, 1, 0});
  EXPECT_EQ(memo.Find("b"), std::nullopt) << "used the longest ago";
  EXPECT_TRUE(memo.Find("a"));
  EXPECT_TRUE(memo.Find("c"));
  memo.Keep("large", sort::Order(11));
  EXPECT_FALSE(memo.Find("large"));
  EXPECT_TRUE(memo.Find("a"));
  memo.Keep("", {0});
  EXPECT_FALSE(memo.Find("")) << "an order that depends on more than its key";
}

TEST(OrderKey, DiffersWithAllThatAnOrderDependsOn) {
  FrozenJob job;
  job.mutable_job()->set_name("first");
  job.mutable_job()->mutable_ordering()->mutable_anneal()->set_seed(1);
  const PointList points_mm{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<ChannelMask> masks(3, ChannelMask{1});
  const std::string key = OrderKey(job, points_mm, masks);
  EXPECT_EQ(OrderKey(job, points_mm, masks), key);

  FrozenJob renamed = job;
  renamed.mutable_job()->set_name("second");
  EXPECT_EQ(OrderKey(renamed, points_mm, masks), key);

  PointList moved_mm = points_mm;
  moved_mm[1].x() += 1e-9;
  EXPECT_NE(OrderKey(job, moved_mm, masks), key);
  std::vector<ChannelMask> other_masks = masks;
  other_masks[2] = ChannelMask{2};
  EXPECT_NE(OrderKey(job, points_mm, other_masks), key);
  FrozenJob faster = job;
  faster.mutable_job()->mutable_laser()->set_rate_hz(200);
  EXPECT_NE(OrderKey(faster, points_mm, masks), key);
  FrozenJob by_time = job;
  by_time.mutable_job()->mutable_ordering()->mutable_anneal()->set_time_s(1);
  EXPECT_EQ(OrderKey(by_time, points_mm, masks), "");
}

}  // namespace
}  // namespace intaglio::sorter
