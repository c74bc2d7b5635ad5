// Halftones in rows under the virtual head, by its driver. The judge is the record of
// what was burnt, dot by dot, against the places of the dots when each is a mark of its
// own.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "engrave/proof/mark_comparison.h"
#include "services/job/files/job_file.h"
#include "services/job/marks/job_marks.h"
#include "tests/services/drivers/galvo/head_bench.h"

namespace intaglio::drivers {
namespace {

using ::testing::HasSubstr;

constexpr int kPictureWidth = 160, kPictureHeight = 60;
constexpr double kDistanceMm = 0.1, kRowDotMm = 0.05;

/// Grey that becomes darker to the right, with a white gap of 8 mm.
FileBytes Picture() {
  std::string bmp("BM", 2);
  const auto add = [&](std::uint32_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bmp += static_cast<char>(value >> (8 * i) & 0xff);
  };
  const std::uint32_t size = 3 * kPictureWidth * kPictureHeight;
  add(54 + size, 4), add(0, 4), add(54, 4), add(40, 4), add(kPictureWidth, 4);
  add(kPictureHeight, 4), add(1, 2), add(24, 2), add(0, 4), add(size, 4);
  add(2835, 4), add(2835, 4), add(0, 4), add(0, 4);
  for (int y = 0; y < kPictureHeight; ++y) {
    for (int x = 0; x < kPictureWidth; ++x) {
      const bool white = x >= 50 && x < 130;
      bmp += std::string(3, static_cast<char>(white ? 255 : 230 - x));
    }
  }
  const auto* first = reinterpret_cast<const std::byte*>(bmp.data());
  return {first, first + bmp.size()};
}

struct Halftone {
  double speed_mm_s = 1000;
  double rotate_deg = 0;
  const char* more = "";  // of marks
};

mark::MarkSet MarksOfHalftone(const Halftone& halftone, const MachineSpec& machine,
                              const char* mode) {
  const JobSpec job =
      ParseJob(
          fmt::format("marks {{ items {{ image {{ file: \"a.bmp\" make: "
                      "MARK_IMAGE_MAKE_DOTS distance_mm: {} dot_mm: {} dot_mode: {} "
                      "}} placement {{ rotate_deg: {} }} pen {{ speed_mm_s: {} }} }} "
                      "{} }}",
                      kDistanceMm, kRowDotMm, mode, halftone.rotate_deg,
                      halftone.speed_mm_s, halftone.more),
          JobFileFormat::kText, "job")
          .value();
  Warnings warnings;
  auto made = MakeJobMarks(job, machine, {Picture()}, ReadLimits(), warnings, nullptr);
  return OrderJobMarks(job, machine, std::move(made.value())).value();
}

/// The middle of each dot when each is a mark of its own.
std::vector<Vec2> PlacesOfDots(const Halftone& halftone, const MachineSpec& machine) {
  std::vector<Vec2> places;
  for (const mark::Mark& dot :
       MarksOfHalftone(halftone, machine, "MARK_DOT_MODE_EACH").marks) {
    EXPECT_NEAR(mark::LengthOf(dot), kRowDotMm, 1e-9);
    places.push_back((dot.places.front().at_mm + dot.places.back().at_mm) / 2);
  }
  return places;
}

struct BurntDot {
  Vec2 middle_mm = Vec2::Zero(), way_mm = Vec2::Zero();
  std::size_t ticks = 0;
  std::uint32_t mark = 0;
};

/// Ticks one behind the other are a dot.
std::vector<BurntDot> DotsOf(const std::vector<formats::BurntTick>& ticks) {
  std::vector<BurntDot> dots;
  std::uint64_t before = 0;
  Vec2 begin_mm;
  for (const formats::BurntTick& tick : ticks) {
    if (dots.empty() || tick.tick != before + 1) {
      dots.emplace_back();
      begin_mm = tick.place_mm - tick.way_mm;
    }
    before = tick.tick;
    BurntDot& dot = dots.back();
    dot.middle_mm = (begin_mm + tick.place_mm) / 2;
    dot.way_mm = tick.place_mm - begin_mm;
    dot.mark = tick.mark;
    ++dot.ticks;
  }
  return dots;
}

/// What was burnt of each dot that was wanted, and what belongs to none.
struct Found {
  std::vector<std::vector<BurntDot>> of_dot;
  std::size_t unknown_count = 0;
};

Found FindDots(const std::vector<Vec2>& wanted, const std::vector<BurntDot>& burnt) {
  const auto cell = [](const Vec2& p, int dx, int dy) {
    return std::pair(std::lround(p.x() / kDistanceMm) + dx,
                     std::lround(p.y() / kDistanceMm) + dy);
  };
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    cells[cell(wanted[i], 0, 0)].push_back(i);
  Found found{std::vector<std::vector<BurntDot>>(wanted.size()), 0};
  for (const BurntDot& dot : burnt) {
    double nearest_mm = 0.4 * kDistanceMm;
    std::optional<std::size_t> of;
    for (const int dx : {-1, 0, 1}) {
      for (const int dy : {-1, 0, 1}) {
        for (const std::size_t i : cells[cell(dot.middle_mm, dx, dy)]) {
          const double way_mm = (wanted[i] - dot.middle_mm).norm();
          if (way_mm < nearest_mm) nearest_mm = way_mm, of = i;
        }
      }
    }
    if (of) {
      found.of_dot[*of].push_back(dot);
    } else {
      ++found.unknown_count;
    }
  }
  return found;
}

/// Appends the marks that `is_open` names, and finishes.
template <typename IsOpen>
void RunRows(HeadBench& bench, std::uint32_t run, const mark::MarkSet& set,
             const IsOpen& is_open) {
  ASSERT_TRUE(bench.driver().Begin(run, set.pens));
  for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
    if (!is_open(i)) continue;
    ASSERT_TRUE(bench.Until([&] { return bench.driver().Room() > 0; }, 30))
        << bench.state().fault;
    const auto appended = bench.driver().Append({i, set.marks[i]});
    ASSERT_TRUE(appended) << appended.error().message;
  }
  ASSERT_TRUE(bench.driver().Finish());
}

bool IsAny(std::uint32_t) { return true; }

TEST(GalvoRows, EachDotIsBurntOnceAtItsPlaceInBothDirections) {
  const MachineSpec machine = HeadProfile();
  for (const Halftone& halftone :
       {Halftone{1000, 0}, {2000, 0}, {1300, 0}, {1000, 30}, {1000, 90}}) {
    const auto wanted = PlacesOfDots(halftone, machine);
    const auto set = MarksOfHalftone(halftone, machine, "MARK_DOT_MODE_ROWS");
    // Two rows a line beside the gap, which takes longer than a jump.
    EXPECT_LE(set.marks.size(), 2U * kPictureHeight);
    EXPECT_GE(set.marks.size(), 2U * kPictureHeight - 4);
    HeadBench bench(machine, HeadTruthOf(machine));
    ASSERT_TRUE(bench.Connect());
    RunRows(bench, 1, set, IsAny);
    ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 30));
    EXPECT_EQ(bench.state().fault, "");
    const auto burnt = DotsOf(bench.Burnt());
    const Found found = FindDots(wanted, burnt);
    EXPECT_EQ(found.unknown_count, 0U);
    const double turn_rad = halftone.rotate_deg * std::numbers::pi / 180;
    const Vec2 along(std::cos(turn_rad), std::sin(turn_rad));
    const double half_tick_mm = 0.5e-5 * halftone.speed_mm_s;
    double worst_mm = 0;
    std::map<bool, double> shift_mm, count;  // by direction
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      ASSERT_EQ(found.of_dot[i].size(), 1U) << i;
      const BurntDot& dot = found.of_dot[i].front();
      EXPECT_EQ(dot.ticks, burnt.front().ticks);
      worst_mm = std::max(worst_mm, (dot.middle_mm - wanted[i]).norm());
      const bool back = dot.way_mm.dot(along) < 0;
      shift_mm[back] += (dot.middle_mm - wanted[i]).dot(along);
      ++count[back];
    }
    // Half a tick, and what the servo and the steps of the outputs leave.
    EXPECT_LE(worst_mm, half_tick_mm + 0.003) << halftone.speed_mm_s;
    EXPECT_LE(1e3 * worst_mm, 20);
    EXPECT_GT(count[true], 0.3 * static_cast<double>(wanted.size()));
    EXPECT_GT(count[false], 0.3 * static_cast<double>(wanted.size()));
    const double columns_mm =
        std::abs(shift_mm[true] / count[true] - shift_mm[false] / count[false]);
    EXPECT_LE(columns_mm, half_tick_mm + 0.002);
    const auto proof = proof::CompareMarks(set, bench.Burnt(), false);
    EXPECT_TRUE(proof.IsGood(20)) << proof.worst.place_um << " " << proof.worst.shape_um;
    EXPECT_EQ(proof.dot_count, wanted.size());
    EXPECT_EQ(proof.wrong_dot_count, 0U);
    RecordProperty(
        fmt::format("at_{}_turned_{}", halftone.speed_mm_s, halftone.rotate_deg),
        fmt::format("{} dots, worst {:.1f} um, columns {:.1f} um", wanted.size(),
                    1e3 * worst_mm, 1e3 * columns_mm));
  }
}

