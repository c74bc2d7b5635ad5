// Motion by hand through intaglio-motion-bridge as a process, before a virtual engraver.
// The test is the job service, the synchronizer and the client.

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <optional>
#include <thread>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/test_folder.h"

namespace intaglio::motion_bridge {
namespace {

using bus::Borrow;
using bus::View;
using test::Eventually;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

const std::string kMachine = "els-03", kSender = "a client", kNoJob;

class ManualProcess : public ::testing::Test {
 protected:
  ManualProcess()
      : folder_(test::FreshFolder()),
        engraver_(folder_,
                  "laser { rates_hz: [1, 2, 5, 10, 25, 50, 100, 200] door_lock: true }"
                  "stage { travel_min_mm { x: -2 y: -2 z: -2 }"
                  "        travel_max_mm { x: 172 y: 172 z: 172 }"
                  "        position_tolerance_um: 30 }"),
        bus_(test::PrivateBusOptions(kMachine)),
        commands_(bus_, bus::kManualCommand, kMachine),
        states_(bus_, bus::kManualState, kMachine),
        permissions_(bus_, bus::kPermission, kMachine),
        interlocks_(bus_, bus::kInterlock, kMachine) {}

  void SetUp() override {
    ASSERT_TRUE(engraver_.AwaitReady()) << engraver_.program().Output();
    const auto profile = folder_ / "machine.textproto";
    std::filesystem::copy_file(
        std::filesystem::path(INTAGLIO_SOURCE_DIR) / "deploy/machines/els-03.textproto",
        profile);
    ASSERT_NO_FATAL_FAILURE(StartBridge());
    begun_at_ = number_;
  }
  void StartBridge() {
    refusal_ = "no state came";
    bridge_.emplace(intaglio::testing::Program("intaglio-motion-bridge").string(),
                    std::vector<std::string>{
                        "--machine", (folder_ / "machine.textproto").string(), "--device",
                        engraver_.motion_line(), "--tag", test::PrivateTag(), "--cell",
                        kMachine, "--log-level", "error"});
    ASSERT_TRUE(Eventually([&] {
      Beat();
      return commands_.matched_count() > 0 && permissions_.matched_count() > 0 &&
             interlocks_.matched_count() > 0 && number_ > 0 && refusal_.empty();
    })) << refusal_;
  }

  /// What the machine's other services publish, and what has come.
  void Beat(bool door_closed = true) {
    intaglio_Permission permission{};
    permission.cell = Borrow(kMachine);
    permission.job_uid = Borrow(kNoJob);
    permission.granted = armed_;
    (void)permissions_.Write(permission);
    if (!beats_interlocks_) return Take();
    intaglio_Interlock interlock{};
    interlock.cell = Borrow(kMachine);
    interlock.key_on = interlock.emergency_stop_released = interlock.laser_link_up = true;
    interlock.door_closed = door_closed;
    (void)interlocks_.Write(interlock);
    Take();
  }
  void Take() {
    states_.Take([this](const intaglio_ManualState& state) {
      number_ = state.number;
      refusal_ = View(state.refusal);
      x_mm_ = state.position[0];
      held_ = !View(state.held_by).empty();
      answer_ = state.answer;
      answered_ = state.answered_number == 0 ? 0 : state.answered_number - begun_at_;
      message_ = View(state.message);
    });
  }
  /// `number`: of the order, from 1, of those that begin at the state begun_at_.
  void Send(intaglio_ManualCommandKind kind, std::uint64_t number,
            const Vec3& place = Vec3(1, 0, 0)) {
    intaglio_ManualCommand command{};
    command.cell = Borrow(kMachine);
    command.sender = Borrow(kSender);
    command.number = begun_at_ + number;
    command.seen = number_;
    command.kind = kind;
    command.place[0] = place.x(), command.place[1] = place.y(),
    command.place[2] = place.z();
    command.speed_mm_s = speed_mm_s_;
    command.channel = 1;
    command.sets = 7;
    const std::string lens = "f43";
    command.lens = Borrow(lens);
    (void)commands_.Write(command);
  }
  /// Held until the condition is true.
  bool HoldUntil(intaglio_ManualCommandKind kind, std::uint64_t number,
                 const std::function<bool()>& condition) {
    return Eventually([&] {
      Beat();
      Send(kind, number);
      return condition();
    });
  }
  bool BeginJog(std::uint64_t number) {
    return HoldUntil(intaglio_MANUAL_JOG, number, [&] { return held_ && x_mm_ > 2; });
  }
  /// Where the machine itself has its stage.
  double StageX() const {
    const std::string status = engraver_.Ask("status"), name = "\"stage_mm\": [";
    const auto at = status.find(name);
    return at == std::string::npos ? std::nan("")
                                   : std::stod(status.substr(at + name.size()));
  }
  bool StageRuns() { return engraver_.StatusOf("running") == "true"; }

