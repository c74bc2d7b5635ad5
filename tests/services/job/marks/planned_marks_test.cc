#include "services/job/marks/planned_marks.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include "engrave/drawing/font_list.h"
#include "engrave/mark/mark_file.h"
#include "services/job/files/job_file.h"
#include "services/job/marks/job_marks.h"
#include "services/platform/host/threads/worker_threads.h"
#include "tests/peak_memory.h"

namespace intaglio {
namespace {

MachineSpec HeadOverWeb() {
  MachineSpec machine;
  machine.set_name("label-head");
  ScanHead& head = *machine.mutable_scan_head();
  head.set_field_mm(100);
  head.set_jump_mm_s(5000);
  head.set_servo_lag_s(0.0002);
  head.set_encoder_count_um(23);
  return machine;
}

FileBytes BytesOf(const std::string& text) {
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

/// A code and a text of each row of a table.
class PlannedMarksTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto font = drawing::FindFontFile("DejaVu Sans");
    if (!font) GTEST_SKIP() << "no DejaVu Sans: install the package fonts-dejavu-core";
    std::ifstream file(*font, std::ios::binary);
    font_ = BytesOf({std::istreambuf_iterator<char>(file), {}});
  }

  static JobSpec Job(const std::string& more) {
    return ParseJob(fmt::format(R"(marks {{
        items {{ code {{ text: "{{serial}}" module_mm: 0.4 }}
                hatch {{ distance_mm: 0.2 }} }}
        items {{ text {{ text: "{{serial}}" font: "font.ttf" height_mm: 2 }}
                placement {{ move_y_mm: -7 }} }}
        table: "rows.csv" {} }})",
                                more),
                    JobFileFormat::kText, "job")
        .value();
  }

  std::vector<FileBytes> Files(std::size_t rows) const {
    std::string table = "serial\n";
    for (std::size_t i = 0; i < rows; ++i)
      table += fmt::format("SN{:06}\n", 7919 * i % 1'000'000);
    return {font_, BytesOf(table)};
  }

  Result<PlannedMarks> Plan(const JobSpec& job, std::size_t rows,
                            const PlanningProgress& progress = {},
                            const Executor& executor = {}) const {
    Warnings warnings;
    return PlannedMarks::Make(job, HeadOverWeb(), Files(rows), ReadLimits(), executor,
                              warnings, progress);
  }

  FileBytes font_;
};

const char* const kWeb = "repeats { pitch_mm: 40 } web { speed_mm_s: 90 }";

mark::MarkSet SetOf(PlannedMarks& planned) {
  mark::MarkSet set{planned.pens(), {}};
  const Status visited = planned.ForEach([&](std::size_t number, const mark::Mark& mark) {
    EXPECT_EQ(number, set.marks.size());
    set.marks.push_back(mark);
    return true;
  });
  EXPECT_TRUE(visited);
  return set;
}

/// To the bit those that the sorter makes the marker mark, whatever makes them.
TEST_F(PlannedMarksTest, AreTheMarksOfTheJobInTheirOrder) {
  constexpr std::size_t kRows = 300;  // several times what is made at once
  const JobSpec job = Job(kWeb);
  const MachineSpec machine = HeadOverWeb();
  Warnings warnings;
  auto made = MakeJobMarks(job, machine, Files(kRows), ReadLimits(), warnings, nullptr);
  ASSERT_TRUE(made) << made.error().message;
  const auto ordered = OrderJobMarks(job, machine, *std::move(made)).value();
  const auto run = WebRunOf(job, machine, ordered).value();
  ASSERT_FALSE(run.missed.empty());
  for (const Executor& executor : {Executor(), host::OnThreads(3)}) {
    auto planned = Plan(job, kRows, {}, executor);
    ASSERT_TRUE(planned) << planned.error().message;
    EXPECT_EQ(mark::EncodeMarks(SetOf(*planned)), mark::EncodeMarks(ordered));
    EXPECT_EQ(planned->mark_count(), ordered.marks.size());
    EXPECT_EQ(planned->counts()[0] + planned->counts()[1], ordered.marks.size());
    ASSERT_TRUE(planned->web() && *planned->web());
    const WebRun& web = **planned->web();
    EXPECT_EQ(web.max_mm_s, run.max_mm_s);
    EXPECT_EQ(web.missed, run.missed);
    EXPECT_EQ(web.times.time_s, run.times.time_s);
    // Units are added up, in place of marks.
    EXPECT_NEAR(web.times.mark_mm, run.times.mark_mm, 1e-12 * run.times.mark_mm);
    EXPECT_NEAR(web.times.jump_mm, run.times.jump_mm, 1e-12 * run.times.jump_mm);
  }
}

