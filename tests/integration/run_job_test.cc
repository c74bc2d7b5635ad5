// The whole product at work: `intaglio run` as a user types it, with its separate
// processes, and what the machine does when something is taken away in mid-job.

#include "tests/integration/run_job.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <thread>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using ::testing::HasSubstr;
using testing::kBound;
using testing::ProcessesWith;
using testing::Program;
using testing::RunJob;
using testing::Running;

const std::vector<std::string> kServices = {
    "intaglio-job-service", "intaglio-discretizer", "intaglio-sorter",
    "intaglio-synchronizer", "intaglio-motion-bridge"};

TEST_F(RunJob, EngravesTheSampleAndProvesItInTheGlass) {
  const Ended run = Run({"--lockstep"});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  for (const char* file : {"report.json", "glass.ply", "path.ply", "views.png"}) {
    EXPECT_TRUE(fs::exists(folder_ / "out" / file)) << file;
  }
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_GT(report.points().planned(), 1000u);
  EXPECT_EQ(report.points().made(), report.points().planned());
  EXPECT_EQ(report.points().doubled() + report.points().stray() +
                report.points().skipped() + report.points().missed() +
                report.points().unaccounted(),
            0u);
  EXPECT_EQ(report.shadow_violations(), 0u);
  // The report agrees with the files, counted here again.
  const auto glass = formats::ReadPly(folder_ / "out/glass.ply");
  const auto path = formats::ReadPly(folder_ / "out/path.ply");
  ASSERT_TRUE(glass && path);
  EXPECT_EQ(glass->points_mm.size(), report.points().planned());
  double worst = 0;
  for (std::size_t i = 0; i < path->points_mm.size(); ++i) {
    worst = std::max(worst, (glass->points_mm[i] - path->points_mm[i]).norm());
  }
  // In lockstep without pauses the cracks come in the order of the path.
  EXPECT_NEAR(1000 * worst, report.position_errors().max_um(), 1e-6);
  EXPECT_LT(1000 * worst, 20) << "the machine's tolerance, um";
  EXPECT_TRUE(NothingLeft());
}

TEST_F(RunJob, TwoRunsAreTheSameBitForBit) {
  ASSERT_EQ(Run({"--lockstep"}).exit_code, 0);
  const JobReport first = Report();
  ASSERT_EQ(Run({"--lockstep"}).exit_code, 0);
  const JobReport second = Report();
  EXPECT_EQ(first.checksums().at("path"), second.checksums().at("path"));
  EXPECT_EQ(first.checksums().at("plan"), second.checksums().at("plan"));
  EXPECT_EQ(first.ticks(), second.ticks());
}

// As on a computer that is too busy to let a process run, for longer than the leases of a
// permission (90 ms), of a line (250 ms) and of a state (500 ms) by wall time.
class StalledInLockstep : public RunJob,
                          public ::testing::WithParamInterface<const char*> {
 protected:
  const std::vector<std::string> dense_ = {"--lockstep", "--spacing", "0.25"};

  std::size_t Cracks() const {
    const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
    return glass ? glass->cracks.size() : 0;
  }
  /// A cell that took the job up again, or was paused, has begun another session or run.
  std::pair<std::size_t, std::size_t> SessionsAndRuns() const {
    std::size_t sessions = 0, runs = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "out")) {
      if (entry.path().filename() != "journal.bin") continue;
      const auto journal = formats::ReadJournal(entry.path());
      EXPECT_TRUE(journal.has_value());
      for (const formats::JournalRecord& record : journal->records) {
        sessions += record.kind == formats::JournalKind::kSession;
        runs = std::max<std::size_t>(runs, record.run);
      }
    }
    return {sessions, runs};
  }
};

TEST_P(StalledInLockstep, CostsNoTick) {
  {
    Running run(Program("intaglio"), Arguments(dense_), folder_ / "output.txt");
    ASSERT_EQ(run.WaitForEnd(250s).exit_code, 0);
  }
  const JobReport undisturbed = Report();
  const auto in_one_go = SessionsAndRuns();
  fs::remove_all(folder_ / "out");
  Running run(Program("intaglio"), Arguments(dense_), folder_ / "output.txt");
  ASSERT_TRUE(testing::Eventually([&] { return Cracks() >= 50; }, 250s));
  const auto process = ProcessesWith({GetParam(), (folder_ / "out").string()});
  ASSERT_EQ(process.size(), 1u);
  const auto stopped_at = std::chrono::steady_clock::now();
  ASSERT_EQ(kill(process.front(), SIGSTOP), 0);
  std::this_thread::sleep_for(300ms);
  const std::size_t made = Cracks();
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(Cracks(), made) << "its time goes on without " << GetParam();
  ASSERT_EQ(kill(process.front(), SIGCONT), 0);
  const auto stopped = std::chrono::steady_clock::now() - stopped_at;
  const Ended ended = run.WaitForEnd(250s);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  const JobReport late = Report();
  ASSERT_LT(made, late.points().planned()) << "the job is too short for this test";
  EXPECT_EQ(late.points().made(), undisturbed.points().made());
  // Behind the lease of a worker (bus/qos.h) its task is given anew.
  if (stopped > 1s) GTEST_SKIP() << "the computer is too busy for so short a stop";
  EXPECT_EQ(late.ticks(), undisturbed.ticks());
  EXPECT_EQ(SessionsAndRuns(), in_one_go);
}

