// What `submit --watch` and `watch` say of a job beside its bar.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/cli/watch_job.h"
#include "services/client/job_need.h"
#include "tests/services/cli/status/shown_job.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A synchronizer's words (tests/services/cell/permission_chain_test.cc).
constexpr char kNoPermission[] = "waits for the permission of the job service";

// The synchronizer sees the permission later than a person's arm is taken.
TEST(WatchNote, AnArmedJobWaitsForNoArm) {
  client::JobView job = ShownJob(7, intaglio_JOB_WAITING_FOR_ARM);
  job.message = kNoPermission;
  job.armed = true;
  const std::string note = NoteOf(job);
  EXPECT_EQ(note, "armed, waits for the permission of the job service");
  EXPECT_THAT(client::StateOf(job), Not(HasSubstr("arm (")));
}

TEST(WatchNote, IsWhatStatusAsksAPersonFor) {
  client::JobView job = ShownJob(7, intaglio_JOB_WAITING_FOR_ARM);
  job.message = kNoPermission;
  ASSERT_FALSE(client::NeedOf(job).empty());
  EXPECT_EQ(NoteOf(job), client::NeedOf(job));
  job.state = intaglio_JOB_PAUSED;
  job.message = "the door was opened";
  EXPECT_EQ(NoteOf(job),
            "job 7 is paused: the door was opened (intaglio resume 7, or cancel)");
  job.armed = true;
  EXPECT_EQ(NoteOf(job), "paused: armed, the door was opened");
}

TEST(WatchNote, HasTheAlarmAndTheSpeed) {
  client::JobView job = ShownJob(7, intaglio_JOB_ENGRAVING);
  job.message = "at work";
  job.alarm = "no progress";
  job.speed_percent = 50;
  EXPECT_EQ(NoteOf(job), "at work; ALARM no progress, at 50 % speed");
}

}  // namespace
}  // namespace intaglio::cli
