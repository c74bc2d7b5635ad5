// The whole product at work on a machine in lockstep, which waits for the slowest
// process.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "engrave/formats/journal_file.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using ::testing::HasSubstr;
using testing::kBound;
using testing::Program;
using testing::RunJob;
using testing::Running;
using testing::SampleJob;

/// The points of which the journal does not know whether or where they were fired.
std::size_t UncertainIn(const fs::path& file) {
  const auto journal = formats::ReadJournal(file);
  EXPECT_TRUE(journal.has_value());
  std::size_t count = 0;
  if (!journal) return count;
  for (const formats::PointHistory& point : formats::HistoryOf(*journal))
    count += point.outcome == formats::PointOutcome::kUncertain;
  return count;
}

// Every rate a lamp may have, and the machine follows as well as its limits allow.
class Rate : public RunJob, public ::testing::WithParamInterface<int> {};

TEST_P(Rate, IsServedForAWholeJob) {
  std::ifstream supplied(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  std::string machine{std::istreambuf_iterator<char>(supplied), {}};
  const std::string rates = "rates_hz: [";
  machine.insert(machine.find(rates) + rates.size(), "500, 1000, 4000, ");
  // A diode, and no lamp that takes 4.9 J a pulse.
  const std::string pump = "pump { energy_j: 4.9 }";
  machine.replace(machine.find(pump), pump.size(), "pump { energy_j: 0.2 }");
  std::ofstream(folder_ / "fast.textproto") << machine;
  const std::string rate = std::to_string(GetParam());
  const Ended run = Run({"--lockstep", "--warm-up", "1", "--spacing", "0.8", "--rate",
                         rate, "--machine", (folder_ / "fast.textproto").string()});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.points().made(), report.points().planned());
  EXPECT_EQ(report.shadow_violations(), 0u);
  EXPECT_LT(report.position_errors().rms_um(), 1);
}

INSTANTIATE_TEST_SUITE_P(OfALamp, Rate, ::testing::Values(50, 500, 1000, 4000),
                         ::testing::PrintToStringParamName());

// The virtual controllers report what the profile names; other ones would be refused.
TEST_F(RunJob, AProfileThatNamesItsControllersIsServed) {
  std::string machine =
      testing::TextIn(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  for (const auto& [line, number] :
       {std::pair<std::string, std::string>("\nlaser_line {", "A 03"),
        {"\nmotion_line {", "ST-7"}}) {
    machine.insert(machine.find(line) + line.size(), " serial_number: \"" + number + '"');
  }
  std::ofstream(folder_ / "named.textproto") << machine;
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8", "--machine",
                         (folder_ / "named.textproto").string()});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_TRUE(Report().verdict().good());
  EXPECT_THAT(testing::TextIn(folder_ / "out/session/machine.textproto"),
              ::testing::AllOf(HasSubstr("A 03"), HasSubstr("ST-7")));
}

// The published repeatability, which no service knows of, is in the glass and the proof.
TEST_F(RunJob, ATruthFileReportsWhereTheMachineDiffersFromItsProfile) {
  const fs::path truth = folder_ / "truth.textproto";
  std::ofstream(truth) << "stage { repeatability_um: 10 } seed: 5";
  const Ended run = Run(
      {"--lockstep", "--warm-up", "0", "--spacing", "0.8", "--truth", truth.string()});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  // Uniform in +-10 um on each axis of the stage. A move in depth is longer in the glass,
  // by sqrt(n^2 - NA^2) / sqrt(1 - NA^2) = 1.521 with n 1.5195 and NA 0.058: so 11.98 um
  // rms of the distances, and none above 20.8 um. What the commands leave is below 1 um.
  EXPECT_NEAR(Report().position_errors().rms_um(), 11.98, 0.6);
  EXPECT_LT(Report().position_errors().max_um(), 21.9);
  EXPECT_EQ(Report().points().made(), Report().points().planned());
}