INSTANTIATE_TEST_SUITE_P(EachProcess, StalledInLockstep,
                         ::testing::Values("intaglio-job-service",
                                           "intaglio-synchronizer",
                                           "intaglio-motion-bridge", "virtual-engraver"),
                         [](const auto& row) {
                           std::string name = row.param;
                           std::erase(name, '-');
                           return name;
                         });

// The stage on a clock of its own, every line late by up to 2 ms: the proof is in the
// glass all the same.
class FreeClock : public RunJob,
                  public ::testing::WithParamInterface<std::vector<std::string>> {};

TEST_P(FreeClock, KeepsEveryPulseInItsPlace) {
  std::vector<std::string> more = GetParam();
  more.insert(more.end(), {"--clock-drift", "150", "--line-jitter", "2"});
  const Ended run = Run(more);
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_GT(report.points().planned(), 500u);
  EXPECT_EQ(report.points().made(), report.points().planned());
  EXPECT_EQ(report.points().doubled() + report.points().stray(), 0u);
  EXPECT_EQ(report.shadow_violations(), 0u);
  EXPECT_LT(report.position_errors().rms_um(), 5);
}

INSTANTIATE_TEST_SUITE_P(
    EveryTime, FreeClock,
    ::testing::Values(std::vector<std::string>{"--lockstep"},
                      // 2 ms of a line are 10 ms of this machine.
                      std::vector<std::string>{"--speed", "5", "--warm-up", "5",
                                               "--spacing", "1.2"}),
    [](const auto& suite) { return suite.param.size() == 1 ? "lockstep" : "real_time"; });

TEST_F(RunJob, ASpeedOverrideInMidJobCostsTimeAndNoPoint) {
  const std::string tag = "speed-" + std::to_string(getpid());
  const auto type = [&](const std::string& percent) {
    Running command(Program("intaglio"), {"speed", "1", percent, "--tag", tag},
                    folder_ / "speed.txt");
    return command.WaitForEnd(kBound);
  };
  Running run(
      Program("intaglio"),
      Arguments({"--speed", "5", "--warm-up", "0", "--spacing", "1.2", "--tag", tag}),
      folder_ / "output.txt");
  ASSERT_TRUE(AwaitCracks(50));
  for (const char* wrong : {"0", "141", "-30", "30.5", "fast"}) {
    const Ended refused = type(wrong);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.output, HasSubstr(wrong));
  }
  EXPECT_THAT(type("0").output, HasSubstr("'0': give a whole number from 1 to 140"));
  const Ended slower = type("30");
  EXPECT_EQ(slower.exit_code, 0) << slower.output;
  EXPECT_EQ(type("140").exit_code, 0);
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time);
  ASSERT_EQ(ended.exit_code, 0) << ended.output;
  const JobReport report = Report();
  EXPECT_EQ(report.points().made(), report.points().planned());
  EXPECT_EQ(report.points().doubled() + report.points().stray(), 0u);
  EXPECT_EQ(report.engrave().min_speed_percent(), 30u);
  EXPECT_EQ(report.engrave().max_speed_percent(), 140u);
  EXPECT_EQ(report.engrave().speed_changes(), 2u);
}

TEST_F(RunJob, ServicesAreSeparateProcesses) {
  Running run(Program("intaglio"), Arguments({"--speed", "1", "--warm-up", "0"}),
              folder_ / "output.txt");
  ASSERT_TRUE(AwaitCracks(5));
  for (const std::string& service : kServices) {
    EXPECT_EQ(ProcessesWith({service, "run-" + std::to_string(run.pid())}).size(), 1u)
        << service;
  }
  run.Signal(SIGINT);
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time);
  EXPECT_EQ(ended.exit_code, 5) << ended.output;
  EXPECT_TRUE(NothingLeft());
}

