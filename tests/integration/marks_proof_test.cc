// Jobs of marks on the virtual scan head, as a user types them, and what is proved of
// them. The report is compared with the record of the material, which is read here alone:
// circles whose places are known from the drawing.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "engrave/formats/mark_record.h"
#include "engrave/render/canvas.h"
#include "engrave/render/png_file.h"
#include "proto/report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::Ended;
using testing::Eventually;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::Program;
using testing::Running;

constexpr int kColumns = 6, kRows = 4, kCircles = kColumns * kRows;
constexpr double kPitchMm = 6, kRadiusMm = 0.5;
constexpr auto kBound = 150s;

class MarksProof : public ::testing::Test {
 protected:
  MarksProof() : folder_(test::FreshFolder()), tag_("mproof" + std::to_string(getpid())) {
    std::ofstream drawing(folder_ / "circles.svg");
    drawing << R"(<svg xmlns="http://www.w3.org/2000/svg" width="36mm" height="24mm" )"
            << R"(viewBox="0 0 36 24">)";
    for (int i = 0; i < kCircles; ++i) {
      drawing << "<circle cx=\"" << 3 + kPitchMm * (i % kColumns) << "\" cy=\""
              << 3 + kPitchMm * (i / kColumns) << "\" r=\"0.5\"/>";
    }
    drawing << "</svg>";
    std::ofstream(folder_ / "job.textproto")
        << "name: \"circles\"\nmachine_file: \"galvo\"\n"
        << "marks { items { drawing { file: \"circles.svg\" } } "
        << "pen { speed_mm_s: 500 power_ratio: 0.5 } }\n";
  }

  Ended Run(std::vector<std::string> more) {
    std::vector<std::string> typed = {"run",         Job(),
                                      "--out",       (folder_ / "out").string(),
                                      "--materials", (folder_ / "materials.db").string(),
                                      "--lockstep",  "--no-record"};
    typed.insert(typed.end(), more.begin(), more.end());
    Running run(Program("intaglio"), typed, folder_ / "output.txt");
    return run.WaitForEnd(kBound);
  }
  std::string Job() const { return (folder_ / "job.textproto").string(); }
  Ended Type(const std::vector<std::string>& words) const {
    Running typed(Program("intaglio"), words, folder_ / "typed.txt");
    return typed.WaitForEnd(60s);
  }
  static JobReport ReportIn(const std::string& json) {
    JobReport report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(json, &report).ok()) << json;
    return report;
  }
  JobReport Report() const {
    return ReportIn(testing::TextIn(folder_ / "out/report.json"));
  }

  fs::path folder_;
  std::string tag_;
};

struct BurntCircles {
  std::size_t count = 0;
  double worst_place_um = 0, worst_diameter_um = 0;
};

struct Circle {
  Vec2 centre_mm = Vec2::Zero();
  double radius_mm = 0;
};

/// Takes the mean of the ticks' ways of each mark of the record, and nothing of the
/// report.
std::vector<Circle> AllCirclesIn(const fs::path& file) {
  const auto record = formats::ReadMarkRecord(file);
  EXPECT_TRUE(record) << file;
  std::vector<Circle> circles;
  if (!record) return circles;
  std::map<std::uint32_t, std::vector<formats::BurntTick>> of_mark;
  for (const auto& tick : record->ticks) of_mark[tick.mark].push_back(tick);
  for (const auto& [mark, ticks] : of_mark) {
    Vec2 sum = Vec2::Zero();
    double length = 0;
    for (const auto& tick : ticks) {
      sum += tick.way_mm.norm() * (tick.place_mm - tick.way_mm / 2);
      length += tick.way_mm.norm();
    }
    Circle circle{sum / length, 0};
    for (const auto& tick : ticks)
      circle.radius_mm += (tick.place_mm - circle.centre_mm).norm();
    circle.radius_mm /= static_cast<double>(ticks.size());
    circles.push_back(circle);
  }
  return circles;
}

