#include "services/cli/proofs/report_text.h"

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

JobReport MarkedPiece() {
  JobReport report;
  report.set_evidence("material");
  MarkCounts& counts = *report.mutable_marks()->mutable_counts();
  counts.set_planned(12345);
  counts.set_made(12340);
  counts.set_uncertain(2);
  counts.set_uncertain_incomplete(2);
  MarkMeasure& place = *report.mutable_marks()->mutable_measures()->mutable_place();
  place.set_count(12340);
  place.set_max_um(31.25);
  place.mutable_worst()->set_mark(17);
  place.mutable_worst()->set_item("item 2");
  place.mutable_worst()->set_repeat(3);
  place.mutable_worst()->set_x_mm(1.5);
  report.mutable_marks()->mutable_measures()->set_tolerance_um(20);
  return report;
}

TEST(ReportText, OfMarksCountsMeasuresAndTheWorstMarkByName) {
  JobReport report = MarkedPiece();
  report.mutable_marks()->mutable_web()->set_largest_mm_s(300);
  report.mutable_marks()->mutable_web()->set_marked_mm_s(270);
  EXPECT_THAT(
      SummaryOf(report),
      AllOf(HasSubstr("marks       12 345 planned, 12 340 made"),
            HasSubstr("2 uncertain (in the material: 0 whole, 2 in part"),
            HasSubstr("31.2 um max: mark 17 (item 2, repeat 3) at (1.50, 0.00) mm"),
            HasSubstr("at most 300.0 mm/s in this order, marked at 270.0 mm/s"),
            Not(HasSubstr("points")), Not(HasSubstr("glass")), Not(HasSubstr("gap"))));
}

TEST(ReportText, OfMarksWithoutTheMaterialNothingIsWrittenOfPlaces) {
  JobReport report = MarkedPiece();
  report.set_evidence("controller");
  EXPECT_THAT(SummaryOf(report),
              AllOf(HasSubstr("2 uncertain"), HasSubstr("the piece was not measured"),
                    Not(HasSubstr("tolerance")), Not(HasSubstr("stray")),
                    Not(HasSubstr("in the material"))));
}

}  // namespace
}  // namespace intaglio::cli
