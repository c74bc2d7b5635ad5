// A motion line that leads to another stage controller than the profile names.

#include <gtest/gtest.h>

#include <functional>

#include "services/drivers/motion_drivers.h"
#include "tests/integration/run_program.h"
#include "tests/services/drivers/fake_stage.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

class ExpectedStage : public ::testing::Test {
 protected:
  ExpectedStage()
      : device(test::FreshFolder() / "motion"),
        stage(device, 100),
        driver(MakeMotionDriver(Profile()).value()) {}

  MachineSpec Profile() const {
    MachineSpec machine;
    machine.set_name("els-03");
    machine.mutable_motion_line()->set_protocol("virtual-stage");
    machine.mutable_motion_line()->set_device(device);
    machine.mutable_motion_line()->set_baud(115200);
    machine.mutable_motion_line()->set_serial_number("S-03");
    return machine;
  }
  bool Until(const std::function<bool()>& condition,
             std::chrono::milliseconds bound = 3s) {
    return intaglio::testing::Eventually(
        [&] {
          driver->Poll();
          stage.Poll();
          return condition();
        },
        bound);
  }
  void Settle(std::chrono::milliseconds time) {
    (void)Until([] { return false; }, time);
  }
  bool Connect() {
    return Until([&] {
      return driver->state().link_up && driver->state().fault == intaglio_MOTION_OK;
    });
  }
  std::string Refusal() const {
    return "the line at " + device.string() +
           " leads to stage controller 'S-17', the profile of els-03 expects 'S-03': "
           "swap "
           "the cables or correct motion_line.serial_number";
  }
  bool Refused() {
    return Until(
        [&] { return driver->state().fault == intaglio_MOTION_WRONG_CONTROLLER; });
  }
  /// And nothing but the abort reaches it.
  void ExpectNoMotion() {
    const DriverState& state = driver->state();
    EXPECT_FALSE(state.link_up);
    EXPECT_EQ(state.message, Refusal());
    EXPECT_EQ(state.refusal, Refusal());
    EXPECT_EQ(driver->Room(), 0u);
    EXPECT_FALSE(driver->BeginRun(1, 10, 0));
    EXPECT_FALSE(driver->BeginRun(1, 10, 77));
    EXPECT_FALSE(driver->Append(std::vector{motion::Segment{}}, {}));
    EXPECT_FALSE(driver->ClearFault());
    EXPECT_FALSE(driver->AbortRun());
    Settle(100ms);
    EXPECT_TRUE(stage.begun.empty());
    EXPECT_TRUE(stage.timed_begun.empty());
    EXPECT_TRUE(stage.all_segments.empty());
    EXPECT_EQ(stage.resets, 0);
    EXPECT_EQ(stage.aborts, 1);
  }

  std::filesystem::path device;
  FakeStage stage;
  std::unique_ptr<MotionDriver> driver;
};

TEST_F(ExpectedStage, ItsStageIsTaken) { EXPECT_TRUE(Connect()); }

// The fake stage has no compare output.
TEST_F(ExpectedStage, AStageWithoutACompareOutputIsRefusedWhereThePlaceFires) {
  MachineSpec machine = Profile();
  machine.set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  driver = MakeMotionDriver(machine).value();
  ASSERT_TRUE(Refused());
  EXPECT_FALSE(driver->state().link_up);
  EXPECT_NE(driver->state().refusal.find("has no compare output: set pulse_trigger"),
            std::string::npos)
      << driver->state().refusal;
}

TEST_F(ExpectedStage, AStageThatCarriesNoBlockIsRefusedWhereTheProfileHasOne) {
  MachineSpec machine = Profile();
  machine.mutable_head_over_block()->mutable_block_stage();
  driver = MakeMotionDriver(machine).value();
  ASSERT_TRUE(Refused());
  EXPECT_FALSE(driver->state().link_up);
  EXPECT_NE(driver->state().refusal.find(
                "remove head_over_block.block_stage from the machine profile"),
            std::string::npos)
      << driver->state().refusal;
}

// By name and remedy, before a line is opened.
TEST(BlockStageOfAProfile, IsRefusedByEachDriverThatCannotMoveIt) {
  int refused = 0;
  for (const MotionDriverKind& kind : MotionDriverKinds()) {
    MachineSpec machine;
    machine.mutable_motion_line()->set_protocol(std::string(kind.protocol));
    machine.mutable_motion_line()->set_device("/dev/null");
    EXPECT_TRUE(CheckBlockStage(machine, kind)) << kind.protocol;
    machine.mutable_head_over_block()->mutable_block_stage();
    const Status checked = CheckBlockStage(machine, kind);
    EXPECT_EQ(checked.has_value(), kind.moves_block) << kind.protocol;
    if (checked) continue;
    ++refused;
    EXPECT_EQ(checked.error().message.find("head_over_block.block_stage: the driver '" +
                                           std::string(kind.protocol) + "' moves no"),
              0u)
        << checked.error().message;
    EXPECT_NE(checked.error().message.find("virtual-stage"), std::string::npos);
    EXPECT_FALSE(MakeMotionDriver(machine));
  }
  EXPECT_EQ(refused, 4);  // bjjcz, grbl, isel, linuxcnc
}

TEST_F(ExpectedStage, AnotherStageIsRefusedAndGetsNoMotion) {
  stage.serial_number = "S-17";
  stage.clock = 5;
  ASSERT_TRUE(Refused());
  stage.Send(link::MotionFrame::kPositions, Encode(link::Positions{3, 50, {{1, 2, 3}}}));
  stage.status.x_nm = 1234567;
  stage.SendStatus();
  ExpectNoMotion();
  EXPECT_TRUE(driver->TakePositions().empty());
  EXPECT_EQ(driver->state().position_mm.x(), 0);
  EXPECT_EQ(driver->state().clock, 0u);
}

TEST_F(ExpectedStage, AnotherStageAfterAReconnectIsRefusedAndTheRightOneTakenBack) {
  ASSERT_TRUE(Connect());
  const std::uint64_t number = driver->state().number;
  stage.serial_number = "S-17";
  stage.Unplug();
  Settle(20ms);
  stage.Plug();
  ASSERT_TRUE(Refused());
  EXPECT_GT(driver->state().number, number) << "the bridge publishes it at once";
  ExpectNoMotion();
  stage.serial_number = "S-03";
  stage.Unplug();
  Settle(20ms);
  stage.Plug();
  ASSERT_TRUE(Connect());
  EXPECT_EQ(driver->state().refusal, "");
  EXPECT_TRUE(driver->BeginRun(1, 10, 0));
}

}  // namespace
}  // namespace intaglio::drivers
