#include "services/cli/report_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(ReportText, EndsWithTheVerdict) {
  JobReport report;
  report.mutable_points()->set_planned(1234567);
  report.mutable_verdict()->set_good(true);
  EXPECT_THAT(SummaryOf(report), AllOf(HasSubstr("points      1 234 567 planned, 0 made"),
                                       EndsWith("verdict     GOOD")));
  report.mutable_verdict()->set_good(false);
  report.mutable_verdict()->add_reasons("one");
  report.mutable_verdict()->add_reasons("two");
  EXPECT_THAT(SummaryOf(report), EndsWith("verdict     NOT GOOD\n  - one\n  - two"));
  report.mutable_verdict()->set_kind("good_with_warnings");
  EXPECT_THAT(SummaryOf(report),
              EndsWith("verdict     GOOD, WITH WARNINGS\n  - one\n  - two"));
}

TEST(ReportText, WithoutTheGlassNothingIsWrittenOfStraysAndPositions) {
  JobReport report;
  report.set_evidence("controller");
  report.mutable_points()->set_unaccounted(3);
  EXPECT_THAT(SummaryOf(report),
              AllOf(HasSubstr("3 uncertain"), HasSubstr("the glass was not measured"),
                    Not(HasSubstr("stray")), Not(HasSubstr("um rms"))));
}

TEST(ReportText, NamesChannelsAndMovesWhereThereAreSome) {
  JobReport report;
  EXPECT_THAT(SummaryOf(report),
              AllOf(Not(HasSubstr("channel")), Not(HasSubstr("moves"))));
  ChannelCounts& counts = *report.add_channels();
  counts.set_channel(2);
  counts.set_planned(4);
  counts.set_made(3);
  report.mutable_position_errors()->set_allowed_move_um(5);
  EXPECT_THAT(SummaryOf(report), AllOf(HasSubstr("channel 2   4 planned, 3 made"),
                                       HasSubstr("moves       5.00 um allowed")));
}

}  // namespace
}  // namespace intaglio::cli