TEST(GalvoRows, TakeTheTimeThatIsPlannedAndMuchLessThanDotsEach) {
  const MachineSpec machine = HeadProfile();
  const auto rows = MarksOfHalftone({}, machine, "MARK_DOT_MODE_DEFAULT");
  const double planned_s = TimesOf(rows, HeadFiguresOf(machine)).time_s;
  HeadBench bench(machine, HeadTruthOf(machine));
  ASSERT_TRUE(bench.Connect());
  RunRows(bench, 1, rows, IsAny);
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 30));
  const auto burnt = bench.Burnt();
  const double made_s =
      1e-5 * static_cast<double>(burnt.back().tick - burnt.front().tick);
  EXPECT_NEAR(made_s, planned_s, 0.02 * planned_s);
  const auto each = MarksOfHalftone({}, machine, "MARK_DOT_MODE_EACH");
  EXPECT_GT(TimesOf(each, HeadFiguresOf(machine)).time_s, 10 * planned_s);
}

TEST(GalvoRows, AfterAStopInARowAndAResumeNoDotIsMadeTwice) {
  const MachineSpec machine = HeadProfile();
  const auto wanted = PlacesOfDots({}, machine);
  const auto set = MarksOfHalftone({}, machine, "MARK_DOT_MODE_ROWS");
  HeadBench bench(machine, HeadTruthOf(machine));
  ASSERT_TRUE(bench.Connect());
  ASSERT_TRUE(bench.driver().Begin(1, set.pens));
  std::uint32_t next = 0;
  // A row lasts some milliseconds: the stop comes in the middle of one.
  while (DotsOf(bench.Burnt()).size() < wanted.size() / 3) {
    if (bench.driver().Room() > 0 && next < set.marks.size()) {
      ASSERT_TRUE(bench.driver().Append({next, set.marks[next]}));
      ++next;
    }
    for (int i = 0; i < 7; ++i) bench.Step();
  }
  ASSERT_TRUE(bench.driver().Stop());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }));
  std::set<std::uint32_t> broken;
  for (std::uint32_t i = 0; i < set.marks.size(); ++i)
    if (bench.Has(i, MarkFate::kBroken)) broken.insert(i);
  ASSERT_EQ(broken.size(), 1U);
  const auto first = DotsOf(bench.Burnt());
  ASSERT_TRUE(bench.driver().Reset());
  ASSERT_TRUE(bench.Until([&] { return !bench.state().safe_state; }));
  bench.Until([] { return false; }, 0.1);
  // As the marker goes on: what was begun is not made again.
  RunRows(bench, 2, set, [&](std::uint32_t i) {
    return !bench.Has(i, MarkFate::kDone) && !broken.contains(i);
  });
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 30));
  EXPECT_EQ(bench.state().fault, "");
  const Found found = FindDots(wanted, DotsOf(bench.Burnt()));
  EXPECT_EQ(found.unknown_count, 0U);
  std::size_t missed = 0;
  for (const std::vector<BurntDot>& dots : found.of_dot) {
    EXPECT_LE(dots.size(), 1U);
    missed += dots.empty();
  }
  const std::size_t in_broken = mark::LitWayCount(set.marks[*broken.begin()]);
  std::size_t burnt_of_broken = 0;
  for (const BurntDot& dot : first) burnt_of_broken += dot.mark == *broken.begin();
  EXPECT_GT(burnt_of_broken, 0U);
  EXPECT_LT(burnt_of_broken, in_broken);
  EXPECT_EQ(missed, in_broken - burnt_of_broken);
  const auto proof = proof::CompareMarks(set, bench.Burnt(), false);
  EXPECT_EQ(proof.incomplete_count, 1U);
  EXPECT_EQ(proof.doubled_count + proof.missed_count, 0U);
}

