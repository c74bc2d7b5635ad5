#include "services/cli/progress/progress_bar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "services/cli/progress/stage_bars.h"
#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Numbers, AreShortAndGrouped) {
  EXPECT_EQ(client::GroupedDigits(0), "0");
  EXPECT_EQ(client::GroupedDigits(999), "999");
  EXPECT_EQ(client::GroupedDigits(1000), "1 000");
  EXPECT_EQ(client::GroupedDigits(1234567), "1 234 567");
  EXPECT_EQ(client::ShortNumber(1234567), "1.23 M");
  EXPECT_EQ(client::ShortNumber(41234), "41 k");
  EXPECT_EQ(client::ShortDuration(3.2), "3.2 s");
  EXPECT_EQ(client::ShortDuration(62), "1 min 02 s");
  EXPECT_EQ(client::ShortDuration(3725), "1 h 02 min");
  EXPECT_EQ(client::ShortDuration(59.9), "1 min 00 s");
  EXPECT_EQ(client::ShortDuration(-1), "?");
}

TEST(ProgressBar, ShowsPointsRateAndTimeLeft) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  bar.Show("order", 250, 1000, 0.5, "a note");
  EXPECT_THAT(out.str(), HasSubstr("order      [######------------------]  25 %"));
  EXPECT_THAT(out.str(), HasSubstr("250 / 1 000 points"));
  EXPECT_THAT(out.str(), HasSubstr("500 /s  1.5 s left  a note\n"));
}

TEST(ProgressBar, ABlankIsBehindALongName) {
  std::ostringstream out;
  ProgressBar(out, false).Show("time-optimal", 250, 1000, 0.5);
  EXPECT_THAT(out.str(), HasSubstr("time-optimal [######-"));
}

TEST(ProgressBar, CountsWhatItIsGiven) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  bar.CountIn("marks");
  bar.Show("engrave", 250, 1000, 0.5);
  EXPECT_THAT(out.str(), HasSubstr("250 / 1 000 marks  500 /s"));
}

// A stage that took 30 s for its first points would seem to need hours.
TEST(ProgressBar, UntilThePaceIsKnownThePlanGivesTheTimeLeft) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  bar.Expect(160);
  bar.Show("engrave", 10, 1000, 30);
  EXPECT_THAT(out.str(), HasSubstr("2 min 38 s left"));
  bar.Show("engrave", 500, 1000, 100);
  EXPECT_THAT(out.str(), HasSubstr("1 min 40 s left")) << "as slow as it has been";
  std::ostringstream unknown;
  ProgressBar without(unknown, false);
  without.Show("order", 10, 1000, 1);
  EXPECT_THAT(unknown.str(), HasSubstr("1 min 39 s left"));
}

TEST(ProgressBar, InALogPrintsALineATenthAndAChangedNote) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  for (int done = 0; done <= 1000; ++done) bar.Show("order", done, 1000, 1);
  const std::string text = out.str();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 11);
  bar.Show("order", 1000, 1000, 1, "news");
  EXPECT_THAT(out.str(), HasSubstr("news"));
  // Figures that run do not fill the log.
  for (int percent = 0; percent <= 100; ++percent) {
    bar.Show("warm", 0, 1000, 1, "the lamp warms up: " + std::to_string(percent) + " %");
  }
  const std::string more = out.str();
  EXPECT_EQ(std::count(more.begin(), more.end(), '\n'), 13);
}

TEST(ProgressBar, OnATerminalDrawsOverItsLineAndLeavesNothingOfALongerOne) {
  std::ostringstream out;
  ProgressBar bar(out, true);
  bar.Show("engrave", 1, 10, 1, "a long note that goes away");
  const std::size_t first = out.str().size();
  bar.Show("engrave", 2, 10, 1);
  const std::string second = out.str().substr(first);
  EXPECT_EQ(second.front(), '\r');
  EXPECT_EQ(second.size(), first) << "the rest of the line is blanked";
  bar.Finish();
  EXPECT_EQ(out.str().back(), '\n');
}

/// 10:00 of a day in winter, where the tests run.
std::time_t TenOClock() {
  std::tm time = {};
  time.tm_year = 126, time.tm_mon = 0, time.tm_mday = 5, time.tm_hour = 10;
  return std::mktime(&time);
}