TEST_F(PlannedMarksTest, LeaveOutWhatBeginsBeyondAPlaceOfTheWeb) {
  auto planned = Plan(Job(kWeb), 30);
  ASSERT_TRUE(planned) << planned.error().message;
  std::set<double> places_mm;
  const auto visit = [&](std::size_t, const mark::Mark& mark) {
    places_mm.insert(mark.web_mm);
    return true;
  };
  ASSERT_TRUE(planned->ForEach(visit, 80));
  EXPECT_EQ(places_mm, (std::set<double>{0, 40, 80}));
}

TEST_F(PlannedMarksTest, OfAPieceAtRestAreKept) {
  const JobSpec job = Job("repeats { pitch_mm: 12 }");
  const MachineSpec machine = HeadOverWeb();
  Warnings warnings;
  auto made = MakeJobMarks(job, machine, Files(3), ReadLimits(), warnings, nullptr);
  ASSERT_TRUE(made) << made.error().message;
  const auto ordered = OrderJobMarks(job, machine, *std::move(made)).value();
  auto planned = Plan(job, 3);
  ASSERT_TRUE(planned) << planned.error().message;
  EXPECT_FALSE(planned->web());
  EXPECT_EQ(mark::EncodeMarks(SetOf(*planned)), mark::EncodeMarks(ordered));
  EXPECT_EQ(planned->times().time_s, TimesOf(ordered, planned->head()).time_s);
}

TEST_F(PlannedMarksTest, NameTheMarkThatDoesNotFitByItsNumberInTheJob) {
  JobSpec job = Job(kWeb);
  job.mutable_marks()->mutable_items(1)->mutable_placement()->set_move_y_mm(-60);
  const MachineSpec machine = HeadOverWeb();
  Warnings warnings;
  auto made = MakeJobMarks(job, machine, Files(20), ReadLimits(), warnings, nullptr);
  ASSERT_TRUE(made) << made.error().message;
  const auto ordered = OrderJobMarks(job, machine, *std::move(made));
  const auto planned = Plan(job, 20);
  ASSERT_FALSE(ordered);
  ASSERT_FALSE(planned);
  EXPECT_EQ(planned.error().message, ordered.error().message);
}

TEST_F(PlannedMarksTest, CountRepeatsAndOrdersAndEndWhenTheyAreAskedTo) {
  std::vector<std::uint64_t> made;
  std::uint64_t orders = 0;
  const PlanningProgress counts{[&](std::uint64_t done, std::uint64_t total) {
                                  EXPECT_EQ(total, 300U);
                                  made.push_back(done);
                                  return true;
                                },
                                [&](std::uint64_t done, std::uint64_t total) {
                                  EXPECT_EQ(done, orders++);
                                  EXPECT_LT(done, total);
                                  return true;
                                }};
  ASSERT_TRUE(Plan(Job(kWeb), 300, counts));
  EXPECT_EQ(made, (std::vector<std::uint64_t>{0, 128, 256}));
  EXPECT_GT(orders, 20U);
  const ProgressSink ends = [](std::uint64_t done, std::uint64_t) { return done < 10; };
  for (const PlanningProgress& progress :
       {PlanningProgress{ends, {}}, PlanningProgress{{}, ends}}) {
    const auto ended = Plan(Job(kWeb), 300, progress);
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, ErrorCode::kCancelled);
  }
}

/// A row has some 130 marks. For their times 48 bytes each are in memory, and of the
/// units of some sizes what is needed to join them: 6.9 kB in all. The marks themselves,
/// kept, would be 50 kB.
TEST_F(PlannedMarksTest, TakeBelow10KilobytesARow) {
  constexpr std::size_t kFew = 500, kMany = 2500;
  const auto peak = [&](std::size_t rows) {
    return test::PeakBytesOf([&] {
      const auto planned = Plan(Job(kWeb), rows);
      ASSERT_TRUE(planned) << planned.error().message;
    });
  };
  const auto few = peak(kFew), many = peak(kMany);
  if (!few || !many) GTEST_SKIP() << "the memory of this process cannot be measured";
  const double slope =
      (static_cast<double>(*many) - static_cast<double>(*few)) / (kMany - kFew);
  RecordProperty("bytes_a_row", fmt::format("{:.0f}", slope));
  EXPECT_LT(slope, 10'000);
}

}  // namespace
}  // namespace intaglio
