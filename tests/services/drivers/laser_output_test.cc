// A laser behind the motion bridge keeps what a laser at a cable keeps, whichever of the
// two lines is cut and whichever of the two processes dies.

#include "services/drivers/laser_output.h"

#include <gtest/gtest.h>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/motion_drivers.h"
#include "tests/services/cell/one_controller_rig.h"
#include "tests/services/drivers/laser_bench.h"
#include "tests/services/drivers/motion_output_rig.h"
#include "tests/services/drivers/planted/laser_wrapper.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

/// The one controller, and every driver that switches a laser.
std::vector<std::string> Controllers() {
  std::vector<std::string> all = {"one-controller"};
  for (const MotionDriverKind& kind : MotionDriverKinds())
    // In real time, by linuxcnc_driver_test: linuxcnc.
    if (kind.switches_laser && kind.protocol != "linuxcnc")
      all.emplace_back(kind.protocol);
  return all;
}

std::unique_ptr<LaserRig> ControllerRig(const std::string& name) {
  return name == "one-controller" ? cell::MakeOneControllerLaserRig()
                                  : MakeLaserRig(name);
}

class EveryMotionOutput
    : public ::testing::TestWithParam<std::tuple<std::string, CutLineOf, LaserCheck>> {};

TEST_P(EveryMotionOutput, KeepsWhatALaserDriverGuarantees) {
  const auto& [name, line, check] = GetParam();
  const LaserRigMaker make = [&, name = name, line = line](const std::string& serial) {
    return std::make_unique<MotionOutputRig>(ControllerRig(name), line, serial);
  };
  const std::string stated = make("")->stated_violation(check.name);
  const std::string found = ViolationOf(check, make);
  EXPECT_EQ(stated.empty() ? found : found.substr(0, stated.size()), stated) << found;
}

INSTANTIATE_TEST_SUITE_P(
    Of, EveryMotionOutput,
    ::testing::Combine(::testing::ValuesIn(Controllers()),
                       ::testing::Values(CutLineOf::kSynchronizer,
                                         CutLineOf::kController),
                       ::testing::ValuesIn(LaserChecks().begin(), LaserChecks().end())),
    [](const auto& param) {
      std::string name = std::get<0>(param.param);
      std::replace(name.begin(), name.end(), '-', '_');
      const bool near = std::get<1>(param.param) == CutLineOf::kSynchronizer;
      return name + (near ? "_at_the_socket_" : "_at_the_controller_") +
             std::get<2>(param.param).name;
    });

class MotionOutput : public ::testing::Test {
 protected:
  MotionOutput()
      : bench([this](const std::string&) {
          auto made = std::make_unique<MotionOutputRig>(cell::MakeOneControllerLaserRig(),
                                                        CutLineOf::kSynchronizer, "");
          rig = made.get();
          return made;
        }) {
    bench.ConnectAndPrepare();
  }
  /// Armed for 2 s, of which 0.2 s have passed.
  Ticks ArmALot() {
    const Ticks armed = bench.Arm(5, std::vector<bool>(200, true));
    bench.PassTicks(20);
    return armed;
  }
  /// Nothing fires from `limit` ticks on, and the job can go on.
  void ExpectClosed(const Ticks& armed, std::uint64_t limit_tick) {
    bench.StepFor(1s);
    const Ticks fired = rig->FiredTicks();
    ASSERT_FALSE(fired.empty());
    EXPECT_LE(fired.back(), limit_tick);
    EXPECT_TRUE(std::includes(armed.begin(), armed.end(), fired.begin(), fired.end()));
    EXPECT_EQ(rig->shutters(), 0);
    bench.Connect();
    bench.ExpectNoPulseFor(500ms, "after the loss");
    bench.ExpectRemembers(armed.front(), 200);
    bench.ExpectGoodWindow();
  }

  MotionOutputRig* rig = nullptr;
  LaserBench bench;
};

// A socket shows it at once.
TEST_F(MotionOutput, AKilledSynchronizerLeavesNothingArmed) {
  const Ticks armed = ArmALot();
  const std::uint64_t killed = bench.tick();
  rig->KillSynchronizer();
  ExpectClosed(armed, killed + 2);
}

