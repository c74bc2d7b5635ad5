// intaglio-motion-bridge as a process, between the bus and a virtual engraver.

#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>
#include <optional>

#include "services/job/files/job_file.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/services/virtual_engraver/taken_line.h"
#include "tests/test_folder.h"

namespace intaglio::motion_bridge {
namespace {

using bus::Borrow;
using bus::View;
using test::Eventually;
using namespace std::chrono_literals;

const std::string kCell = "els-03";
constexpr std::uint32_t kTick = 65536;  // subticks

std::filesystem::path ProfileFile() {
  return std::filesystem::path(INTAGLIO_SOURCE_DIR) / "deploy/machines/els-03.textproto";
}

/// Segments of one batch: end positions and velocities along x, mm and mm/s.
struct Piece {
  std::vector<double> x_mm, vx_mm_s;
  std::vector<std::uint32_t> subticks;
};

class BridgeProcess : public ::testing::Test {
 protected:
  explicit BridgeProcess(const std::string& tolerance_um = "30")
      : folder_(test::FreshFolder()),
        engraver_(folder_,
                  "stage { travel_min_mm { x: -2 y: -2 z: -2 }"
                  "        travel_max_mm { x: 172 y: 172 z: 172 }"
                  "        position_tolerance_um: " +
                      tolerance_um + " }"),
        bus_(test::PrivateBusOptions(kCell)),
        batches_(bus_, bus::kMotionSegmentBatch, kCell),
        stops_(bus_, bus::kEmergencyStop, kCell),
        states_(bus_, bus::kMotionState, kCell),
        positions_(bus_, bus::kPositionReport, kCell),
        alarms_(bus_, bus::kAlarm) {}

  void SetUp() override {
    ASSERT_TRUE(engraver_.AwaitReady()) << engraver_.program().Output();
    StartBridge();
    ASSERT_TRUE(Eventually([&] {
      return batches_.matched_count() > 0 && stops_.matched_count() > 0 && Read() &&
             state_->fault == intaglio_MOTION_OK;
    }));
  }
  void StartBridge() {
    bridge_.emplace(
        intaglio::testing::Program("intaglio-motion-bridge").string(),
        std::vector<std::string>{"--machine", ProfileFile().string(), "--device",
                                 engraver_.motion_line(), "--tag", test::PrivateTag(),
                                 "--cell", kCell, "--log-level", "error"});
  }
  /// The newest state that the bridge published; false before there is one.
  bool Read() {
    states_.Take([this](const intaglio_MotionState& sample) {
      state_ = sample;
      state_->cell = state_->message = nullptr;  // valid inside this call only
      message_ = View(sample.message);
    });
    return state_.has_value();
  }
  bool UntilState(const std::function<bool(const intaglio_MotionState&)>& condition,
                  std::chrono::milliseconds bound = 15s) {
    return Eventually([&] { return Read() && condition(*state_); }, bound);
  }

  void Write(std::uint32_t run, std::uint64_t number, std::uint64_t start_tick,
             const Piece& piece, bool last, bool abort = false) {
    const std::vector<double> zero(piece.x_mm.size(), 0.0);
    const std::vector<std::uint8_t> no_pulse(piece.x_mm.size(), 0);
    intaglio_MotionSegmentBatch batch{};
    batch.job_uid = Borrow(kJob);
    batch.run = run;
    batch.sequence_number = number;
    batch.start_tick = start_tick;
    batch.abort = abort;
    batch.last = last;
    Borrow(batch.x_mm, piece.x_mm);
    Borrow(batch.y_mm, zero);
    Borrow(batch.z_mm, zero);
    Borrow(batch.vx_mm_s, piece.vx_mm_s);
    Borrow(batch.vy_mm_s, zero);
    Borrow(batch.vz_mm_s, zero);
    Borrow(batch.duration_subticks, piece.subticks);
    Borrow(batch.pulse, no_pulse);
    EXPECT_TRUE(batches_.Write(batch).has_value());
  }
  /// A run to 170 mm that lasts more than half a minute; true when it is under way.
  bool StartLongRun(std::uint32_t run) {
    // A second: a run that comes too late to the stage is refused.
    const std::uint64_t start = state_->tick + 100;
    Write(run, 0, start, {{0.5}, {5}, {20 * kTick}}, false);
    Write(run, 1, start, {{170}, {0}, {4000 * kTick}}, true);
    return UntilState([&](const intaglio_MotionState& s) {
      return s.run == run && !s.at_rest && s.x_mm > 0.6 && s.vx_mm_s > 1;
    });
  }
  /// True when the stage stops, and stays, short of the end of the long run, which is
  /// half a minute away. How long that takes is not judged: the computer may be busy.
  bool StageComesToRest() {
    if (!Eventually([&] { return engraver_.StatusOf("running") == "false"; }, 15s))
      return false;
    const std::string at = engraver_.StatusOf("stage_mm");
    std::this_thread::sleep_for(50ms);  // five ticks in which it may not move
    return !at.empty() && engraver_.StatusOf("stage_mm") == at;
  }

