#include "services/job/marks/web_run.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/checks/marks_check.h"
#include "services/job/files/job_file.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/mark_maker.h"

namespace intaglio {
namespace {

using testing::HasSubstr;

/// Codes every 15 mm. `web` the fields of MarkWeb; empty: a web without a speed.
JobSpec CodesOnAWeb(const std::string& web) {
  return ParseJob(fmt::format(R"(marks {{ items {{ code {{ text: "{{n}}" }} }}
      repeats {{ count: 20 pitch_mm: 15 }} web {{ {} }} }})",
                              web),
                  JobFileFormat::kText, "job")
      .value();
}

MachineSpec HeadWithEncoder() {
  MachineSpec machine;
  machine.set_name("label-head");
  machine.mutable_mark_line()->set_protocol("scan-head");
  ScanHead& head = *machine.mutable_scan_head();
  head.set_field_mm(60);
  head.set_jump_mm_s(5000);
  head.set_servo_lag_s(0.0002);
  head.set_encoder_count_um(23);
  return machine;
}

Result<mark::MarkSet> Ordered(const JobSpec& job, Warnings& warnings) {
  const MachineSpec machine = HeadWithEncoder();
  auto made = MakeMarks(job, machine, {}, ReadLimits(), warnings, nullptr);
  if (!made) return made;
  return OrderMarks(job, machine, std::move(*made), warnings);
}

double LargestSpeed() {
  Warnings warnings;
  const JobSpec job = CodesOnAWeb("");
  return WebRunOf(job, HeadWithEncoder(), Ordered(job, warnings).value())
      .value()
      .max_mm_s;
}

TEST(WebRun, ATooFastWebIsRefusedByTheFirstMarkThatIsMissed) {
  const double largest_mm_s = LargestSpeed();
  Warnings warnings;
  EXPECT_TRUE(Ordered(CodesOnAWeb(fmt::format("speed_mm_s: {}", 0.999 * largest_mm_s)),
                      warnings));
  EXPECT_TRUE(warnings.empty());
  const auto refused =
      Ordered(CodesOnAWeb(fmt::format("speed_mm_s: {}", 1.02 * largest_mm_s)), warnings);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  for (const std::string& part :
       {fmt::format("marks.web.speed_mm_s: at {:.6g} mm/s ", 1.02 * largest_mm_s),
        std::string(" would be missed, the first: item 1 of repeat "),
        fmt::format("the largest speed is {:.1f} mm/s", largest_mm_s - 0.05)})
    EXPECT_THAT(refused.error().message, HasSubstr(part));
}

// What is given as the largest is one: typed into the job, it is taken.
TEST(WebRun, WithoutASpeedTheLargestIsChosenAndReported) {
  Warnings warnings;
  ASSERT_TRUE(Ordered(CodesOnAWeb("speed_mm_s: 0"), warnings));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, WarningCode::kChosen);
  EXPECT_EQ(warnings[0].weight, WarningWeight::kNote);
  const std::string& text = warnings[0].text;
  const std::string before = "all marks are made up to ";
  const std::size_t at = text.find(before);
  ASSERT_NE(at, std::string::npos) << text;
  const double shown_mm_s = std::stod(text.substr(at + before.size()));
  EXPECT_NEAR(shown_mm_s, LargestSpeed(), 0.1);
  EXPECT_TRUE(Ordered(CodesOnAWeb(fmt::format("speed_mm_s: {}", shown_mm_s)), warnings));
  EXPECT_THAT(text, HasSubstr("repeats a minute"));
}

TEST(WebRun, AMachineThatDoesNotFollowAWebIsRefused) {
  const JobSpec job = CodesOnAWeb("speed_mm_s: 5");
  MachineSpec machine = HeadWithEncoder();
  EXPECT_TRUE(CheckMarksOnMachine(job, machine).empty());
  machine.mutable_scan_head()->set_follow_web(false);
  ASSERT_EQ(CheckMarksOnMachine(job, machine).size(), 1u);
  machine = HeadWithEncoder();
  machine.mutable_scan_head()->clear_encoder_count_um();
  const auto found = CheckMarksOnMachine(job, machine);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field, "marks.web.speed_mm_s");
  EXPECT_THAT(found[0].message, HasSubstr("label-head does not follow one"));
}

}  // namespace
}  // namespace intaglio
