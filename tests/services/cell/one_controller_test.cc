// One object that is both drivers keeps what both seams ask for, and the two halves do
// not touch each other.

#include "tests/services/cell/one_controller.h"

#include <gtest/gtest.h>

#include "tests/services/drivers/laser_bench.h"
#include "tests/services/drivers/motion_bench.h"

namespace intaglio::cell {
namespace {

constexpr char kSerialNumber[] = "both-1";
constexpr double kRateHz = 100, kFastRateHz = 4000;

virtual_engraver::StageOptions StageOf() {
  virtual_engraver::StageOptions options;
  options.lag_s = 0;
  options.travel_min_mm = Vec3::Constant(-50);
  options.travel_max_mm = Vec3::Constant(50);
  options.queue_capacity = 64;
  options.serial_number = kSerialNumber;
  return options;
}

virtual_engraver::LaserOptions LaserOf() {
  virtual_engraver::LaserOptions options;
  options.rates_hz = {kRateHz, kFastRateHz};
  options.warm_up_s = 0.1;
  options.serial_number = kSerialNumber;
  return options;
}

// A command for some 30 bytes of a line.
constexpr std::uint64_t kBytesOfACommand = 30;

class AsMotion final : public drivers::MotionRig {
 public:
  explicit AsMotion(const std::string& serial_number) {
    driver = std::make_unique<OneController>(
        machine_, serial_number.empty() ? kSerialNumber : serial_number);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override {
    machine_.CutAfter(bytes / kBytesOfACommand);
  }
  void PowerCycle() override {
    machine_.SwitchOff();
    StepFor(std::chrono::seconds(1));
    machine_.SwitchOn();
  }
  Vec3 actual_mm() override { return machine_.stage->actual_mm(); }
  bool moves() override { return machine_.stage->running(); }
  double rate_hz() const override { return kRateHz; }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-50); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(50); }
  double tolerance_mm() const override { return 2e-6; }
  std::chrono::milliseconds braking_time() const override {
    return std::chrono::milliseconds(30);
  }

 private:
  void AdvanceController() override { machine_.Advance(); }
  OneMachine machine_{StageOf(), LaserOf()};
};

class AsLaser final : public drivers::LaserRig {
 public:
  explicit AsLaser(const std::string& serial_number) {
    driver = std::make_unique<OneController>(
        machine_, serial_number.empty() ? kSerialNumber : serial_number);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override {
    machine_.CutAfter(bytes / kBytesOfACommand);
  }
  void PowerCycle() override {
    machine_.SwitchOff();
    for (int i = 0; i < 1000; ++i) Step();
    machine_.SwitchOn();
  }
  void Set(Interlock interlock, bool holds) override {
    if (interlock == Interlock::kKey) machine_.laser->SetKey(holds);
    if (interlock == Interlock::kDoor) machine_.laser->SetDoor(holds);
    if (interlock == Interlock::kStopButton) machine_.laser->SetStopButton(!holds);
  }
  std::uint64_t tick() override { return machine_.laser->tick(); }
  std::vector<std::uint64_t> FiredTicks() override { return machine_.fired_ticks(); }
  std::uint8_t shutters() override { return machine_.laser->shutters(); }
  bool lamp_on() override {
    return (machine_.laser->Report().interlocks & link::kLampOn) != 0;
  }
  double rate_hz() const override { return kRateHz; }
  double fast_rate_hz() const override { return kFastRateHz; }

 private:
  void AdvanceController() override { machine_.Advance(); }
  OneMachine machine_{StageOf(), LaserOf()};
};

TEST(OneController, KeepsWhatAMotionDriverGuarantees) {
  for (const auto& check : drivers::MotionChecks()) {
    EXPECT_EQ(ViolationOf(check,
                          [](const std::string& serial_number) {
                            return std::make_unique<AsMotion>(serial_number);
                          }),
              "")
        << check.name;
  }
}

TEST(OneController, KeepsWhatALaserDriverGuarantees) {
  for (const auto& check : drivers::LaserChecks()) {
    EXPECT_EQ(ViolationOf(check,
                          [](const std::string& serial_number) {
                            return std::make_unique<AsLaser>(serial_number);
                          }),
              "")
        << check.name;
  }
}

class Both : public ::testing::Test {
 protected:
  void StepFor(int ms) {
    for (int i = 0; i < ms; ++i) {
      machine.Advance();
      motion.Poll();
      laser.Poll([](const auto&) {}, [](const auto&) {});
    }
  }
  void Prepare() {
    StepFor(10);
    ASSERT_TRUE(laser.Lamp(true, kRateHz));
    ASSERT_TRUE(laser.OpenShutters(1));
    StepFor(200);
    ASSERT_TRUE(laser.Has(link::kLampWarm));
  }

  OneMachine machine{StageOf(), LaserOf()};
  OneController both{machine, kSerialNumber};
  drivers::MotionDriver& motion = both;
  drivers::LaserController& laser = both;
};

// Every tick is armed; the stage's output lets those through at which a point is reached.
TEST_F(Both, FiresWhereTheMotionIsInPlace) {
  Prepare();
  const std::uint64_t start = motion.state().tick + 20;
  std::vector<motion::Segment> course = {drivers::To(0.25, 10, 5)};
  for (int i = 1; i <= 5; ++i) course.push_back(drivers::To(0.25 + 0.1 * i, 10, 1));
  course[1].pulse = course[3].pulse = true;
  course.push_back(drivers::To(1, 0, 5, true));
  ASSERT_TRUE(motion.BeginRun(1, start, 0));
  ASSERT_TRUE(motion.Append(course, {}));
  ASSERT_TRUE(laser.Arm({start, true, std::vector<bool>(30, true)}));
  StepFor(600);
  EXPECT_EQ(machine.fired_ticks(), (std::vector<std::uint64_t>{start + 6, start + 8}));
  EXPECT_EQ(laser.status().pulse_count, 2u);
}

// The bridge clears a fault before every run: a stop of the laser has to outlast that.
TEST_F(Both, ClearingAMotionFaultReleasesNoStop) {
  Prepare();
  ASSERT_TRUE(laser.Stop());
  ASSERT_TRUE(motion.BeginRun(1, 1, 0));
  StepFor(10);
  ASSERT_EQ(motion.state().fault, intaglio_MOTION_LATE);
  ASSERT_TRUE(motion.ClearFault());
  StepFor(10);
  EXPECT_EQ(motion.state().fault, intaglio_MOTION_OK);
  EXPECT_FALSE(laser.Has(link::kStopReleased));
  ASSERT_TRUE(laser.OpenShutters(1));
  ASSERT_TRUE(laser.Arm({laser.status().tick + 5, false, {true}}));
  StepFor(200);
  EXPECT_TRUE(machine.fired_ticks().empty());
  ASSERT_TRUE(laser.Reset());
  StepFor(10);
  EXPECT_TRUE(laser.Has(link::kStopReleased));
}

}  // namespace
}  // namespace intaglio::cell