/// The supplied profile with another line for the drive.
void WriteProfile(const fs::path& file, const std::string& drive) {
  std::string machine =
      testing::TextIn(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  const std::string line = "\nstage_lag_s: 0.0002";
  std::ofstream(file) << machine.replace(machine.find(line), line.size(), "\n" + drive);
}

// The machine rings at 120 Hz. With a profile that has this drive every point is made,
// within 12 um of the stage and as much more in depth as its moves are longer in the
// glass. One that gives its lag at constant speed as a first order is beside the points
// by more.
TEST_F(RunJob, ASecondOrderStageIsCompensatedByASecondOrderProfile) {
  const std::string drive =
      "second_order { natural_frequency_hz: 120 damping_ratio: 0.7 }";
  const fs::path second = folder_ / "second.textproto",
                 first = folder_ / "first.textproto";
  const fs::path truth = folder_ / "truth.textproto";
  WriteProfile(second, drive);
  WriteProfile(first, "stage_lag_s: 0.001857");  // 2 * 0.7 / (2 pi * 120 Hz)
  std::ofstream(truth) << "stage { " << drive << " }";
  const std::vector<std::string> job = {"--lockstep", "--warm-up", "0", "--spacing",
                                        "0.8"};
  const auto with = [&job](std::vector<std::string> more) {
    more.insert(more.begin(), job.begin(), job.end());
    return more;
  };
  const Ended good = Run(with({"--machine", second.string()}));
  ASSERT_TRUE(good.in_time);
  ASSERT_EQ(good.exit_code, 0) << good.output;
  const JobReport compensated = Report();
  EXPECT_EQ(compensated.points().made(), compensated.points().planned());
  EXPECT_LT(compensated.position_errors().max_um(), 20);

  const Ended worse = Run(with({"--machine", first.string(), "--truth", truth.string()}));
  ASSERT_TRUE(worse.in_time);
  EXPECT_GT(Report().position_errors().rms_um(),
            1.5 * compensated.position_errors().rms_um());
  EXPECT_GT(Report().position_errors().max_um(),
            1.5 * compensated.position_errors().max_um());
}

// The stage is 1 ms late, 80 um at full speed, and the profile does not have it. Fired at
// the tick the cracks are late, too; fired at the place they are beside the way by what
// the lag cuts from its corners, and none is made twice.
TEST_F(RunJob, FiredAtThePlaceALateStageMakesItsPoints) {
  const fs::path late = folder_ / "late.textproto", place = folder_ / "place.textproto";
  const fs::path truth = folder_ / "truth.textproto";
  WriteProfile(late, "stage_lag_s: 0\nposition_tolerance_um: 200");
  WriteProfile(place,
               "stage_lag_s: 0\nposition_tolerance_um: 200\n"
               "pulse_trigger: PULSE_TRIGGER_AT_PLACE");
  for (const fs::path& file : {late, place}) {  // the wider tolerance is the only one
    std::string text = testing::TextIn(file);
    const std::string narrow = "\nposition_tolerance_um: 30";
    std::ofstream(file) << text.erase(text.find(narrow), narrow.size());
  }
  std::ofstream(truth) << "stage { first_order_lag_s: 0.001 }";
  const auto run = [&](const fs::path& profile) {
    const Ended ended = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8",
                             "--machine", profile.string(), "--truth", truth.string()});
    EXPECT_TRUE(ended.in_time);
    EXPECT_EQ(Report().points().made(), Report().points().planned()) << ended.output;
    EXPECT_EQ(Report().points().doubled() + Report().points().stray(), 0u);
    return Report().position_errors().rms_um();
  };
  const double at_tick_um = run(late), at_place_um = run(place);
  EXPECT_GT(at_tick_um, 20);
  EXPECT_LT(at_place_um, 0.4 * at_tick_um);
}

// The profile knows nothing of a mount that ends 30 mm below its lens.
TEST_F(RunJob, AMountThatEntersTheBlockIsRecordedAndTheVerdictIsNotGood) {
  const fs::path truth = folder_ / "truth.textproto";
  // Switched on with its lens above the block, as a person leaves a machine.
  std::ofstream(truth) << "lens { above_focus_mm: 13 } stage { start_mm { z: 57 } }";
  const Ended ended = Run({"--lockstep", "--warm-up", "0", "--height", "20", "--spacing",
                           "0.8", "--truth", truth.string()});
  EXPECT_NE(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("NOT GOOD"));
  const JobReport report = Report();
  EXPECT_EQ(report.points().made(), report.points().planned());
  ASSERT_EQ(report.collisions_size(), 1) << ended.output;
  EXPECT_EQ(report.collisions(0).body(), "lens");
  EXPECT_EQ(report.collisions(0).solid(), "block");
  // The lowest point, 25 mm deep in N-BK7, is 16.4 mm below the face in air; recorded is
  // every 0.1 mm, and between two points the stage swings a little lower.
  EXPECT_GT(report.collisions(0).overlap_mm(), 16.4 - 13 - 0.1);
  EXPECT_LT(report.collisions(0).overlap_mm(), 16.4 - 13 + 0.3);
}

