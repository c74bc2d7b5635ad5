// Dots of images in rows: the same dots, and how rows are divided.

#include "services/job/marks/dot_rows.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "services/job/checks/marks_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/marks/job_marks.h"

namespace intaglio {
namespace {

using testing::HasSubstr;

JobSpec JobOf(const std::string& text) {
  return ParseJob(text, JobFileFormat::kText, "job").value();
}

/// Four by two pixels: below white, white, black, black; above black, black, white,
/// black.
FileBytes SteppedBmp() {
  std::string bmp("BM", 2);
  const auto add = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bmp += static_cast<char>(value >> (8 * i) & 0xff);
  };
  add(54 + 24, 4), add(0, 4), add(54, 4), add(40, 4), add(4, 4), add(2, 4), add(1, 2);
  add(24, 2), add(0, 4), add(24, 4), add(2835, 4), add(2835, 4), add(0, 4), add(0, 4);
  for (const int grey : {255, 255, 0, 0, 0, 0, 255, 0})
    bmp += std::string(3, static_cast<char>(grey));
  const auto* first = reinterpret_cast<const std::byte*>(bmp.data());
  return {first, first + bmp.size()};
}

/// Its controller switches the laser while the mirrors sweep.
MachineSpec SweepingHead() {
  MachineSpec machine;
  machine.set_name("head");
  machine.mutable_scan_head()->set_field_mm(100);
  machine.mutable_scan_head()->set_jump_mm_s(5000);
  machine.mutable_mark_line()->set_protocol("scan-head");
  return machine;
}

Result<mark::MarkSet> MakeDotsOf(const MachineSpec& machine, const std::string& of_image,
                                 const std::string& of_marks = "") {
  Warnings warnings;
  return MakeJobMarks(JobOf(fmt::format(R"(marks {{ items {{ image {{ file: "a.bmp"
      make: MARK_IMAGE_MAKE_DOTS distance_mm: 0.1 dot_mm: 0.04 {} }}
      placement {{ fit_width_mm: 40 }} }} {} }})",
                                        of_image, of_marks)),
                      machine, {SteppedBmp()}, ReadLimits(), warnings, nullptr);
}

/// The middles of all lit ways, sorted.
std::vector<std::pair<double, double>> MiddlesOf(const mark::MarkSet& set) {
  std::vector<std::pair<double, double>> middles;
  for (const mark::Mark& mark : set.marks) {
    for (const auto& way : mark::LitWaysOf(mark, 0.001)) {
      EXPECT_NEAR((way.back() - way.front()).norm(), 0.04, 1e-9);
      const Vec2 middle = (way.back() + way.front()) / 2;
      middles.emplace_back(1e-6 * std::round(1e6 * middle.y()),
                           1e-6 * std::round(1e6 * middle.x()));
    }
  }
  std::ranges::sort(middles);
  return middles;
}

TEST(DotRows, DotsInRowsAreTheSameDots) {
  const auto each = MakeDotsOf(SweepingHead(), "dot_mode: MARK_DOT_MODE_EACH");
  const auto rows = MakeDotsOf(SweepingHead(), "");
  ASSERT_TRUE(rows) << rows.error().message;
  EXPECT_EQ(MiddlesOf(*rows), MiddlesOf(*each));
  // 200 lines, the lower of which have their dark half in one row.
  EXPECT_LT(rows->marks.size(), 600U);
  EXPECT_TRUE(mark::CheckMarks(*rows));
}

TEST(DotRows, RowsOfDotsComeBackUnlessTheyMayNot) {
  const auto backward_count = [](const mark::MarkSet& set) {
    return std::ranges::count_if(set.marks, [](const mark::Mark& mark) {
      return mark.places.back().at_mm.x() < mark.places.front().at_mm.x();
    });
  };
  const auto both = MakeDotsOf(SweepingHead(), "");
  const auto count = static_cast<std::ptrdiff_t>(both->marks.size());
  EXPECT_NEAR(static_cast<double>(backward_count(*both)), static_cast<double>(count) / 2,
              20);
  EXPECT_EQ(backward_count(*MakeDotsOf(SweepingHead(), "bidirectional: false")), 0);
  EXPECT_FALSE(MayReverse(
      JobOf("marks { items { image { file: \"a\" bidirectional: false } } }")));
  EXPECT_TRUE(MayReverse(JobOf("marks { items { image { file: \"a\" } } }")));
}

TEST(DotRows, AGapIsPassedWhileThatIsFasterThanAJumpAndRowsOfAWebAreShort) {
  double longest_gap_mm = 0;
  const auto at_rest = MakeDotsOf(SweepingHead(), "");
  for (const mark::Mark& row : at_rest->marks) {
    const auto dots = mark::LitWaysOf(row, 0.001);
    for (std::size_t i = 1; i < dots.size(); ++i)
      longest_gap_mm =
          std::max(longest_gap_mm, (dots[i].front() - dots[i - 1].back()).norm());
  }
  // At 1000 mm/s a break takes three run-ins of 0.6 ms and a jump at 5000 mm/s.
  EXPECT_GT(longest_gap_mm, 0.1);
  EXPECT_LT(longest_gap_mm, 3);
  MachineSpec web = SweepingHead();
  web.mutable_scan_head()->set_encoder_count_um(23);
  const auto rows = MakeDotsOf(web, "", "web {}");
  for (const mark::Mark& row : rows->marks)
    EXPECT_LE(mark::LengthOf(row), HeadFiguresOf(web).web_field_mm() / 8);
  EXPECT_EQ(MiddlesOf(*rows).size(), MiddlesOf(*MakeDotsOf(web, "")).size());
}