/// Each beside the nearest place of the drawing, whose middle is the origin.
BurntCircles CirclesIn(const fs::path& file) {
  BurntCircles found;
  std::set<std::pair<int, int>> places;
  for (const Circle& circle : AllCirclesIn(file)) {
    const Vec2 cell(std::round((circle.centre_mm.x() + 15) / kPitchMm),
                    std::round((circle.centre_mm.y() + 9) / kPitchMm));
    places.insert({static_cast<int>(cell.x()), static_cast<int>(cell.y())});
    const Vec2 planned = kPitchMm * cell - Vec2(15, 9);
    found.worst_place_um =
        std::max(found.worst_place_um, 1e3 * (circle.centre_mm - planned).norm());
    found.worst_diameter_um =
        std::max(found.worst_diameter_um, 2e3 * std::abs(circle.radius_mm - kRadiusMm));
  }
  found.count = places.size();
  return found;
}

TEST_F(MarksProof, ARunOfAPieceIsProved) {
  const Ended run = Run({});
  ASSERT_TRUE(run.in_time) << run.output;
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(run.output, AllOf(HasSubstr("24 planned, 24 made, 0 skipped, 0 missed"),
                                HasSubstr("verdict     GOOD")));
  const JobReport report = Report();
  EXPECT_EQ(report.evidence(), "material");
  EXPECT_EQ(report.marks().counts().made(), static_cast<unsigned>(kCircles));
  EXPECT_THAT(report.verdict().reasons(), IsEmpty());
  EXPECT_TRUE(fs::exists(folder_ / "out/views.png"));

  // What the head recorded is the judge of the report.
  const BurntCircles burnt = CirclesIn(folder_ / "out/session/marks.rec");
  EXPECT_EQ(burnt.count, static_cast<std::size_t>(kCircles));
  EXPECT_NEAR(burnt.worst_place_um, report.marks().measures().place().max_um(), 0.5);
  EXPECT_NEAR(burnt.worst_diameter_um, report.marks().measures().diameter().max_um(), 1);
  EXPECT_LT(burnt.worst_place_um, 20);

  const Ended verified = Type({"verify", (folder_ / "out").string(), "--json"});
  EXPECT_EQ(verified.exit_code, 0) << verified.output;
  EXPECT_EQ(ReportIn(verified.output).marks().ShortDebugString(),
            report.marks().ShortDebugString());
}

// The head distorts by 3 %, and the machine has no correction of it.
TEST_F(MarksProof, AFieldThatIsNotCorrectedIsNotGood) {
  std::ofstream(folder_ / "truth.textproto")
      << "head { half_angle_deg: 10 lens_ratio: 0.03 }\n";
  const Ended run = Run({"--truth", (folder_ / "truth.textproto").string()});
  ASSERT_TRUE(run.in_time) << run.output;
  EXPECT_EQ(run.exit_code, 3) << run.output;
  const JobReport report = Report();
  EXPECT_EQ(report.marks().counts().made(), static_cast<unsigned>(kCircles));
  const BurntCircles burnt = CirclesIn(folder_ / "out/session/marks.rec");
  EXPECT_GT(burnt.worst_place_um, 20);
  EXPECT_NEAR(burnt.worst_place_um, report.marks().measures().place().max_um(), 0.5);
  ASSERT_GE(report.verdict().reasons_size(), 1);
  EXPECT_THAT(report.verdict().reasons(0),
              AllOf(HasSubstr("place of"), HasSubstr("beyond the tolerance of 20 um"),
                    HasSubstr("(item 1) at (")));
}

