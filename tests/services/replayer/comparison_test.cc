#include "services/replayer/comparison.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::replayer {
namespace {

CloudBatch Batch() {
  CloudBatch batch;
  batch.id = {"7-aa", 1, 2, 0};
  batch.sequence_number = 3;
  batch.first_index = 3 * 8192;
  batch.total_count = 30000;
  batch.x_mm = {1, 2, 3};
  batch.y_mm = {4, 5, 6};
  batch.z_mm = {7, 8, 9};
  batch.source = {0, 0, 1};
  return batch;
}

TEST(Comparison, EqualBatchesHaveNoDifference) {
  const CloudBatch then = Batch(), now = Batch();
  EXPECT_FALSE(Compare(&then, &now));
}

TEST(Comparison, OneBitIsADifferenceAndItsPlaceIsNamed) {
  const CloudBatch then = Batch();
  CloudBatch now = Batch();
  now.y_mm[1] = std::nextafter(5.0, 6.0);
  now.x_mm[2] = 0;
  const auto found = Compare(&then, &now);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->member(), "y_mm");
  EXPECT_EQ(found->batch(), 3u);
  EXPECT_EQ(found->index(), 1u);
  EXPECT_EQ(found->point(), 3u * 8192 + 1);
  EXPECT_EQ(found->then(), "5");
  EXPECT_EQ(found->now(), "5.000000000000001");
  EXPECT_EQ(found->part(), 2u);
}

// -0 and 0 are equal numbers and other bits: the next stage may distinguish them.
TEST(Comparison, ZerosOfOtherSignDiffer) {
  CloudBatch then = Batch(), now = Batch();
  then.x_mm[0] = 0.0;
  now.x_mm[0] = -0.0;
  EXPECT_TRUE(Compare(&then, &now));
}

TEST(Comparison, CountsAndMissingBatchesAreDifferences) {
  const CloudBatch then = Batch();
  CloudBatch now = Batch();
  now.total_count = 29999;
  EXPECT_EQ(Compare(&then, &now)->member(), "total_count");
  EXPECT_EQ(Compare(nullptr, &now)->then(), "none");
  EXPECT_EQ(Compare(&then, nullptr)->now(), "none");
}

}  // namespace
}  // namespace intaglio::replayer
