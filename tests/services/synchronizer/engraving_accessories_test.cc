// Outputs and inputs of a machine for other uses: on under an arm alone, and an input
// that is wrong refuses the arm and pauses the job by its name.

#include <gmock/gmock.h>

#include "services/synchronizer/outputs.h"
#include "tests/services/synchronizer/fake_cell.h"
#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

MachineSpec Shop() {
  MachineSpec machine;
  const auto output = [&machine](const char* name, std::uint32_t number, OutputTime on) {
    MachineOutput& added = *machine.add_outputs();
    added.set_name(name);
    added.set_output(number);
    added.set_on(on);
  };
  const auto input = [&machine](const char* name, std::uint32_t number, InputState state,
                                const char* remedy) {
    MachineInput& added = *machine.add_inputs();
    added.set_name(name);
    added.set_input(number);
    added.set_state(state);
    added.set_remedy(remedy);
  };
  output("extraction", 1, OUTPUT_WHILE_ARMED);
  output("air", 3, OUTPUT_WHILE_ENGRAVING);
  input("clamp", 1, INPUT_ON, "close the clamp");
  input("filter full", 2, INPUT_OFF, "change the filter");
  return machine;
}

class Inputs : public testing::Test {
 protected:
  Inputs() { cell_.laser.input_levels = 0b01; }
  void ExpectPaused(std::size_t cracks, const char* message) {
    EXPECT_EQ(cell_.engraving->message(), message);
    EXPECT_TRUE(cell_.engraving->faulted());
    EXPECT_FALSE(cell_.engraving->lost_a_line()) << "it would go on by itself";
    EXPECT_EQ(cell_.laser.cracks().size(), cracks);
    EXPECT_EQ(cell_.laser.shutters(), 0);
  }
  void ExpectNoMoreCracks() {
    const std::size_t cracks = cell_.laser.cracks().size();
    cell_.RenewGrant();
    cell_.StepFor(3s);
    EXPECT_EQ(cell_.laser.cracks().size(), cracks) << "no person has resumed";
  }
  void GoOnToTheEnd() {
    cell_.GrantAnew();
    ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    EXPECT_EQ(cell_.made(), cell_.points_mm.size());
  }

  FakeCell cell_{{.points = 160, .accessories = Shop()}};
};

TEST_F(Inputs, ThatAreAsNeededLetTheWholeJobBeMade) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
  EXPECT_EQ(cell_.made(), cell_.points_mm.size());
}

TEST_F(Inputs, OneThatIsWrongRefusesTheArmByItsName) {
  cell_.laser.input_levels = 0b11;
  cell_.Grant();
  cell_.StepFor(5s);
  ExpectPaused(0, "the input 'filter full' is on: change the filter, then resume");
  EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns);
  cell_.laser.input_levels = 0b01;
  ExpectNoMoreCracks();
  GoOnToTheEnd();
}

// The line shows the level 1 ms later: what passes then is interlocked by the controller.
TEST_F(Inputs, OneThatDropsInARunPausesTheJobAndCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  const std::size_t cracks = cell_.laser.cracks().size();
  cell_.laser.input_levels = 0;
  cell_.StepFor(1s);
  ASSERT_LT(cracks, cell_.points_mm.size());
  ExpectPaused(cracks, "the input 'clamp' is off: close the clamp, then resume");
  cell_.laser.input_levels = 0b01;
  ExpectNoMoreCracks();
  GoOnToTheEnd();
}

TEST_F(Inputs, EachThatIsWrongIsNamed) {
  cell_.laser.input_levels = 0b10;
  cell_.Grant();
  cell_.StepFor(1s);
  EXPECT_EQ(cell_.engraving->message(),
            "the input 'clamp' is off: close the clamp; the input 'filter full' is on: "
            "change the filter, then resume");
}

TEST(InputsOfAController, ThatIsOlderThanTheyAreRefusesTheArm) {
  FakeCell cell({.points = 40, .accessories = Shop()});
  cell.laser.output_count = cell.laser.input_count = 0;
  cell.CutLine(true);
  cell.StepFor(600ms);
  cell.CutLine(false);
  cell.Grant();
  cell.StepFor(3s);
  EXPECT_THAT(cell.engraving->message(),
              HasSubstr("the laser controller has 0 outputs, and 'extraction' of the "
                        "machine profile is output 1"));
  EXPECT_EQ(cell.laser.cracks().size(), 0u);
}

class OutputsTest : public testing::Test {
 protected:
  OutputsTest() { bench_.laser.output_count = 3; }
  void SetUp() override { bench_.StepFor(10ms); }
  void StepFor(std::chrono::milliseconds time, bool armed, bool engraves = false) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      outputs_.Turn(armed, engraves, bench_.now);
    }
  }

  LaserBench bench_;
  Outputs outputs_{bench_.controller, 0b001, 0b101};
};

TEST_F(OutputsTest, AreOnWhileTheArmHoldsAndPointsAreMade) {
  StepFor(1s, false);
  EXPECT_EQ(bench_.laser.outputs(), 0);
  EXPECT_EQ(bench_.ReceivedCount(link::LaserFrame::kAccessoryCommand), 0u);
  StepFor(5ms, true);
  EXPECT_EQ(bench_.laser.outputs(), 0b001);
  StepFor(5ms, true, true);
  EXPECT_EQ(bench_.laser.outputs(), 0b101);
  StepFor(5ms, true);
  EXPECT_EQ(bench_.laser.outputs(), 0b001);
  StepFor(5ms, false);
  EXPECT_EQ(bench_.laser.outputs(), 0);
  EXPECT_FALSE(outputs_.any_on());
  EXPECT_EQ(bench_.ReceivedCount(link::LaserFrame::kAccessoryCommand), 4u);
}

// In a safe state the controller takes no command to switch one on.
TEST_F(OutputsTest, AreCommandedUntilTheControllerReportsThem) {
  bench_.laser.EnterSafeState();
  StepFor(100ms, true);
  EXPECT_EQ(bench_.laser.outputs(), 0);
  EXPECT_LE(bench_.ReceivedCount(link::LaserFrame::kAccessoryCommand), 6u);
  (void)bench_.controller.Reset();
  StepFor(30ms, true);
  EXPECT_EQ(bench_.laser.outputs(), 0b001);
}

}  // namespace
}  // namespace intaglio::synchronizer