TEST(GalvoRows, APauseEndsAtTheEndOfARow) {
  const MachineSpec machine = HeadProfile();
  const auto wanted = PlacesOfDots({}, machine);
  const auto set = MarksOfHalftone({}, machine, "MARK_DOT_MODE_ROWS");
  HeadBench bench(machine, HeadTruthOf(machine));
  ASSERT_TRUE(bench.Connect());
  ASSERT_TRUE(bench.driver().Begin(1, set.pens));
  for (std::uint32_t i = 0; i < 40; ++i)
    ASSERT_TRUE(bench.driver().Append({i, set.marks[i]}));
  ASSERT_TRUE(bench.Until([&] { return bench.Has(5, MarkFate::kDone); }));
  ASSERT_TRUE(bench.driver().Pause());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }));
  EXPECT_FALSE(bench.Has(39, MarkFate::kDone));
  RunRows(bench, 2, set, [&](std::uint32_t i) { return !bench.Has(i, MarkFate::kDone); });
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 30));
  const Found found = FindDots(wanted, DotsOf(bench.Burnt()));
  EXPECT_EQ(found.unknown_count, 0U);
  for (const std::vector<BurntDot>& dots : found.of_dot) EXPECT_EQ(dots.size(), 1U);
}

TEST(GalvoRows, OfAHeadWithoutLeadMeetByTheDelaysOfItsLaser) {
  MachineSpec machine = HeadProfile();
  ScanHead& head = *machine.mutable_scan_head();
  head.set_lead_servo(false);
  head.set_laser_on_delay_s(head.servo_lag_s());
  head.set_laser_off_delay_s(head.servo_lag_s());
  const auto wanted = PlacesOfDots({}, machine);
  const auto set = MarksOfHalftone({}, machine, "MARK_DOT_MODE_ROWS");
  HeadBench bench(machine, HeadTruthOf(machine));
  ASSERT_TRUE(bench.Connect());
  RunRows(bench, 1, set, IsAny);
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 30));
  const Found found = FindDots(wanted, DotsOf(bench.Burnt()));
  EXPECT_EQ(found.unknown_count, 0U);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    ASSERT_EQ(found.of_dot[i].size(), 1U) << i;
    EXPECT_LE((found.of_dot[i].front().middle_mm - wanted[i]).norm(), 0.02) << i;
  }
}