TEST(DotRows, AMachineThatCannotSweepMakesDotsEach) {
  const auto row_count = [](const MachineSpec& machine, const std::string& of_marks) {
    const auto set = MakeDotsOf(machine, "", of_marks);
    return std::ranges::count_if(set->marks, mark::IsRow);
  };
  EXPECT_GT(row_count(SweepingHead(), ""), 0);
  MachineSpec board = SweepingHead();
  board.mutable_mark_line()->set_protocol("bjjcz");
  EXPECT_EQ(row_count(board, ""), 0);
  MachineSpec from_rest = SweepingHead();
  from_rest.mutable_scan_head()->set_run_in_s(0);
  EXPECT_EQ(row_count(from_rest, ""), 0);
  // A tick is longer than the tolerance, and than a dot.
  EXPECT_EQ(row_count(SweepingHead(), "pen { speed_mm_s: 2100 }"), 0);
  MachineSpec rough = SweepingHead();
  rough.mutable_scan_head()->set_tolerance_um(1000);
  EXPECT_GT(row_count(rough, "pen { speed_mm_s: 3900 }"), 0);
  EXPECT_EQ(row_count(rough, "pen { speed_mm_s: 4100 }"), 0);
}

TEST(DotRows, ThatAMachineCannotMakeAreRefusedByFieldAndRemedy) {
  const auto errors_of = [](const MachineSpec& machine, const std::string& pen) {
    std::string errors;
    const JobSpec job = JobOf(fmt::format(
        "marks {{ items {{ image {{ file: \"a\" make: MARK_IMAGE_MAKE_DOTS dot_mode: "
        "MARK_DOT_MODE_ROWS }} }} pen {{ {} }} }}",
        pen));
    for (const Finding& finding : CheckMarksOnMachine(job, machine))
      errors += finding.message + "\n";
    return errors;
  };
  EXPECT_EQ(errors_of(SweepingHead(), ""), "");
  MachineSpec board = SweepingHead();
  board.mutable_mark_line()->set_protocol("bjjcz");
  EXPECT_THAT(errors_of(board, ""),
              HasSubstr("marks.items[0].image.dot_mode: MARK_DOT_MODE_ROWS is not "
                        "possible on head: a controller of mark_line.protocol \"bjjcz\" "
                        "does not switch the laser while the mirrors sweep; name another "
                        "machine, or use MARK_DOT_MODE_EACH"));
  EXPECT_THAT(
      errors_of(SweepingHead(), "speed_mm_s: 3000"),
      HasSubstr("passes 0.03 mm in a tick at 3000 mm/s, more than the 0.02 mm that "
                "scan_head.tolerance_um permits; mark at 2000 mm/s or less"));
  MachineSpec rough = SweepingHead();
  rough.mutable_scan_head()->set_tolerance_um(1000);
  EXPECT_THAT(errors_of(rough, "speed_mm_s: 6000"),
              HasSubstr("more than a dot of 0.05 mm; mark at 5000 mm/s or less"));
  MachineSpec from_rest = SweepingHead();
  from_rest.mutable_scan_head()->set_run_in_s(0);
  EXPECT_THAT(errors_of(from_rest, ""), HasSubstr("give a run-in"));
}

TEST(DotRows, ThatAreLeftToTheMachineAreNotedWhereItMakesDotsEach) {
  const auto noted = [](const MachineSpec& machine, const std::string& of_image) {
    JobSpec job = JobOf(
        fmt::format("marks {{ items {{ image {{ file: \"a\" {} }} }} }}", of_image));
    *job.mutable_marks() = WithDefaults(job.marks());
    Warnings warnings;
    NoteDotModes(job, machine, warnings);
    std::string texts;
    for (const Warning& warning : warnings) texts += warning.text;
    return texts;
  };
  MachineSpec board = SweepingHead();
  board.mutable_mark_line()->set_protocol("bjjcz");
  EXPECT_THAT(noted(board, "make: MARK_IMAGE_MAKE_DOTS"),
              HasSubstr("marks.items[0].image.dot_mode: dots each by itself: a "
                        "controller of mark_line.protocol \"bjjcz\""));
  EXPECT_EQ(noted(board, ""), "");
  EXPECT_EQ(noted(board, "make: MARK_IMAGE_MAKE_DOTS dot_mode: MARK_DOT_MODE_EACH"), "");
  EXPECT_EQ(noted(SweepingHead(), "make: MARK_IMAGE_MAKE_DOTS"), "");
}

TEST(DotRows, StrokesOfAnImageKeepOneDirectionToo) {
  for (const bool both : {true, false}) {
    Warnings warnings;
    const auto set =
        MakeJobMarks(JobOf(fmt::format("marks {{ items {{ image {{ file: \"a.bmp\" "
                                       "distance_mm: 0.5 bidirectional: {} }} }} }}",
                                       both)),
                     SweepingHead(), {SteppedBmp()}, ReadLimits(), warnings, nullptr);
    ASSERT_TRUE(set) << set.error().message;
    ASSERT_EQ(set->marks.size(), 3U);
    const auto backward = std::ranges::count_if(set->marks, [](const mark::Mark& mark) {
      return mark.places.back().at_mm.x() < mark.places.front().at_mm.x();
    });
    EXPECT_EQ(backward, both ? 2 : 0);
  }
}

TEST(DotRows, AreOfDotsAlone) {
  std::string errors;
  for (const Finding& finding :
       CheckMarks(JobOf("marks { items { image { file: \"a\" dot_mode: "
                        "MARK_DOT_MODE_ROWS } } }")))
    errors += finding.message + "\n";
  EXPECT_THAT(errors, HasSubstr("marks.items[0].image.dot_mode: MARK_DOT_MODE_ROWS is of "
                                "MARK_IMAGE_MAKE_DOTS"));
}

}  // namespace
}  // namespace intaglio
