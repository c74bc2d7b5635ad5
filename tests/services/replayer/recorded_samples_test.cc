#include "services/replayer/recorded_samples.h"

#include <gtest/gtest.h>

#include "proto/task.pb.h"
#include "tests/services/replayer/golden.h"

namespace intaglio::replayer {
namespace {

TEST(RecordedSamples, TasksHoldTheFrozenJob) {
  const auto reader = Golden("pyramid.mcap");
  RecordedValues values(reader, "SortTask");
  const auto value = values.Next();
  ASSERT_TRUE(value && *value);
  const auto task = ReadTask(**value);
  ASSERT_TRUE(task);
  FrozenJob job;
  ASSERT_TRUE(job.ParseFromString(task->frozen_job));
  EXPECT_EQ(job.job_uid(), task->id.job_uid);
  EXPECT_EQ(job.job().name(), "pyramid");
}

// The run that was recorded proved 272 points (its README describes how it was made).
TEST(RecordedSamples, PointsComeTogether) {
  const auto reader = Golden("pyramid.mcap");
  for (const char* topic : {"PointBatch", "PathBatch"}) {
    std::size_t points = 0;
    RecordedValues values(reader, topic);
    for (auto value = values.Next(); value && *value; value = values.Next()) {
      const auto batch = ReadBatch(**value);
      ASSERT_TRUE(batch);
      EXPECT_EQ(batch->first_index, points);
      points += batch->x_mm.size();
      EXPECT_EQ(batch->last, points == batch->total_count);
    }
    EXPECT_EQ(points, 272u) << topic;
  }
}

TEST(RecordedSamples, ExtentsReportWhichStreamsAreWhole) {
  const auto reader = Golden("two_makers.mcap");
  const auto extents = ExtentsOf(reader, "PointBatch");
  ASSERT_TRUE(extents);
  EXPECT_EQ(extents->size(), 16u);  // eight parts for each of two discretizers
  for (const auto& [id, extent] : *extents) EXPECT_TRUE(extent.whole) << id.part;
}

}  // namespace
}  // namespace intaglio::replayer
