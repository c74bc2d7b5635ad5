#include "services/cli/status/job_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/client/job_need.h"
#include "tests/services/cli/status/shown_job.h"

namespace intaglio::cli {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

client::JobView NotGood() {
  client::JobView job = ShownJob(7, intaglio_JOB_DONE);
  job.verdict = "not_good";
  job.counts = {1240, 1234, 4, 2, 0, 0, 0};
  return job;
}

TEST(JobText, AnEndedJobHasItsVerdictItsCountsAndTheReason) {
  const std::string line = ListText({NotGood()});
  EXPECT_THAT(line, ContainsRegex("7  done +left +not_good .*made 1 234 / 1 240 +duck"));
  EXPECT_THAT(line, HasSubstr("of 1240 points 4 missed, 2 skipped"));
  const std::string shown = ShowText(NotGood());
  EXPECT_THAT(shown, HasSubstr("verdict    not_good"));
  EXPECT_THAT(shown,
              HasSubstr("points     1 240 planned, 1 234 made, 4 missed, 2 skipped"));
  EXPECT_THAT(shown, HasSubstr("reason     of 1240 points 4 missed, 2 skipped"));
}

TEST(JobText, WhatWaitsIsInItsOrderBehindTheOthers) {
  std::vector<client::JobView> jobs;
  for (const std::uint32_t number : {1, 2, 3, 4})
    jobs.push_back(ShownJob(number, intaglio_JOB_QUEUED));
  jobs[0].queue_place = 3;
  jobs[1].queue_place = 1;
  jobs[3].queue_place = 2;
  jobs[2].state = intaglio_JOB_ENGRAVING;
  EXPECT_THAT(ListText(jobs), ContainsRegex("3  engraving .*\n(.*\n)*"
                                            " +2  queued, place 1 .*\n(.*\n)*"
                                            " +4  queued, place 2 .*\n(.*\n)*"
                                            " +1  queued, place 3 "));
  EXPECT_THAT(ShowText(jobs[0]), HasSubstr("queue      place 3\n"));
  EXPECT_THAT(ShowText(jobs[2]), Not(HasSubstr("queue")));
}

TEST(JobText, AGoodJobHasNoReason) {
  client::JobView job = ShownJob(7, intaglio_JOB_DONE);
  job.verdict = "good";
  job.counts = {1240, 1240, 0, 0, 0, 0, 0};
  EXPECT_THAT(ShowText(job), HasSubstr("verdict    good"));
  EXPECT_THAT(ShowText(job), Not(HasSubstr("reason")));
}

TEST(JobText, AJobThatFailedOrWasCancelledHasItsMessage) {
  client::JobView job = ShownJob(7, intaglio_JOB_FAILED);
  job.verdict = "none";
  job.message = "the model is open";
  EXPECT_THAT(ListText({job}), HasSubstr("        the model is open\n"));
  EXPECT_THAT(ShowText(job), HasSubstr("reason     the model is open\n"));
  job.state = intaglio_JOB_CANCELLED;
  job.verdict = "not_good";
  job.counts = {100, 40, 0, 60, 0, 0, 0};
  job.message = "cancelled by ann";
  EXPECT_EQ(ReasonOf(job), "cancelled by ann; of 100 points 60 skipped");
}

TEST(JobText, AnOpenJobHasItsProgressItsMessageAndItsAlarm) {
  client::JobView job = ShownJob(7, intaglio_JOB_ENGRAVING);
  job.progress = {{intaglio_STAGE_ENGRAVE, 1200, 5000, 10}};
  job.counts = {5000, 1200, 0, 0, 0, 3795, 5};
  job.message = "pulses were skipped: the run starts again there";
  job.alarm = "no progress: 21 of 2400 expected points";
  for (const std::string& text : {ListText({job}), ShowText(job)}) {
    EXPECT_THAT(text, HasSubstr("engrav"));
    EXPECT_THAT(text, HasSubstr("1 200 / 5 000"));
    EXPECT_THAT(text, HasSubstr("no progress: 21 of 2400"));
    EXPECT_THAT(text, HasSubstr("pulses were skipped"));
    EXPECT_THAT(text, Not(HasSubstr("of 5000 points"))) << "it has not ended";
  }
  EXPECT_THAT(ListText({job}), HasSubstr("ALARM no progress"));
  EXPECT_THAT(ShowText(job), HasSubstr("points     5 000 planned, 1 200 made, 5 armed, "
                                       "3 795 to come\n"))
      << "what is to come is not skipped, and what is armed not uncertain";
  EXPECT_THAT(ShowText(job), HasSubstr("alarm      no progress"));
}

// A synchronizer's words for a missing arm name nothing that a person can do.
TEST(JobText, AListNamesTheCommandToGiveAndNotWhatTheMachineWaitsFor) {
  client::JobView job = ShownJob(7, intaglio_JOB_WAITING_FOR_ARM);
  job.message = "waits for the permission of the job service";
  EXPECT_THAT(ListText({job}), AllOf(HasSubstr("        to do: job 7 waits for its arm: "
                                               "put its block into left, then "
                                               "intaglio arm 7\n"),
                                     Not(HasSubstr("permission"))));
  job.armed = true;
  EXPECT_THAT(ListText({job}), AllOf(HasSubstr("permission"), Not(HasSubstr("to do"))));
}

TEST(JobText, WhatComesBeforeAnArmIsInTheListInItsPlace) {
  client::JobView job = ShownJob(7, intaglio_JOB_WAITING_FOR_ARM);
  job.message =
      "nobody has reported what is mounted in left (piece): check it and report it "
      "(intaglio mount --machine left --piece TEXT), then intaglio arm 7";
  EXPECT_THAT(ListText({job}), AllOf(HasSubstr("to do: job 7 waits for its arm: nobody "
                                               "has reported what is mounted"),
                                     Not(HasSubstr("put its"))));
}

TEST(JobText, AMachineThatTakesNoBlockIsGivenAPiece) {
  client::JobView job = ShownJob(7, intaglio_JOB_WAITING_FOR_ARM);
  job.makes = "marks";
  EXPECT_THAT(ListText({job}), HasSubstr("put its piece into left, then intaglio arm 7"));
  job.awaits_block = true;
  EXPECT_THAT(ListText({job}), HasSubstr("waits for its piece: neither key nor door"));
}

TEST(JobText, TheSpeedThatWasSetIsInTheList) {
  client::JobView job = ShownJob(7, intaglio_JOB_ENGRAVING);
  EXPECT_THAT(ListText({job}), Not(HasSubstr("% speed")));
  job.speed_percent = 50;
  EXPECT_THAT(ListText({job}), HasSubstr("        at 50 % speed\n"));
}

// What `pause` and `submit` print at their end.
TEST(JobText, TheStateOfAJobIsGivenWithWhatIsNext) {
  client::JobView job = ShownJob(7, intaglio_JOB_QUEUED);
  job.message = "waits for no synchronizer of grbl runs";
  EXPECT_EQ(
      client::StateAndNextOf(job),
      "job 7 is queued: waits for no synchronizer of grbl runs; nothing of it fires "
      "before intaglio arm 7");
  job.state = intaglio_JOB_DISCRETIZING, job.message.clear();
  EXPECT_EQ(client::StateAndNextOf(job),
            "job 7 is discretizing; nothing of it fires before intaglio arm 7");
  job.armed = true;
  EXPECT_EQ(client::StateAndNextOf(job), "job 7 is discretizing, armed");
  job.state = intaglio_JOB_WAITING_FOR_ARM, job.message = "the lamp warms up: 8 %";
  EXPECT_EQ(client::StateAndNextOf(job), "job 7 is armed: the lamp warms up: 8 %");
  job.armed = false, job.message.clear();
  EXPECT_EQ(client::StateAndNextOf(job), client::NeedOf(job));
  job.state = intaglio_JOB_CANCELLED;
  EXPECT_EQ(client::StateAndNextOf(job), "job 7 is cancelled");
}

TEST(JobText, AJobAtWorkHasTheTimeLeftAndTheClockTimeOfItsEnd) {
  client::JobView job = ShownJob(7, intaglio_JOB_ENGRAVING);
  job.progress = {{intaglio_STAGE_ENGRAVE, 1200, 4800, 100}};
  job.counts = {4800, 1200, 0, 0, 0, 3595, 5};
  std::tm noon = {};
  noon.tm_year = 126;
  noon.tm_hour = 12;
  noon.tm_mday = 2;
  noon.tm_isdst = -1;
  const std::time_t now = std::mktime(&noon);
  constexpr char kLeft[] = "25 %, 5 min 00 s left, ends 12:05\n";
  EXPECT_THAT(ListText({job}, now), HasSubstr(std::string("        ") + kLeft));
  EXPECT_THAT(ShowText(job, now), HasSubstr(std::string("at work    ") + kLeft));
  // Before the pace is known, by the plan at the speed that was set.
  job.progress[0].done_count = 48;
  job.estimate_ticks = 10000;
  job.rate_hz = 100;
  job.speed_percent = 50;
  EXPECT_THAT(ListText({job}, now),
              HasSubstr("1 %, 3 min 18 s left, ends 12:03, at 50 % speed\n"));
  job.state = intaglio_JOB_PAUSED;
  EXPECT_THAT(ListText({job}, now), Not(HasSubstr("left,"))) << "a person ends a pause";
}

TEST(JobText, TheQueueOfAMachineHasItsTimeAndItsEnd) {
  std::vector<client::JobView> jobs;
  for (const std::uint32_t number : {1, 2, 3}) {
    jobs.push_back(ShownJob(number, intaglio_JOB_QUEUED));
    jobs.back().rate_hz = 100;
  }
  std::tm noon = {};
  noon.tm_year = 126;
  noon.tm_hour = 12;
  noon.tm_mday = 2;
  noon.tm_isdst = -1;
  const std::time_t now = std::mktime(&noon);
  EXPECT_THAT(ListText(jobs, now),
              HasSubstr("queue of left: the time of 3 jobs is not known\n"));
  jobs[0].state = intaglio_JOB_ENGRAVING;
  jobs[0].progress = {{intaglio_STAGE_ENGRAVE, 1200, 4800, 100}};
  EXPECT_THAT(
      ListText(jobs, now),
      HasSubstr("queue of left: 1 job takes 5 min 00 s, until 12:05 or later; the "
                "time of 2 jobs is not known\n"));
  jobs[1].estimate_ticks = 100 * 3600 * 12;
  jobs[2].estimate_ticks = 100 * 60;
  EXPECT_THAT(ListText(jobs, now), HasSubstr("queue of left: 3 jobs take 12 h 06 min, "
                                             "until 2026-01-03 00:06 or later\n"))
      << "of another day, with its date";
  jobs.resize(1);
  EXPECT_THAT(ListText(jobs, now), Not(HasSubstr("queue of"))) << "it has its own line";
}

TEST(JobText, AnEndThatIsNotSettledHasNoVerdict) {
  client::JobView job = ShownJob(7, intaglio_JOB_CANCELLED);
  job.counts = {392, 69, 0, 323, 0, 0, 0};
  job.makes = "marks";
  EXPECT_THAT(ShowText(job), HasSubstr("has not reported yet which marks were made"));
  EXPECT_THAT(ShowText(job), Not(HasSubstr("verdict")));
  EXPECT_THAT(ShowText(job), HasSubstr("marks      392 planned, 69 made"));
}

TEST(JobText, TheListIsInTheOrderOfNumbers) {
  const std::string text =
      ListText({ShownJob(12, intaglio_JOB_QUEUED), ShownJob(3, intaglio_JOB_DONE)});
  EXPECT_LT(text.find(" 3  "), text.find(" 12  "));
}

}  // namespace
}  // namespace intaglio::cli