TEST_F(MarksProof, AMarkTakenOutOfTheRecordIsMissedByName) {
  ASSERT_EQ(Run({}).exit_code, 0);
  const fs::path file = folder_ / "out/burnt.rec";
  auto record = formats::ReadMarkRecord(file);
  ASSERT_TRUE(record);
  std::erase_if(record->ticks,
                [](const formats::BurntTick& tick) { return tick.mark == 6; });
  ASSERT_TRUE(formats::WriteMarkRecord(file, *record));
  const Ended verified = Type({"verify", (folder_ / "out").string(), "--json"});
  EXPECT_EQ(verified.exit_code, 3) << verified.output;
  const JobReport report = ReportIn(verified.output);
  EXPECT_EQ(report.marks().counts().missed(), 1u);
  EXPECT_THAT(report.verdict().reasons(),
              ElementsAre(AllOf(HasSubstr("missing in the material"),
                                HasSubstr("mark 7 (item 1) at ("))));
}

// Two circles above each other, eight times along a web that runs as fast as it may.
TEST_F(MarksProof, ARunOfAWebIsProved) {
  constexpr int kRepeats = 8;
  constexpr double kRepeatMm = 20;
  std::ofstream(folder_ / "pair.svg")
      << R"(<svg xmlns="http://www.w3.org/2000/svg" width="2mm" height="8mm" )"
      << R"(viewBox="0 0 2 8"><circle cx="1" cy="1" r="0.5"/>)"
      << R"(<circle cx="1" cy="7" r="0.5"/></svg>)";
  std::ofstream(folder_ / "job.textproto")
      << "name: \"pairs\"\nmachine_file: \"galvo-web\"\n"
      << "marks { items { drawing { file: \"pair.svg\" } } "
      << "pen { speed_mm_s: 500 power_ratio: 0.5 } "
      << "repeats { count: 8 pitch_mm: 20 } web {} }\n";
  const Ended run = Run({});
  ASSERT_TRUE(run.in_time) << run.output;
  EXPECT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_EQ(report.marks().counts().made(), 2u * kRepeats);
  const MarkWebReport& web = report.marks().web();
  EXPECT_GT(web.largest_mm_s(), 0);
  EXPECT_NEAR(web.length_mm(), (kRepeats - 1) * kRepeatMm + 2 * kRadiusMm, 0.01);

  std::map<bool, std::vector<double>> rows;
  for (const Circle& circle : AllCirclesIn(folder_ / "out/session/marks.rec")) {
    rows[circle.centre_mm.y() > 0].push_back(circle.centre_mm.x());
    EXPECT_NEAR(circle.radius_mm, kRadiusMm, 0.010);
    EXPECT_NEAR(std::abs(circle.centre_mm.y()), 3, 0.020);
  }
  ASSERT_EQ(rows.size(), 2u);
  for (auto& [above, row] : rows) {
    ASSERT_EQ(row.size(), static_cast<std::size_t>(kRepeats));
    std::ranges::sort(row);
    // Both ends of a pitch are within the tolerance.
    for (int i = 1; i < kRepeats; ++i) EXPECT_NEAR(row[i] - row[i - 1], kRepeatMm, 0.040);
  }
}

/// Taken from the mark record: each pair of circles beside the print mark that is nearest
/// to it.
struct PairsAtPrints {
  std::set<double> prints;  // at which a pair lies
  double worst_um = 0;
};

/// Pairs of circles 3 mm above and below an origin that lies at `offset_mm` from a print
/// mark; the report and the driver are not asked.
PairsAtPrints PairsIn(const fs::path& file, double offset_mm) {
  PairsAtPrints found;
  const auto record = formats::ReadMarkRecord(file);
  EXPECT_TRUE(record) << file;
  if (!record) return found;
  for (const Circle& circle : AllCirclesIn(file)) {
    double nearest_mm = 1e9;
    double print = 0;
    for (const formats::PrintMark& mark : record->prints) {
      const double off_mm = std::abs(circle.centre_mm.x() - mark.place_mm - offset_mm);
      if (off_mm >= nearest_mm) continue;
      nearest_mm = off_mm;
      print = mark.place_mm;
    }
    found.prints.insert(print);
    found.worst_um = std::max(found.worst_um, 1e3 * nearest_mm);
  }
  return found;
}