/// What a terminal of these columns shows at the end.
std::string OnTerminal(int columns, const std::string& note) {
  std::ostringstream out;
  ProgressBar bar(out, true, {[columns] { return columns; }, TenOClock});
  bar.Show("engrave", 41'230, 79'100, 600, note);
  return out.str().substr(1);
}

TEST(ProgressBar, IsNoWiderThanTheTerminal) {
  EXPECT_EQ(
      OnTerminal(0, "armed"),
      "engrave    [############------------]  52 %  41 230 / 79 100 points  68.7 /s  "
      "9 min 11 s left  ends 10:09  armed");
  EXPECT_EQ(
      OnTerminal(80, "armed"),
      "engrave     52 %  41 230 / 79 100 points  9 min 11 s left  ends 10:09  armed");
  EXPECT_EQ(OnTerminal(40, "armed"), "engrave     52 %  9 min 11 s left  a...");
  const std::string note =
      "pr\u00fcfe die T\u00fcr, \u7b49\u5f85\u95e8\u5173\u95ed, then arm "
      "the job again at the machine";
  for (int columns = 2; columns < 200; ++columns) {
    const std::string line = OnTerminal(columns, note);
    const auto width = std::count_if(line.begin(), line.end(),
                                     [](char c) { return (c & 0xC0) != 0x80; });
    EXPECT_LT(width, columns);
  }
}

TEST(ProgressBar, WorkThatIsNotPointsHasNoCounts) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  bar.ShowShare("discretize", 500, 1000, 2);
  EXPECT_THAT(out.str(), HasSubstr("50 %  2.0 s left"));
  EXPECT_THAT(out.str(), Not(HasSubstr("points")));
}

TEST(StageBars, FollowTheFirstStageThatIsNotDone) {
  std::ostringstream out;
  ProgressBar bar(out, false);
  StageBars bars(bar);
  client::JobView job;
  job.progress = {{intaglio_STAGE_DISCRETIZE, 30, 1000, 1},
                  {intaglio_STAGE_SORT, 0, 0, 0}};
  bars.Show(job, "");
  EXPECT_THAT(out.str(), HasSubstr("discretize"));
  EXPECT_THAT(out.str(), Not(HasSubstr("points")));
  job.progress = {{intaglio_STAGE_DISCRETIZE, 500, 500, 1},
                  {intaglio_STAGE_SORT, 500, 500, 2},
                  {intaglio_STAGE_ENGRAVE, 100, 500, 3}};
  bars.Show(job, "");
  EXPECT_THAT(out.str(), HasSubstr("100 %  500 / 500 points  500 /s"));
  EXPECT_THAT(out.str(), HasSubstr("order      [########################] 100 %"));
  EXPECT_THAT(out.str(), HasSubstr("engrave    [####--------------------]  20 %"));
  const std::size_t size = out.str().size();
  bars.Show(job, "");
  EXPECT_EQ(out.str().size(), size) << "ended stages are told once";
  EXPECT_EQ(client::StageAtWork(job)->stage, intaglio_STAGE_ENGRAVE);
  EXPECT_EQ(client::StageAtWork(client::JobView{}), nullptr);
}

TEST(StageBars, TakeTheTimeLeftFromThePlanAtFirst) {
  client::JobView job;
  job.estimate_ticks = 32'000;
  job.rate_hz = 200;
  job.progress = {{intaglio_STAGE_SORT, 500, 500, 2},
                  {intaglio_STAGE_ENGRAVE, 0, 500, 0}};
  EXPECT_EQ(EstimateNote(job), "machining time 2 min 40 s");
  job.progress.back().done_count = 5;
  job.progress.back().elapsed_s = 20;
  EXPECT_EQ(EstimateNote(job), "") << "the bar has it";
  const auto drawn = [&job](double speed) {
    std::ostringstream out;
    ProgressBar bar(out, false);
    StageBars(bar, speed).Show(job, "");
    return out.str();
  };
  EXPECT_THAT(drawn(1), HasSubstr("2 min 38 s left"));
  EXPECT_THAT(drawn(2), HasSubstr("1 min 19 s left"));
  EXPECT_THAT(drawn(0), HasSubstr("33 min 00 s left")) << "by the pace alone";
  job.speed_percent = 50;
  EXPECT_THAT(drawn(1), HasSubstr("5 min 17 s left"));
}

}  // namespace
}  // namespace intaglio::cli