TEST(GalvoRows, OnAWebHaveTheirDotsWhereTheyBelong) {
  MachineSpec machine = HeadProfile();
  machine.mutable_scan_head()->set_encoder_count_um(23);
  const Halftone halftone{1000, 0, "web {} repeats { count: 3 pitch_mm: 30 }"};
  const auto set = MarksOfHalftone(halftone, machine, "MARK_DOT_MODE_ROWS");
  const HeadFigures figures = HeadFiguresOf(machine);
  const auto timed = TimedMarksOf(set, figures);
  auto truth = HeadTruthOf(machine);
  truth.physics.web_mm_s = 0.95 * galvo::MaxSpeed(timed, figures.web_field_mm()).value();
  HeadBench bench(machine, truth);
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  RunRows(bench, 1, set, IsAny);
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 60));
  EXPECT_EQ(bench.state().fault, "");
  const auto proof = proof::CompareMarks(set, bench.Burnt(), true);
  EXPECT_TRUE(proof.IsGood(20)) << proof.worst.place_um << " " << proof.worst.shape_um;
  EXPECT_EQ(proof.dot_count, 3 * PlacesOfDots({}, machine).size());
  EXPECT_EQ(proof.wrong_dot_count, 0U);
  RecordProperty("web", fmt::format("{:.1f} mm/s, place {:.1f} um, shape {:.1f} um",
                                    truth.physics.web_mm_s, proof.worst.place_um,
                                    proof.worst.shape_um));
}

}  // namespace
}  // namespace intaglio::drivers