// Both before anything moves: by what the job says, and by its points.
TEST_F(RunJob, ALensThatWouldEnterTheBlockIsRefused) {
  const Ended high = Run({"--lockstep", "--block", "80", "80", "100", "--height", "80"});
  EXPECT_NE(high.exit_code, 0);
  EXPECT_THAT(high.output, HasSubstr("fit_height_mm: 80 is more than the lens f43"));
  const Ended deep = Run({"--lockstep", "--warm-up", "0", "--block", "80", "80", "100",
                          "--height", "40", "--spacing", "1.5"});
  EXPECT_NE(deep.exit_code, 0);
  // 70 mm of N-BK7 are 46.0 mm of air.
  EXPECT_THAT(deep.output, HasSubstr("the lens f43 would be 3.0 mm inside the block"));
  EXPECT_THAT(deep.output, HasSubstr("or take the lens f70"));
  const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
  EXPECT_TRUE(!glass || (glass->cracks.empty() && glass->collisions.empty()));
}

TEST_F(RunJob, AWrongTruthFileIsWrongInput) {
  const fs::path truth = folder_ / "truth.textproto";
  std::ofstream(truth) << "stage { repeatability_um: -1 }";
  const Ended run = Run({"--lockstep", "--truth", truth.string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.output, HasSubstr(truth.string() + ": stage.repeatability_um: -1 is"));
}

// A crystal that jumps by 400 ppm makes 0.4 ms a second: the motion that is out already
// is wrong for some pulses. They are held back, and made from a new plan.
TEST_F(RunJob, AClockThatChangesItsPaceMakesNoCrackInTheWrongPlace) {
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--clock-drift", "-200",
                         "--line-jitter", "2", "--fault", "9000 clock-drift 200"});
  ASSERT_TRUE(run.in_time);
  const JobReport report = Report();
  EXPECT_GE(report.engrave().run_count(), 2u) << run.output;
  EXPECT_EQ(report.points().doubled() + report.points().stray(), 0u) << run.output;
  EXPECT_EQ(report.shadow_violations(), 0u);
  EXPECT_LT(report.position_errors().max_um(), 30) << "the machine's tolerance";
  // What came to lie under a crack before it could be made is left out and reported.
  EXPECT_GE(report.points().made() + 20, report.points().planned());
  // A point that a pulse beside its place may have hit is uncertain, and not made again.
  const std::uint64_t open =
      report.points().planned() - report.points().made() - report.points().skipped();
  EXPECT_LE(open, UncertainIn(folder_ / "out/journal.bin")) << run.output;
}

// What is fired until it is known is at the places of later points, and each of them is
// uncertain as the points that are not made instead: none is made twice.
TEST_F(RunJob, ALampSyncThatIsLeftOutDoublesNoPoint) {
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--clock-drift", "35", "--fault",
                         "9000 lamp-sync miss 2"});
  ASSERT_TRUE(run.in_time);
  EXPECT_EQ(run.exit_code, 3) << run.output;
  EXPECT_THAT(run.output, HasSubstr("a lamp sync was left out, late or too many"));
  const JobReport report = Report();
  const auto& points = report.points();
  EXPECT_EQ(points.doubled() + points.stray(), 0u);
  const std::size_t uncertain = UncertainIn(folder_ / "out/journal.bin");
  EXPECT_GE(uncertain, 3u);
  // The places of the ticks that were left out; and behind the last pulse before the run
  // ended, those that another pulse may have hit, as many as were still on their way.
  EXPECT_GE(points.planned() - points.made(), 2u) << run.output;
  EXPECT_LE(points.planned() - points.made(), uncertain) << run.output;
  // In lockstep the laser does not wait for the stamps.
  EXPECT_LE(uncertain, 500u);
}

TEST_F(RunJob, MissedPulsesAreReportedAndTheVerdictIsNotGood) {
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--fault", "500 miss 3"});
  ASSERT_TRUE(run.in_time);
  EXPECT_EQ(run.exit_code, 3) << run.output;
  EXPECT_EQ(Report().points().missed(), 3u);
  EXPECT_EQ(Report().points().unaccounted(), 0u);
}

TEST_F(RunJob, StuckStageMakesNoStrayCrack) {
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--fault", "500 stick x"});
  ASSERT_TRUE(run.in_time);
  EXPECT_NE(run.exit_code, 0) << run.output;
  EXPECT_EQ(Report().points().stray(), 0u);
  EXPECT_EQ(Report().points().doubled(), 0u);
}

TEST_F(RunJob, DroppedBytesOnTheLineCostNothingButTime) {
  const Ended run =
      Run({"--lockstep", "--warm-up", "0", "--fault", "200 drop-bytes 0.0005 laser",
           "--fault", "200 drop-bytes 0.0005 motion"});
  ASSERT_TRUE(run.in_time);
  EXPECT_EQ(Report().points().doubled(), 0u) << run.output;
  EXPECT_EQ(Report().points().stray(), 0u);
}

