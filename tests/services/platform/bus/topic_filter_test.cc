#include "services/platform/bus/topic_filter.h"

#include <gtest/gtest.h>

namespace intaglio::bus {
namespace {

TEST(TopicFilter, APartitionOfEveryMachineIsRecordedWithEach) {
  TopicFilter filter;
  filter.partition.only = {"els-03"};
  EXPECT_TRUE(filter.Accepts("EmergencyStop", "*", "t"));
  EXPECT_TRUE(filter.Accepts("EmergencyStop", "els-03", "t"));
  EXPECT_FALSE(filter.Accepts("EmergencyStop", "els-04", "t"));
}

TEST(TopicFilter, PatternsSelect) {
  TopicFilter filter;
  EXPECT_TRUE(filter.Accepts("JobStatus", "", "intaglio::JobStatus"));
  filter.topic.only = {"Job*", "Alarm"};
  filter.topic.not_ = {"JobCommand"};
  filter.partition.not_ = {"cell-2"};
  EXPECT_TRUE(filter.Accepts("JobStatus", "", "t"));
  EXPECT_TRUE(filter.Accepts("Alarm", "cell-1", "t"));
  EXPECT_FALSE(filter.Accepts("Alarm", "cell-2", "t"));
  EXPECT_TRUE(filter.Accepts("Alarm", "cell-2,cell-3", "t"));
  EXPECT_FALSE(filter.Accepts("JobCommand", "", "t"));
  EXPECT_FALSE(filter.Accepts("Credit", "", "t"));
  // The partition of a role is not that of a cell.
  filter.partition.only = {"cell-1"};
  EXPECT_FALSE(filter.Accepts("Alarm", "cell-3", "t"));
  EXPECT_TRUE(filter.Accepts("Alarm", "role/stage-worker", "t"));
}

}  // namespace
}  // namespace intaglio::bus
