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

/// An eye 40 mm before the middle of the field, which begins 30 mm before it.
MachineSpec HeadWithEye(double eye_mm = 40) {
  MachineSpec machine = HeadWithEncoder();
  machine.mutable_scan_head()->set_eye_mm(eye_mm);
  return machine;
}

Result<mark::MarkSet> OrderedByEye(const std::string& web, Warnings& warnings,
                                   double eye_mm = 40) {
  const JobSpec job = CodesOnAWeb(web);
  auto made = MakeMarks(job, HeadWithEye(eye_mm), {}, ReadLimits(), warnings, nullptr);
  if (!made) return made;
  return OrderMarks(job, HeadWithEye(eye_mm), std::move(*made), warnings);
}

// The last module of a code of 5 mm begins at x = 2 mm, and a line of it is in the field,
// less its border and the lead of the servo, when the origin is 29.6 + 2 mm before the
// middle.
TEST(WebRun, AnEyeThatSeesTooLateIsRefusedWithItsNumbers) {
  Warnings warnings;
  const JobSpec job = CodesOnAWeb("eye {}");
  const mark::MarkSet set = OrderedByEye("eye {}", warnings).value();
  const WebRun run = WebRunOf(job, HeadWithEye(), set).value();
  ASSERT_TRUE(run.eye_max_mm_s);
  EXPECT_NEAR(run.eye_way_mm, 40 - 29.6 - 2, 0.05);
  EXPECT_NEAR(*run.eye_max_mm_s, run.eye_way_mm / 0.04, 1e-9);
  EXPECT_LE(run.max_mm_s, *run.eye_max_mm_s);
  const std::string speed = fmt::format("{:.6g}", 1.01 * *run.eye_max_mm_s);
  const auto refused = OrderedByEye("eye {} speed_mm_s: " + speed, warnings);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  for (const std::string& part :
       {"marks.web.speed_mm_s: at " + speed + " mm/s",
        std::string("scan_head.eye_mm: 40"),
        fmt::format("{:.1f} mm of web", run.eye_way_mm), std::string("40 ms ahead"),
        fmt::format("largest speed is {:.1f} mm/s", *run.eye_max_mm_s - 0.05)})
    EXPECT_THAT(refused.error().message, HasSubstr(part));
  const auto behind = OrderedByEye("eye { offset_mm: 20 }", warnings);
  ASSERT_FALSE(behind);
  EXPECT_THAT(behind.error().message, HasSubstr("marks.web.eye.offset_mm: 20 mm"));
}

// Repeats may come a tolerance sooner than planned.
TEST(WebRun, AnEyeLeavesTheToleranceOfThePitch) {
  Warnings warnings;
  const JobSpec job = CodesOnAWeb("eye { tolerance_mm: 1.5 }");
  const auto set = OrderedByEye("eye { tolerance_mm: 1.5 }", warnings, 200);
  ASSERT_TRUE(set) << set.error().message;
  const WebRun run = WebRunOf(job, HeadWithEye(200), *set).value();
  EXPECT_NEAR(run.max_mm_s, 0.9 * LargestSpeed(), 1e-6);
  const auto refused = OrderedByEye(
      fmt::format("speed_mm_s: {} eye {{ tolerance_mm: 1.5 }}", 0.95 * LargestSpeed()),
      warnings, 200);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr(" would be missed"));
  bool is_noted = false;
  for (const Warning& warning : warnings)
    is_noted |=
        warning.text.find("expected every 15 mm within 1.5 mm") != std::string::npos;
  EXPECT_TRUE(is_noted);
}

TEST(WebRun, AnEyeNeedsAMachineThatHasOneAndAToleranceBelowHalfOfThePitch) {
  const JobSpec job = CodesOnAWeb("eye {}");
  EXPECT_TRUE(CheckMarksOnMachine(job, HeadWithEye()).empty());
  const auto found = CheckMarksOnMachine(job, HeadWithEncoder());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].field, "marks.web.eye.offset_mm");
  EXPECT_THAT(found[0].message, HasSubstr("label-head has no photo eye"));
  const auto wide = [](const std::string& eye) {
    std::vector<std::string> fields;
    for (const Finding& finding : CheckMarks(CodesOnAWeb("eye { " + eye + " }")))
      fields.push_back(finding.field);
    return fields;
  };
  EXPECT_THAT(wide("tolerance_mm: 7.5"), testing::Contains("marks.web.eye.tolerance_mm"));
  EXPECT_THAT(wide("tolerance_mm: 7.4"),
              testing::Not(testing::Contains("marks.web.eye.tolerance_mm")));
}

}  // namespace
}  // namespace intaglio