// Whatever dies: it is started again, and the job goes on to its end; no point is made
// twice, and none is left out.
class KillOne : public RunJob, public ::testing::WithParamInterface<std::string> {};

TEST_P(KillOne, CostsAPauseAndNoPoint) {
  Running run(Program("intaglio"),
              Arguments({"--height", "5", "--speed", "4", "--warm-up", "0"}),
              folder_ / "output.txt");
  ASSERT_TRUE(AwaitCracks(20));
  const auto victims = ProcessesWith({GetParam(), "run-" + std::to_string(run.pid())});
  ASSERT_EQ(victims.size(), 1u);
  kill(victims[0], SIGKILL);
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output,
              HasSubstr(GetParam().substr(std::string("intaglio-").size()) +
                        " has ended unexpectedly (exit code 137) and was restarted"));
  EXPECT_TRUE(NothingLeft());
  const JobReport report = Report();
  EXPECT_EQ(report.points().doubled(), 0u);
  EXPECT_EQ(report.points().stray(), 0u);
  EXPECT_EQ(report.points().unaccounted(), 0u);
  EXPECT_EQ(report.points().made(), report.points().planned());
}

INSTANTIATE_TEST_SUITE_P(EveryService, KillOne, ::testing::ValuesIn(kServices),
                         [](const auto& suite) {
                           std::string name = suite.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// The lost attempt disarms the job. No other job can have had this machine, so the run
// arms it once more.
TEST_F(RunJob, ASorterLostBeforeTheGlassIsTouchedCostsAnAttempt) {
  Running run(Program("intaglio"),
              Arguments({"--lockstep", "--height", "20", "--spacing", "0.12"}),
              folder_ / "output.txt");
  ASSERT_TRUE(testing::Eventually(
      [&] {
        return testing::TextIn(folder_ / "out/session/sorter.log").find("accepted") !=
               std::string::npos;
      },
      30s));
  const auto sorters =
      ProcessesWith({"intaglio-sorter", "run-" + std::to_string(run.pid())});
  ASSERT_EQ(sorters.size(), 1u);
  kill(sorters[0], SIGKILL);
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("attempt 1 failed: sorter"));
  EXPECT_TRUE(Report().verdict().good());
}

// A stage that has stopped by itself, for want of motion or for a gap in it, is no matter
// for a person: it is reset, and the job goes on.
class StageStop : public RunJob, public ::testing::WithParamInterface<const char*> {};

TEST_P(StageStop, CostsARunAndNoPoint) {
  Running run(Program("intaglio"), Arguments({"--lockstep", "--warm-up", "0"}),
              folder_ / "output.txt");
  ASSERT_TRUE(AwaitCracks(20));
  ASSERT_THAT(Press(std::string("buffer ") + GetParam()), HasSubstr("ok"));
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_GE(Report().engrave().run_count(), 2u) << "or the test tests nothing";
  EXPECT_TRUE(Report().verdict().good());
}

INSTANTIATE_TEST_SUITE_P(OfItsBuffer, StageStop, ::testing::Values("starved", "full"),
                         [](const auto& suite) { return std::string(suite.param); });

// Faults of a machine in mid-job, and a text that the message of each has to contain.
struct Mishap {
  const char* name;
  const char* command;
  const char* word;
};
class MachineFault : public RunJob, public ::testing::WithParamInterface<Mishap> {};

TEST_P(MachineFault, PausesSafelyAndNamesTheRemedy) {
  Running run(Program("intaglio"), Arguments({"--speed", "1", "--warm-up", "0"}),
              folder_ / "output.txt");
  ASSERT_TRUE(AwaitCracks(20));
  ASSERT_THAT(Press(GetParam().command), HasSubstr("ok"));
  const Ended ended = run.WaitForEnd(kBound);
  ASSERT_TRUE(ended.in_time) << ended.output;
  EXPECT_EQ(ended.exit_code, 4) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr(GetParam().word));
  EXPECT_TRUE(NothingLeft());
  EXPECT_EQ(Report().points().doubled(), 0u);
  EXPECT_EQ(Report().points().stray(), 0u);
}

INSTANTIATE_TEST_SUITE_P(
    EveryMishap, MachineFault,
    ::testing::Values(Mishap{"laser_unplugged", "unplug laser", "laser line"},
                      Mishap{"motion_unplugged", "unplug motion", "line"},
                      Mishap{"door_forced", "door force", "door"},
                      Mishap{"stop_pressed", "estop press", "stop"},
                      Mishap{"key_turned", "key off", "key"}),
    [](const auto& suite) { return suite.param.name; });

}  // namespace
}  // namespace intaglio