// The same pairs, each at its print mark: the print stretches by 1 % and ripples, one of
// its marks is missing, and there is dirt.
TEST_F(MarksProof, RepeatsAtPrintMarksAreProvedByThePrint) {
  std::ofstream(folder_ / "pair.svg")
      << R"(<svg xmlns="http://www.w3.org/2000/svg" width="2mm" height="8mm" )"
      << R"(viewBox="0 0 2 8"><circle cx="1" cy="1" r="0.5"/>)"
      << R"(<circle cx="1" cy="7" r="0.5"/></svg>)";
  const auto write_job = [&](const std::string& web) {
    std::ofstream(folder_ / "job.textproto")
        << "name: \"printed pairs\"\nmachine_file: \"galvo-web\"\n"
        << "marks { items { drawing { file: \"pair.svg\" } } "
        << "pen { speed_mm_s: 500 power_ratio: 0.5 } "
        << "repeats { count: 12 pitch_mm: 20 } web { speed_mm_s: 100 " << web << " } }\n";
  };
  const std::string print =
      "head { print_stretch_ratio: 0.01 print_ripple_ratio: 0.1 print_ripple_mm: 300 ";
  std::ofstream(folder_ / "print.textproto") << print << "}\n";
  write_job("eye { offset_mm: -6 tolerance_mm: 3 }");
  const Ended good = Run({"--truth", (folder_ / "print.textproto").string()});
  ASSERT_TRUE(good.in_time) << good.output;
  EXPECT_EQ(good.exit_code, 0) << good.output;
  EXPECT_THAT(good.output, AllOf(HasSubstr("24 planned, 24 made, 0 skipped"),
                                 HasSubstr("pitch 20 mm; 0 without one"),
                                 HasSubstr("verdict     GOOD")));
  const PairsAtPrints all = PairsIn(folder_ / "out/session/marks.rec", -6);
  EXPECT_EQ(all.prints.size(), 12u);
  EXPECT_LE(all.worst_um, 20);
  EXPECT_NEAR(Report().marks().measures().place().max_um(), all.worst_um, 3);

  std::ofstream(folder_ / "faults.textproto")
      << print << "print_missing: 8 print_false_mm: 233 }\n";
  fs::remove_all(folder_ / "out");
  const Ended faulty = Run({"--truth", (folder_ / "faults.textproto").string()});
  ASSERT_TRUE(faulty.in_time) << faulty.output;
  EXPECT_EQ(faulty.exit_code, 3) << faulty.output;
  const JobReport report = Report();
  EXPECT_EQ(report.marks().counts().made(), 22u);
  EXPECT_EQ(report.marks().counts().skipped(), 2u);
  const MarkEyeReport& eye = report.marks().web().eye();
  ASSERT_EQ(eye.without_print_size(), 1);
  EXPECT_EQ(eye.broken_off_count(), 0u);
  EXPECT_THAT(report.verdict().reasons(),
              ElementsAre(HasSubstr("2 marks are not made: skipped"),
                          HasSubstr("1 repeat left out, because the print mark was "
                                    "missing: " +
                                    std::to_string(eye.without_print(0)))));
  const PairsAtPrints rest = PairsIn(folder_ / "out/session/marks.rec", -6);
  EXPECT_EQ(rest.prints.size(), 11u);
  EXPECT_LE(rest.worst_um, 20);

  // By the pitch alone the same print is missed, and only its own record shows it.
  write_job("");
  fs::remove_all(folder_ / "out");
  std::ofstream(folder_ / "print.textproto")
      << print << "eye_mm: 120 print_pitch_mm: 20 }\n";
  const Ended by_pitch = Run({"--truth", (folder_ / "print.textproto").string()});
  EXPECT_EQ(by_pitch.exit_code, 0) << by_pitch.output;
  EXPECT_GT(PairsIn(folder_ / "out/session/marks.rec", -6).worst_um, 1000);
}