// The next process closes what it finds before it serves anybody.
TEST_F(MotionOutput, ABridgeThatComesAfterAKilledOneClosesTheLaser) {
  const Ticks armed = ArmALot();
  const std::uint64_t killed = bench.tick();
  rig->KillBridge();
  ExpectClosed(armed, killed + 2);
}

TEST_F(MotionOutput, ASynchronizerThatHangsLosesTheLaserForTheNextOne) {
  const Ticks armed = ArmALot();
  rig->CutLine(true);  // and its end stays open
  bench.StepFor(3s);
  rig->CutLine(false);
  rig->KillSynchronizer();
  ExpectClosed(armed, armed.front() + 20 + 27);
}

/// In its safe state it has no room for anything but a Reset.
class RefusesInItsSafeState final : public LaserWrapper {
 public:
  using LaserWrapper::LaserWrapper;
  Status OpenShutters(std::uint8_t mask) override {
    return mask != 0 && Has(link::kSafeState) ? No() : inner_->OpenShutters(mask);
  }
  Status Arm(const link::ArmWindow& window) override {
    return Has(link::kSafeState) ? No() : inner_->Arm(window);
  }

 private:
  static Status No() { return Fail(ErrorCode::kRefused, "the safe state lasts"); }
};

// A command that is refused for good is repeated for a while; a Reset passes it at once.
TEST(MotionOutputOf, ARefusedCommandKeepsNoResetFromTheLaser) {
  for (const auto wait : {20ms, 500ms}) {
    LaserBench bench([](const std::string&) {
      auto inner = cell::MakeOneControllerLaserRig();
      inner->driver = std::make_unique<RefusesInItsSafeState>(std::move(inner->driver));
      return std::make_unique<MotionOutputRig>(std::move(inner), CutLineOf::kSynchronizer,
                                               "");
    });
    bench.ConnectAndPrepare();
    EXPECT_TRUE(bench.driver().Stop());
    ASSERT_TRUE(bench.Until([&] { return bench.driver().Has(link::kSafeState); }));
    const std::uint64_t first = bench.tick() + 10;
    EXPECT_TRUE(bench.driver().OpenShutters(1));
    EXPECT_TRUE(
        bench.driver().Arm({first, false, {true, true}, false, bench.energy_mj()}));
    bench.ExpectNoPulseFor(wait, "in the safe state");
    bench.ExpectGoodWindow();
    // Its points are known: they never came.
    std::size_t late = 0;
    for (const link::PulseReport& report : bench.rig().reports)
      late += report.first_tick == first || report.first_tick == first + 1
                  ? static_cast<std::size_t>(std::count(report.outcome.begin(),
                                                        report.outcome.end(),
                                                        link::TickOutcome::kTooLate))
                  : 0;
    EXPECT_EQ(late, 2u);
  }
}

TEST(MotionOutputOf, AMotionControllerThatOnlyMovesIsRefused) {
  MachineSpec machine;
  machine.set_name("els-03");
  machine.mutable_laser_line()->set_protocol("motion-output");
  machine.mutable_motion_line()->set_protocol("virtual-stage");
  const auto made = MakeLaserDriver(machine);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kUnsupported);
  EXPECT_TRUE(made.error().message.starts_with(
      "laser_line.protocol: 'motion-output' needs a motion controller that switches the "
      "laser, and motion_line.protocol is 'virtual-stage'; there are: "))
      << made.error().message;
}

TEST(MotionOutputOf, TheSocketIsOfTheCell) {
  MachineSpec machine;
  machine.set_name("els-03");
  machine.mutable_laser_line()->set_protocol("motion-output");
  EXPECT_TRUE(LaserDeviceOf(machine).starts_with("unix:/"));
  EXPECT_TRUE(LaserDeviceOf(machine).ends_with("/els-03.laser"));
  machine.mutable_laser_line()->set_device("unix:/tmp/x");
  EXPECT_EQ(LaserDeviceOf(machine), "unix:/tmp/x");
  machine.mutable_laser_line()->set_protocol("virtual-laser");
  machine.mutable_laser_line()->clear_device();
  EXPECT_EQ(LaserDeviceOf(machine), "");
}

}  // namespace
}  // namespace intaglio::drivers
