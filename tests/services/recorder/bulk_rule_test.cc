#include "services/recorder/bulk_rule.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/platform/recording/mcap_reader.h"
#include "services/recorder/recording_series.h"
#include "tests/test_folder.h"

namespace intaglio::recorder {
namespace {

using recording::Bulk;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(BulkRule, KeepsEverythingUnlessItIsAskedToLeaveOut) {
  BulkRule all(Bulk::kAll);
  for (int i = 0; i < 30; ++i) {
    for (const char* topic : {"PointBatch", "JobStatus", "ModelChunk"}) {
      EXPECT_TRUE(all.Takes(topic));
      EXPECT_TRUE(all.Keeps(topic, 1));
    }
  }
  EXPECT_THAT(recording::EntriesOf(all.request()), IsEmpty());
  EXPECT_EQ(recording::SentenceOf(all.request()), "");
}

TEST(BulkRule, OfNoneLeavesOutWhatGrowsWithThePointsAndNothingElse) {
  BulkRule none(Bulk::kNone);
  for (const char* topic : {"ModelChunk", "PointBatch", "PathBatch", "MotionSegmentBatch",
                            "PositionReport"}) {
    EXPECT_FALSE(none.Takes(topic)) << topic;
  }
  for (const char* topic : {"JobStatus", "PulseEventBatch", "Permission", "MotionState",
                            "EmergencyStop", "Interlock", "EngraveTask"}) {
    EXPECT_TRUE(none.Takes(topic)) << topic;
    EXPECT_TRUE(none.Keeps(topic, 7)) << topic;
  }
}

TEST(BulkRule, OfThinKeepsTheFirstOfTenMessagesOfEachChannel) {
  BulkRule thin(Bulk::kThin);
  EXPECT_FALSE(thin.Takes("ModelChunk")) << "a part of a file is of no use";
  int kept = 0;
  for (int i = 0; i < 95; ++i) {
    const bool keeps = thin.Keeps("PointBatch", 3);
    EXPECT_EQ(keeps, i % 10 == 0) << i;
    kept += keeps ? 1 : 0;
    EXPECT_TRUE(thin.Keeps("PulseEventBatch", 4));
  }
  EXPECT_EQ(kept, 10);
  EXPECT_TRUE(thin.Keeps("PositionReport", 5)) << "the first of another channel";
  EXPECT_FALSE(thin.Keeps("PositionReport", 5));
}

// Whoever has the file alone learns from it what is not there.
TEST(BulkRule, IsInTheMetadataOfEveryFile) {
  SeriesOptions options;
  options.file = test::FreshFolder() / "s.mcap";
  options.bulk = BulkRule(Bulk::kThin).request();
  auto series = RecordingSeries::Open(options, 0).value();
  ASSERT_TRUE(series.Close());
  const auto reader = recording::McapReader::Open(options.file).value();
  const recording::BulkRequest read = recording::BulkRequestOf(reader);
  EXPECT_EQ(read.bulk, Bulk::kThin);
  EXPECT_EQ(read.left_out, options.bulk.left_out);
  EXPECT_EQ(read.thinned, options.bulk.thinned);
  EXPECT_EQ(read.one_of, 10u);
  EXPECT_THAT(recording::SentenceOf(read),
              AllOf(HasSubstr("leaves out bulk topics by request (--bulk thin): "
                              "ModelChunk"),
                    HasSubstr("one message in 10"), HasSubstr("MotionSegmentBatch")));
}

}  // namespace
}  // namespace intaglio::recorder