// A shop completes the folder of a job that has ended, and the history has its report.
TEST_F(MarksProof, AShopProvesItsJobsOfMarks) {
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), {"--domain", "49", "--tag", tag_});
    return words;
  };
  Running up(Program("intaglio"),
             with({"up", "--machine", "galvo", "--folder", (folder_ / "shop").string(),
                   "--materials", (folder_ / "materials.db").string()}),
             folder_ / "up.log");
  ASSERT_TRUE(Eventually(
      [&] { return up.Output().find("the shop is open") != std::string::npos; }, 60s))
      << up.Output();
  const Ended submitted = Type(with({"submit", Job(), "--arm"}));
  ASSERT_THAT(submitted.output, HasSubstr("job 1"));
  fs::path job;
  const auto is_proved = [&] {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder_ / "shop/jobs", error))
      if (entry.path().filename().string().starts_with("1-")) job = entry.path();
    return fs::exists(job / "report.json", error);
  };
  ASSERT_TRUE(Eventually(is_proved, kBound)) << up.Output();
  const JobReport report = ReportIn(testing::TextIn(job / "report.json"));
  EXPECT_EQ(report.evidence(), "material");
  EXPECT_EQ(report.job_number(), 1u);
  EXPECT_EQ(report.marks().counts().planned(), static_cast<unsigned>(kCircles));
  // A computer that is busy for 250 ms ends the beam in mid-mark; then it is named.
  EXPECT_EQ(report.marks().counts().made() + report.marks().counts().incomplete(),
            static_cast<unsigned>(kCircles));
  EXPECT_EQ(report.marks().counts().uncertain(), report.marks().counts().incomplete());
  EXPECT_TRUE(fs::exists(job / "views.png"));
  EXPECT_TRUE(fs::exists(job / "burnt.rec"));
  EXPECT_EQ(CirclesIn(folder_ / "shop/marks.rec").count,
            static_cast<std::size_t>(kCircles));
  const Ended history =
      Type({"history", "--folder", (folder_ / "shop").string(), "--json"});
  EXPECT_THAT(history.output, HasSubstr((job / "report.json").string()));
  up.Signal(SIGTERM);
  EXPECT_TRUE(up.WaitForEnd(20s).in_time);
}

/// Ticks one behind the other are a dot.
std::size_t DotsIn(const fs::path& file) {
  const auto record = formats::ReadMarkRecord(file);
  EXPECT_TRUE(record) << file;
  std::size_t dots = 0, before = 0;
  for (const auto& tick : record.value_or(formats::MarkRecord()).ticks) {
    dots += tick.tick != before + 1;
    before = tick.tick;
  }
  return dots;
}

TEST_F(MarksProof, OfAHalftoneFindsEachDotInItsRow) {
  constexpr unsigned kSide = 60;
  render::Canvas canvas(kSide, kSide);
  for (int i = 0; i < 60 * 60; ++i) canvas.at(i % 60, i / 60) = render::Srgb(0xBCBCBC);
  ASSERT_TRUE(render::WritePng(folder_ / "grey.png", canvas));
  std::ofstream(folder_ / "job.textproto")
      << "name: \"grey\"\nmachine_file: \"galvo\"\n"
      << "marks { items { image { file: \"grey.png\" make: MARK_IMAGE_MAKE_DOTS } } }\n";
  const Ended ended = Run({});
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr(" in rows, 0 missed, in part or too often"));
  const MarkCounts counts = Report().marks().counts();
  EXPECT_EQ(counts.made(), kSide);
  EXPECT_EQ(counts.wrong_dots(), 0u);
  // Half of the light is absorbed by half of the places.
  EXPECT_NEAR(static_cast<double>(counts.dots()), kSide * kSide / 2.0, 100);
  EXPECT_EQ(DotsIn(folder_ / "out/burnt.rec"), counts.dots());
}

}  // namespace
}  // namespace intaglio