TEST_F(RunJob, WrongInputsAreNamedAllAtOnce) {
  const fs::path job = folder_ / "wrong.textproto";
  std::ofstream(job)
      << "models { file: \"nowhere.stl\" placement { fit_height_mm: 5000 } }\n"
         "block { size_mm { x: -1 y: 50 z: 50 } margin_mm: 1000 }\n"
         "glass: \"N-BK7\"\n"
         "discretization { min_spacing_mm: 0.0001 }\n"
         "laser { rate_hz: 77 }\n"
         "machine_file: \""
      << (fs::path(INTAGLIO_SOURCE_DIR) / "deploy/machines/els-03.textproto").string()
      << "\"\n";
  Running run(Program("intaglio"),
              {"run", job.string(), "--out", (folder_ / "out").string()},
              folder_ / "output.txt");
  const Ended ended = run.WaitForEnd(kBound);
  EXPECT_EQ(ended.exit_code, 2);
  for (const char* field :
       {"models[0].file", "models[0].placement.fit_height_mm", "block.size_mm.x",
        "block.margin_mm", "discretization.min_spacing_mm", "laser.rate_hz"}) {
    EXPECT_THAT(ended.output, HasSubstr(field));
  }
}

TEST_F(RunJob, UnknownGlassIsNamedWithTheRemedy) {
  const Ended run = Run({"--glass", "N-BK77", "--lockstep"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.output, HasSubstr("N-BK77"));
  EXPECT_THAT(run.output, HasSubstr("N-BK7"));
}

TEST_F(RunJob, FolderThatCannotBeWrittenIsNamed) {
  Running run(Program("intaglio"),
              {"run", SampleJob().string(), "--lockstep", "--out", "/proc/no/such/place"},
              folder_ / "output.txt");
  const Ended ended = run.WaitForEnd(kBound);
  EXPECT_EQ(ended.exit_code, 2) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("/proc/no/such/place"));
}

// Two models side by side, 30 and 6 mJ: each crack was made with the energy of its own.
TEST_F(RunJob, EachModelHasItsPulseEnergy) {
  std::string points[2];
  for (int i = 0; i < 60; ++i) {
    for (const int model : {0, 1}) {
      points[model] += "points_mm { x: " + std::to_string(8 + i % 5 * 2 + 12 * model) +
                       " y: " + std::to_string(8 + i / 5 % 4 * 2) +
                       " z: " + std::to_string(8 + i / 20 * 2) + " } ";
    }
  }
  const fs::path job = folder_ / "job.textproto";
  std::ofstream(job) << "name: \"two energies\" models { " << points[0] << "} models { "
                     << points[1]
                     << "pulse_energy_mj: 6 } block { size_mm { x: 40 y: 30 z: 20 } } "
                        "glass: \"N-BK7\" discretization { min_spacing_mm: 0.5 } "
                        "machine_file: \"els-03\"";
  Running run(Program("intaglio"), Arguments({"--lockstep", "--warm-up", "0"}, job),
              folder_ / "output.txt");
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.points().made(), 120u);
  EXPECT_THAT(ended.output, HasSubstr("energy      6 mJ commanded; measured"));
  EXPECT_THAT(ended.output, HasSubstr("energy      30 mJ commanded; measured"));
  ASSERT_EQ(report.pulse_energies_size(), 2);
  for (const PulseEnergyReport& energy : report.pulse_energies()) {
    EXPECT_EQ(energy.measured_count(), 60u);
    EXPECT_NEAR(energy.mean_mj(), energy.commanded_mj(), 0.02 * energy.commanded_mj());
  }
  // The machine's own record of the glass, x in its frame: right of the middle 6 mJ, of
  // which the splitter gives each channel a quarter.
  constexpr double kShare = 0.25;
  const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
  ASSERT_TRUE(glass) << glass.error().message;
  int counts[2] = {0, 0};
  for (const auto& crack : glass->cracks) {
    const bool is_weak = crack.pulse_energy_mj < kShare * 15;
    ++counts[is_weak];
    const double commanded_mj = is_weak ? 6 : 30;
    EXPECT_NEAR(crack.pulse_energy_mj, kShare * commanded_mj,
                0.02 * kShare * commanded_mj);
    // Model 0 lies at x 8..16 mm, model 1 at 20..28 mm.
    EXPECT_EQ(is_weak, crack.position_mm.x() > 18) << crack.position_mm.transpose();
  }
  EXPECT_EQ(counts[0], 60);
  EXPECT_EQ(counts[1], 60);
}

}  // namespace
}  // namespace intaglio