  std::filesystem::path folder_;
  virtual_engraver::EngraverProcess engraver_;
  bus::Bus bus_;
  bus::Writer<intaglio_ManualCommand> commands_;
  bus::Reader<intaglio_ManualState> states_;
  bus::Writer<intaglio_Permission> permissions_;
  bus::Writer<intaglio_Interlock> interlocks_;
  std::optional<test::ChildProgram> bridge_;
  bool armed_ = false, held_ = false, beats_interlocks_ = true;
  double speed_mm_s_ = 20;
  std::uint64_t number_ = 0, answered_ = 0, begun_at_ = 0;
  std::string refusal_ = "no state came", message_;
  double x_mm_ = 0;
  intaglio_ManualAnswer answer_ = intaglio_MANUAL_DONE;
};

// 200 ms, braking from 20 mm/s at 700 mm/s^2 (29 ms), and what a computer under load and
// the panel add.
TEST_F(ManualProcess, AClientThatIsKilledStopsTheStage) {
  ASSERT_TRUE(BeginJog(1)) << message_;
  const auto last_command = Clock::now();
  ASSERT_TRUE(Eventually([&] {
    Beat();
    return !StageRuns();
  }));
  EXPECT_LT(Clock::now() - last_command, 200ms + 30ms + 300ms);
  EXPECT_LT(x_mm_, 60) << "it did not come to its limit";
}

TEST_F(ManualProcess, ABridgeThatIsKilledStopsTheStage) {
  ASSERT_TRUE(BeginJog(1)) << message_;
  bridge_.reset();
  EXPECT_TRUE(Eventually([&] { return !StageRuns(); }, 2s));
}

// It has all that it needs to move again but a fresh word.
TEST_F(ManualProcess, ABridgeThatIsStartedAgainMovesNothingThatIsStillHeld) {
  ASSERT_TRUE(BeginJog(1)) << message_;
  bridge_.reset();
  ASSERT_TRUE(Eventually([&] { return !StageRuns(); }, 2s));
  const double at_mm = StageX();
  ASSERT_NO_FATAL_FAILURE(StartBridge());
  bool is_refused = false;
  for (const auto end = Clock::now() + 3s; Clock::now() < end;) {
    Beat();
    Send(intaglio_MANUAL_JOG, 1);
    is_refused |= answered_ == 1 && answer_ == intaglio_MANUAL_REFUSED;
    ASSERT_FALSE(StageRuns());
    std::this_thread::sleep_for(20ms);
  }
  EXPECT_TRUE(is_refused) << message_;
  EXPECT_NE(message_.find("started again"), std::string::npos) << message_;
  EXPECT_NEAR(StageX(), at_mm, 0.1);
  begun_at_ = number_;
  EXPECT_TRUE(BeginJog(1)) << message_;
}

class LostSynchronizer : public ManualProcess,
                         public ::testing::WithParamInterface<int> {};

// Killed or hanging. At 50 mm/s: 150 ms without a report (7.5 mm), braking at 700 mm/s^2
// (1.8 mm), and 100 ms for the report under way, the lines and a computer under load (5
// mm). The stage's place is the machine's own.
TEST_P(LostSynchronizer, StopsTheStageWithin150ms) {
  test::ChildProgram synchronizer(
      intaglio::testing::Program("intaglio-synchronizer").string(),
      {"--machine", (folder_ / "machine.textproto").string(), "--device",
       engraver_.laser_line(), "--tag", test::PrivateTag(), "--cell", kMachine,
       "--log-level", "error"});
  beats_interlocks_ = false;
  speed_mm_s_ = 50;
  // Its reports and no others hold the motion from here on.
  std::uint64_t jog = 0;
  ASSERT_TRUE(Eventually([&] {
    Beat();
    if (answered_ == jog && answer_ != intaglio_MANUAL_ACCEPTED) ++jog;
    Send(intaglio_MANUAL_JOG, jog);
    return held_ && x_mm_ > 20;
  })) << message_;
  EXPECT_NE(message_.find("at 50 mm/s at most 7.5 mm"), std::string::npos)
      << "the answer as it begins: " << message_;
  const double killed_at_mm = StageX();
  synchronizer.Signal(GetParam());
  ASSERT_TRUE(Eventually([&] {
    Beat();
    Send(intaglio_MANUAL_JOG, jog);
    return !StageRuns();
  }));
  EXPECT_LT(StageX() - killed_at_mm, 7.5 + 1.8 + 5);
  ASSERT_TRUE(Eventually([&] {
    Beat();
    return answered_ == jog && answer_ == intaglio_MANUAL_STOPPED;
  }));
  EXPECT_NE(message_.find("at 50 mm/s at most 7.5 mm"), std::string::npos) << message_;
}

INSTANTIATE_TEST_SUITE_P(By, LostSynchronizer, ::testing::Values(SIGKILL, SIGSTOP),
                         [](const auto& one) {
                           return one.param == SIGKILL ? "kill" : "a_hang";
                         });

TEST_F(ManualProcess, AnOpenDoorAndAnArmedJobEndAndRefuseTheJog) {
  ASSERT_TRUE(BeginJog(1)) << message_;
  ASSERT_TRUE(Eventually([&] {
    Beat(false);
    Send(intaglio_MANUAL_JOG, 1);
    return answered_ == 1 && answer_ == intaglio_MANUAL_STOPPED;
  }));
  EXPECT_NE(message_.find("door"), std::string::npos) << message_;
  armed_ = true;
  ASSERT_TRUE(HoldUntil(intaglio_MANUAL_JOG, 2, [&] {
    return answered_ == 2 && answer_ == intaglio_MANUAL_REFUSED;
  }));
  EXPECT_NE(message_.find("armed"), std::string::npos) << message_;
  ASSERT_TRUE(HoldUntil(intaglio_TEACH_ZERO, 3, [&] { return answered_ == 3; }));
  EXPECT_EQ(answer_, intaglio_MANUAL_REFUSED) << "a zero is taught under an armed job";
}

TEST_F(ManualProcess, AZeroIsSavedWhereTheAxesAreAndUndone) {
  const auto profile = folder_ / "machine.textproto";
  const std::string before = test::ContentOf(profile);
  ASSERT_TRUE(BeginJog(1)) << message_;
  ASSERT_TRUE(Eventually([&] {
    Beat();
    Send(intaglio_MANUAL_NONE, 1);
    return answered_ == 1 && answer_ == intaglio_MANUAL_STOPPED;
  }));
  ASSERT_TRUE(HoldUntil(intaglio_TEACH_ZERO, 2, [&] { return answered_ == 2; }));
  EXPECT_EQ(answer_, intaglio_MANUAL_DONE) << message_;
  EXPECT_NE(test::ContentOf(profile).find("taught {"), std::string::npos);
  ASSERT_TRUE(HoldUntil(intaglio_TEACH_UNDO, 3, [&] { return answered_ == 3; }));
  EXPECT_EQ(answer_, intaglio_MANUAL_DONE) << message_;
  EXPECT_EQ(test::ContentOf(profile).find("zeros"), std::string::npos);
}

// The zero is taught where the axes are; away from it, and back by its name.
TEST_F(ManualProcess, GoesToTheZeroThatWasTaughtAndNoFurtherThanItIsHeld) {
  const auto ended = [&](std::uint64_t number) {
    return answered_ == number && answer_ != intaglio_MANUAL_ACCEPTED;
  };
  ASSERT_TRUE(HoldUntil(intaglio_MANUAL_MOVE, 1, [&] { return ended(1); }));
  ASSERT_EQ(answer_, intaglio_MANUAL_DONE) << message_;
  const double taught_mm = x_mm_;
  ASSERT_NEAR(taught_mm, 1, 1e-3);
  const auto teach = [&](std::uint64_t number) {
    return Eventually([&] {
      Beat();
      Send(intaglio_TEACH_ZERO, number, Vec3::Zero());
      return answered_ == number;
    });
  };
  ASSERT_TRUE(teach(2));
  ASSERT_EQ(answer_, intaglio_MANUAL_DONE) << message_;
  ASSERT_TRUE(HoldUntil(intaglio_MANUAL_JOG, 3, [&] { return held_ && x_mm_ > 6; }));
  ASSERT_TRUE(Eventually([&] {
    Beat();
    Send(intaglio_MANUAL_NONE, 3);
    return ended(3);
  }));
  // Let go on the way: it rests before the zero.
  const auto to_zero = [&](std::uint64_t number, const std::function<bool()>& until) {
    return Eventually([&] {
      Beat();
      Send(intaglio_MANUAL_ZERO, number, Vec3::Zero());
      return until();
    });
  };
  ASSERT_TRUE(to_zero(4, [&] { return held_ && x_mm_ < 5; }));
  ASSERT_TRUE(Eventually([&] {
    Beat();
    Send(intaglio_MANUAL_NONE, 4);
    return ended(4);
  }));
  EXPECT_EQ(answer_, intaglio_MANUAL_STOPPED);
  EXPECT_GT(x_mm_, taught_mm + 0.5);
  ASSERT_TRUE(to_zero(5, [&] { return ended(5); }));
  EXPECT_EQ(answer_, intaglio_MANUAL_DONE) << message_;
  EXPECT_NEAR(x_mm_, taught_mm, 1e-3);
}

TEST_F(ManualProcess, AZeroOutsideTheLimitsIsNotGoneTo) {
  // 1000 mm above the table.
  ASSERT_TRUE(Eventually([&] {
    Beat();
    Send(intaglio_MANUAL_ZERO, 1, Vec3(0, 0, 1000));
    return answered_ == 1;
  }));
  EXPECT_EQ(answer_, intaglio_MANUAL_REFUSED);
  EXPECT_NE(message_.find("outside the limits"), std::string::npos) << message_;
  EXPECT_FALSE(StageRuns());
}

}  // namespace
}  // namespace intaglio::motion_bridge
