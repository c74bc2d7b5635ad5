#include "services/client/event_lines.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>

#include <sstream>
#include <vector>

#include "services/client/exit_codes.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;

class EventLinesTest : public testing::Test {
 protected:
  EventLinesTest() {
    job_.uid = "7-abc";
    job_.number = 7;
    job_.name = "cup \"of\" Anna\n";
    job_.cell = "els-03";
    job_.state = intaglio_JOB_DISCRETIZING;
    job_.progress = {{intaglio_STAGE_DISCRETIZE, 0, 0, 0}};
  }
  std::vector<JobEvent> Lines() {
    std::vector<JobEvent> events;
    std::istringstream in(out_.str());
    for (std::string line; std::getline(in, line);) {
      events.emplace_back();
      EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(line, &events.back()).ok())
          << line;
    }
    out_.str("");
    return events;
  }
  std::vector<std::string> Kinds() {
    std::vector<std::string> kinds;
    for (const JobEvent& event : Lines()) kinds.push_back(event.event());
    return kinds;
  }

  JobView job_;
  std::ostringstream out_;
  std::chrono::system_clock::time_point now_{1'000'000'000s};
  EventLines lines_{out_, [this] { return now_; }};
};

TEST_F(EventLinesTest, EveryLineHasTheFolderOfTheJob) {
  job_.result_directory = "/shop/jobs/7-abc";
  lines_.Submitted(job_);
  lines_.Show(job_);
  job_.state = intaglio_JOB_CANCELLED;
  lines_.Ended(job_, {});
  for (const JobEvent& event : Lines()) {
    EXPECT_EQ(event.result_directory(), "/shop/jobs/7-abc") << event.event();
  }
}

TEST_F(EventLinesTest, ReportsWhatIsNewAndNothingTwice) {
  lines_.Show(job_);
  EXPECT_THAT(Kinds(), ElementsAre("state"));
  lines_.Show(job_);
  EXPECT_THAT(Kinds(), ElementsAre());
  job_.message = "waits";
  lines_.Show(job_);
  EXPECT_THAT(Kinds(), ElementsAre("message"));
  job_.armed = true;
  lines_.Show(job_);
  const auto armed = Lines();
  ASSERT_EQ(armed.size(), 1u);
  EXPECT_EQ(armed[0].event(), "state");
  EXPECT_TRUE(armed[0].armed());
  job_.progress[0] = {intaglio_STAGE_DISCRETIZE, 30, 100, 2};
  lines_.Show(job_);
  EXPECT_THAT(Kinds(), ElementsAre()) << "too soon";
  now_ += EventLines::kPeriod;
  lines_.Show(job_);
  const auto progress = Lines();
  ASSERT_EQ(progress.size(), 1u);
  EXPECT_EQ(progress[0].event(), "progress");
  EXPECT_EQ(progress[0].time(), "2001-09-09T01:46:40.500Z");
  EXPECT_EQ(progress[0].job(), 7u);
  EXPECT_EQ(progress[0].name(), job_.name);
  EXPECT_EQ(progress[0].stage(), "discretize");
  EXPECT_EQ(progress[0].done(), 30u);
  EXPECT_EQ(progress[0].total(), 100u);
  EXPECT_EQ(progress[0].rate(), 15);
  job_.progress[0].done_count = 100;
  lines_.Show(job_);
  EXPECT_THAT(Kinds(), ElementsAre("progress")) << "the end of a stage is never late";
}

TEST_F(EventLinesTest, TheEndHasTheVerdictAndTheCounts) {
  JobEnd end;
  end.counts.planned = 10;
  end.counts.made = 9;
  end.counts.missed = 1;
  end.verdict = VerdictOf(true, end.counts, {});
  job_.state = intaglio_JOB_DONE;
  lines_.Ended(job_, end, "a1");
  const auto events = Lines();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].event(), "ended");
  EXPECT_EQ(events[0].id(), "a1");
  EXPECT_EQ(events[0].state(), "done");
  EXPECT_EQ(events[0].verdict(), "not_good");
  EXPECT_EQ(events[0].made(), 9u);
  EXPECT_EQ(events[0].missed(), 1u);
  EXPECT_EQ(events[0].message(), "of 10 points 1 missed");
}