  const std::string kJob = "job-of-the-bridge-test";
  std::filesystem::path folder_;
  virtual_engraver::EngraverProcess engraver_;
  bus::Bus bus_;
  bus::Writer<intaglio_MotionSegmentBatch> batches_;
  bus::Writer<intaglio_EmergencyStop> stops_;
  bus::Reader<intaglio_MotionState> states_;
  bus::Reader<intaglio_PositionReport> positions_;
  bus::Reader<intaglio_Alarm> alarms_;
  std::optional<test::ChildProgram> bridge_;
  std::optional<intaglio_MotionState> state_;
  std::string message_;
};

TEST_F(BridgeProcess, HandsARunToTheStageAndItsPositionsBack) {
  const std::uint64_t start = state_->tick + 150;
  // Speeds up to 10 mm/s within 5 ticks, 0.1 mm a tick, and stops again.
  Write(1, 0, start, {{0.25, 0.35, 0.45}, {10, 10, 10}, {5 * kTick, kTick, kTick}},
        false);
  Write(1, 1, start, {{0.55, 0.8}, {10, 0}, {kTick, 5 * kTick}}, true);
  std::vector<double> x_mm;
  std::uint64_t next_tick = start + 1, next_number = 0;
  ASSERT_TRUE(Eventually([&] {
    positions_.Take([&](const intaglio_PositionReport& report) {
      EXPECT_EQ(report.run, 1u);
      EXPECT_EQ(report.sequence_number, next_number++);
      EXPECT_EQ(report.first_tick, next_tick);
      next_tick += View(report.x_mm).size();
      for (const double x : View(report.x_mm)) x_mm.push_back(x);
    });
    return x_mm.size() >= 13;
  }));
  ASSERT_EQ(x_mm.size(), 13u);
  // Exact to a nanometre: the stage has no lag.
  const std::vector<std::pair<std::size_t, double>> planned = {
      {4, 0.25}, {5, 0.35}, {6, 0.45}, {7, 0.55}, {12, 0.8}};
  for (const auto& [tick, x] : planned) EXPECT_NEAR(x_mm[tick], x, 1.1e-6) << tick;
  EXPECT_TRUE(UntilState([](const auto& s) { return s.at_rest && s.run == 1; }));
  EXPECT_EQ(state_->fault, intaglio_MOTION_OK);
  EXPECT_NEAR(state_->x_mm, 0.8, 1.1e-6);
}

// The stage reports every 20 ms that nothing has changed. A busy computer only makes the
// samples come later.
TEST_F(BridgeProcess, RepeatsTheStateOfAStageThatRestsTenTimesASecond) {
  ASSERT_TRUE(UntilState([](const auto& state) { return state.at_rest; }));
  int samples = 0;
  const auto count = [&](const intaglio_MotionState&) { ++samples; };
  const auto begin = std::chrono::steady_clock::now();
  ASSERT_TRUE(Eventually([&] {
    states_.Take(count);
    return samples >= 11;
  }));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, 10 * 90ms);
}

TEST_F(BridgeProcess, KilledItLeavesAStageThatComesToRestByItself) {
  ASSERT_TRUE(StartLongRun(1));
  ASSERT_EQ(engraver_.StatusOf("running"), "true");
  bridge_->Kill();
  EXPECT_TRUE(StageComesToRest());
  // The next bridge reports what happened, and clears it for a new run.
  state_.reset();
  StartBridge();
  ASSERT_TRUE(
      UntilState([](const auto& s) { return s.fault == intaglio_MOTION_STARVED; }));
  EXPECT_NE(message_.find("250 ms"), std::string::npos) << message_;
  EXPECT_GE(state_->highest_run, 1u);
  ASSERT_TRUE(Eventually([&] { return batches_.matched_count() > 0; }));
  // Three seconds ahead: a run that comes too late to the stage is refused.
  Write(2, 0, state_->tick + 300, {{state_->x_mm}, {0}, {5 * kTick}}, true);
  EXPECT_TRUE(UntilState([](const auto& s) {
    return s.run == 2 && s.at_rest && s.fault == intaglio_MOTION_OK;
  }));
}

TEST_F(BridgeProcess, AnAbortBrakesTheStage) {
  ASSERT_TRUE(StartLongRun(1));
  Write(1, 2, 0, {}, false, true);
  EXPECT_TRUE(StageComesToRest());
  EXPECT_TRUE(UntilState([](const auto& s) { return s.at_rest; }));
  if (message_.find("250 ms") != std::string::npos)
    GTEST_SKIP() << "this computer left the line silent: " << message_;
  EXPECT_EQ(state_->fault, intaglio_MOTION_OK) << "an abort is no fault";
}

TEST_F(BridgeProcess, AnEmergencyStopBrakesTheStage) {
  ASSERT_TRUE(StartLongRun(1));
  const std::string source = "test", reason = "a hand";
  intaglio_EmergencyStop stop{};
  stop.cell = Borrow(kCell);
  stop.pressed = true;
  stop.source = stop.operator_name = Borrow(source);
  stop.reason = Borrow(reason);
  stop.number = 1;
  ASSERT_TRUE(stops_.Write(stop).has_value());
  EXPECT_TRUE(StageComesToRest());
  // While it is pressed no run begins.
  Read();
  Write(2, 0, state_->tick + 30, {{state_->x_mm}, {0}, {5 * kTick}}, true);
  EXPECT_FALSE(UntilState([](const auto& s) { return s.run == 2; }, 200ms));
}

TEST_F(BridgeProcess, AMissingBatchAbortsTheRunAndRaisesAnAlarm) {
  ASSERT_TRUE(StartLongRun(1));
  const std::uint64_t start = state_->tick + 100;
  Write(2, 0, start, {{state_->x_mm}, {0}, {5 * kTick}}, false);
  Write(2, 2, start, {{state_->x_mm}, {0}, {5 * kTick}}, true);
  std::string code, message;
  EXPECT_TRUE(Eventually([&] {
    alarms_.Take([&](const intaglio_Alarm& alarm) {
      code = View(alarm.code);
      message = View(alarm.message);
    });
    return !code.empty();
  }));
  EXPECT_EQ(code, "link_lost");
  EXPECT_NE(message.find("batch 1 of run 2"), std::string::npos) << message;
  EXPECT_TRUE(StageComesToRest());
}

// The stage is far from the end of the first batch, so nothing more was granted.
TEST_F(BridgeProcess, BatchesBeyondTheCreditAbortTheRunAndRaiseAnAlarm) {
  ASSERT_TRUE(StartLongRun(1));
  const std::uint64_t start = state_->tick + 100;
  const std::vector<double> still(100, state_->x_mm);
  for (std::uint64_t i = 0; i < 200; ++i)
    Write(2, i, start,
          {still, std::vector<double>(100, 0), std::vector<std::uint32_t>(100, kTick)},
          false);
  std::string code, message;
  EXPECT_TRUE(Eventually([&] {
    alarms_.Take([&](const intaglio_Alarm& alarm) {
      code = View(alarm.code);
      message = View(alarm.message);
    });
    return !code.empty();
  }));
  EXPECT_EQ(code, "fault");
  EXPECT_NE(message.find("exceeds the granted credit"), std::string::npos) << message;
  EXPECT_TRUE(StageComesToRest());
}

TEST_F(BridgeProcess, ALineThatIsGoneIsAFaultInItsState) {
  engraver_.program().Signal(SIGKILL);
  EXPECT_TRUE(
      UntilState([](const auto& s) { return s.fault == intaglio_MOTION_LINK_LOST; }));
  EXPECT_NE(message_.find("motion line"), std::string::npos) << message_;
  EXPECT_TRUE(bridge_->running());
}

TEST_F(BridgeProcess, WhoseStageIsTakenOverEndsWithAFault) {
  ASSERT_TRUE(virtual_engraver::TakeLineOver(engraver_.motion_line()));
  std::string code, message;
  EXPECT_TRUE(Eventually([&] {
    alarms_.Take([&](const intaglio_Alarm& alarm) {
      code = View(alarm.code);
      message = View(alarm.message);
    });
    return !code.empty();
  }));
  EXPECT_EQ(code, "taken_over");
  EXPECT_EQ(message,
            "another motion bridge has taken over this machine; this process ends");
  EXPECT_EQ(bridge_->ExitCode(), 4);
}

/// A stage that is more exact than the profile.
class BridgeOfAnExactStage : public BridgeProcess {
 protected:
  BridgeOfAnExactStage() : BridgeProcess("10") {}
};

TEST_F(BridgeOfAnExactStage, ReportsTheMismatchOfTheTolerances) {
  EXPECT_TRUE(UntilState([](const auto& s) { return s.position_tolerance_um == 10; }));
  bus::Reader<intaglio_ServiceHealth> healths(bus_, bus::kServiceHealth);
  std::string message;
  intaglio_HealthState state = intaglio_HEALTH_STARTING;
  EXPECT_TRUE(Eventually([&] {
    healths.Take([&](const intaglio_ServiceHealth& health) {
      if (health.role != intaglio_ROLE_MOTION_BRIDGE) return;
      message = View(health.message);
      state = health.state;
    });
    return !message.empty();
  }));
  EXPECT_NE(message.find("is 10 um and that of the profile 30 um"), std::string::npos)
      << message;
  EXPECT_EQ(state, intaglio_HEALTH_READY) << "it works; a person should know of it";
}

TEST(BridgeOptions, AnUnknownDriverNamesWhatThereIs) {
  const auto folder = test::FreshFolder();
  auto machine = ReadMachineFile(ProfileFile());
  ASSERT_TRUE(machine.has_value());
  machine->mutable_motion_line()->set_protocol("no-such-family");
  ASSERT_TRUE(WriteMachineFile(folder / "other.textproto", *machine).has_value());
  intaglio::testing::Running bridge(
      intaglio::testing::Program("intaglio-motion-bridge"),
      {"--machine", folder / "other.textproto", "--tag", test::PrivateTag()},
      folder / "bridge.log");
  const auto ended = bridge.WaitForEnd(5s);
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_NE(ended.output.find("virtual-stage"), std::string::npos) << ended.output;
}

}  // namespace
}  // namespace intaglio::motion_bridge