// A program decides on the reason, whatever the sentence.
TEST_F(EventLinesTest, WhyAJobIsPausedIsALineOfItsOwn) {
  job_.state = intaglio_JOB_PAUSED;
  job_.pause_reason = intaglio_PAUSE_OPERATOR;
  job_.message = "a sentence";
  lines_.Show(job_);
  const auto paused = Lines();
  ASSERT_EQ(paused.size(), 1u);
  EXPECT_EQ(paused[0].pause_reason(), "operator");
  job_.pause_reason = intaglio_PAUSE_INTERLOCK;
  lines_.Show(job_);
  const auto open = Lines();
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open[0].event(), "state");
  EXPECT_EQ(open[0].pause_reason(), "interlock");
}

TEST_F(EventLinesTest, WarningsAreALineOfTheirOwnWhenTheyAreKnownAndInTheEnd) {
  job_.state = intaglio_JOB_SORTING;
  lines_.Show(job_);
  Lines();
  job_.warnings = {MakeWarning(WarningCode::kBreakage, "the glass may break")};
  lines_.Show(job_);
  lines_.Show(job_);
  const auto events = Lines();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].event(), "warnings");
  ASSERT_EQ(events[0].warnings_size(), 1);
  EXPECT_EQ(events[0].warnings(0).code(), "breakage");
  EXPECT_EQ(events[0].warnings(0).weight(), "consent");
  EXPECT_EQ(events[0].warnings(0).text(), "the glass may break");
  JobEnd end;
  end.counts.planned = 1;
  end.counts.made = 1;
  end.verdict = VerdictOf(true, end.counts, job_.warnings);
  job_.state = intaglio_JOB_DONE;
  lines_.Ended(job_, end);
  const auto ended = Lines();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].verdict(), "good_with_warnings");
  EXPECT_EQ(ended[0].warnings_size(), 1);
}

TEST_F(EventLinesTest, AnAlarmIsALineOfItsOwn) {
  job_.state = intaglio_JOB_ENGRAVING;
  lines_.Show(job_);
  (void)Lines();
  job_.alarm = "no progress";
  lines_.Show(job_);
  const auto raised = Lines();
  ASSERT_EQ(raised.size(), 1u);
  EXPECT_EQ(raised[0].event(), "message");
  EXPECT_EQ(raised[0].alarm(), "no progress");
  lines_.Show(job_);
  EXPECT_THAT(Kinds(), ElementsAre()) << "once";
}

// A name from a file may be anything.
TEST_F(EventLinesTest, ALineIsWrittenWhateverTheName) {
  job_.name = "\xff\xfe";
  lines_.Submitted(job_);
  const auto events = Lines();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].uid(), "7-abc");
}

// A shell that tests for a field finds it in every line.
TEST_F(EventLinesTest, EveryLineHasEveryField) {
  lines_.Write({});
  for (int i = 0; i < JobEvent::descriptor()->field_count(); ++i) {
    EXPECT_THAT(out_.str(), testing::HasSubstr(
                                "\"" + JobEvent::descriptor()->field(i)->name() + "\":"));
  }
}

TEST(ExitCode, FollowsTheStateAndTheVerdict) {
  JobView job;
  job.state = intaglio_JOB_DONE;
  EXPECT_EQ(ExitCodeOf(job, {VerdictKind::kGood, ""}), kExitGood);
  EXPECT_EQ(ExitCodeOf(job, {VerdictKind::kGoodWithWarnings, "x"}), kExitGood);
  EXPECT_EQ(ExitCodeOf(job, {VerdictKind::kNotGood, "x"}), kExitNotGood);
  EXPECT_EQ(ExitCodeOf(job, {VerdictKind::kUnknown, "x"}), kExitNotGood);
  job.state = intaglio_JOB_FAILED;
  EXPECT_EQ(ExitCodeOf(job, {VerdictKind::kNone, ""}), kExitMachine);
  job.state = intaglio_JOB_CANCELLED;
  EXPECT_EQ(ExitCodeOf(job, {VerdictKind::kNotGood, ""}), kExitCancelled);
}

}  // namespace
}  // namespace intaglio::client
