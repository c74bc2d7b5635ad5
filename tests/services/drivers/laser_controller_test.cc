#include <gtest/gtest.h>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/virtual/virtual_laser_driver.h"
#include "tests/services/platform/link/faulty_line.h"
#include "tests/services/synchronizer/fake_laser.h"

namespace intaglio::drivers {
namespace {

using link::TickOutcome;
using std::chrono::milliseconds;

/// The profile of a cell whose laser has this serial number; empty: any.
MachineSpec Profile(const std::string& serial_number) {
  MachineSpec machine;
  machine.set_name("els-03");
  machine.mutable_laser_line()->set_device("/dev/ttyUSB0");
  if (!serial_number.empty())
    machine.mutable_laser_line()->set_serial_number(serial_number);
  return machine;
}

/// A laser whose host may die: the line stays in.
class LaserAndHosts : public ::testing::Test {
 protected:
  LaserAndHosts() {
    laser.Plug(End(to_laser, to_host));
    NewHost();
  }
  std::unique_ptr<link::ByteStream> End(std::shared_ptr<link::FaultyPipe> in,
                                        std::shared_ptr<link::FaultyPipe> out) {
    return std::make_unique<link::FaultyEnd>(std::move(in), std::move(out), random,
                                             [this] { return now; });
  }
  void NewHost() {
    Connect("");
    ASSERT_TRUE(host->up());
  }
  void Connect(const std::string& expected) {
    host = MakeVirtualLaserDriver(
        Profile(expected),
        [this]() -> Result<std::unique_ptr<link::ByteStream>> {
          return End(to_host, to_laser);
        },
        [this] { return now; });
    StepFor(milliseconds(600));
  }
  /// The line is pulled out and put in again at the device with this serial number.
  void Replug(const std::string& serial_number) {
    laser.serial_number = serial_number;
    to_laser->cut = to_host->cut = true;
    StepFor(milliseconds(600));
    to_laser->cut = to_host->cut = false;
    StepFor(milliseconds(600));
  }
  /// Nothing was sent since `from` but what closes it.
  void ExpectOnlyClosed(std::size_t from) {
    using link::LaserFrame;
    const std::vector<LaserFrame> sent(
        laser.received.begin() + static_cast<std::ptrdiff_t>(from), laser.received.end());
    EXPECT_EQ(sent, (std::vector{LaserFrame::kShutterCommand, LaserFrame::kDisarm,
                                 LaserFrame::kLampCommand}));
    EXPECT_EQ(laser.shutters(), 0);
    EXPECT_FALSE(laser.lamp_on());
    EXPECT_TRUE(laser.cracks().empty());
  }
  void ExpectEverythingRefused() {
    EXPECT_FALSE(host->up());
    EXPECT_FALSE(host->CanSend());
    EXPECT_FALSE(host->Lamp(true, synchronizer::FakeLaser::kRateHz));
    EXPECT_FALSE(host->OpenShutters(1));
    EXPECT_FALSE(host->Arm({laser.tick() + 5, false, {true}}));
    EXPECT_FALSE(host->Reset());
    EXPECT_FALSE(host->RequestPast(1, 1));
    EXPECT_FALSE(host->RequestStatus());
  }
  void StepFor(milliseconds time) {
    for (const auto end = now + time; now < end;) {
      now += milliseconds(1);
      laser.Poll();
      host->Poll([this](const link::PulseReport& r) { reports.push_back(r); },
                 [this](const link::PastReport& r) { pasts.push_back(r); });
    }
  }
  void PassTicks(int count) {
    for (int i = 0; i < count; ++i) laser.AdvanceTick(true, Vec3::Zero());
  }

  std::chrono::nanoseconds now = std::chrono::seconds(1);
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<link::FaultyPipe> to_laser = std::make_shared<link::FaultyPipe>();
  std::shared_ptr<link::FaultyPipe> to_host = std::make_shared<link::FaultyPipe>();
  synchronizer::FakeLaser laser{[this] { return now; }, false};
  std::unique_ptr<LaserController> host;
  std::vector<link::PulseReport> reports;
  std::vector<link::PastReport> pasts;
};

TEST_F(LaserAndHosts, WhatADeadHostArmedIsReportedToTheNextWhenItAsks) {
  ASSERT_TRUE(host->Lamp(true, synchronizer::FakeLaser::kRateHz));
  StepFor(milliseconds(10));
  PassTicks(30);  // warm
  ASSERT_TRUE(host->OpenShutters(1));
  ASSERT_TRUE(host->Arm({31, true, {true, false, true, true}}));
  StepFor(milliseconds(10));
  host.reset();
  PassTicks(3);  // ticks 31..33; no host receives their reports
  reports.clear();
  NewHost();  // 34 is armed no longer
  PassTicks(1);
  ASSERT_TRUE(host->RequestPast(30, 6));
  ASSERT_TRUE(host->RequestPast(33, 1));
  StepFor(milliseconds(10));
  EXPECT_TRUE(reports.empty());
  ASSERT_EQ(pasts.size(), 2u);
  EXPECT_EQ(pasts[0].first_tick, 30u);
  EXPECT_EQ(pasts[0].outcome,
            (std::vector{TickOutcome::kNotArmed, TickOutcome::kFiredSeen,
                         TickOutcome::kNotArmed, TickOutcome::kFiredSeen,
                         TickOutcome::kNotArmed, TickOutcome::kNotArmed}));
  EXPECT_EQ(pasts[1].outcome, std::vector{TickOutcome::kFiredSeen});
}

TEST_F(LaserAndHosts, AQuestionThatTheLineDoesNotTakeIsNotAsked) {
  to_laser->cut = to_host->cut = true;
  StepFor(milliseconds(300));
  EXPECT_FALSE(host->RequestPast(1, 1));
  to_laser->cut = to_host->cut = false;
  StepFor(milliseconds(300));
  EXPECT_TRUE(host->RequestPast(1, 1));
  StepFor(milliseconds(10));
  EXPECT_EQ(pasts.size(), 1u);
}

constexpr char kA03[] = "A-03";
constexpr char kRefusal[] =
    "the line at /dev/ttyUSB0 leads to laser 'B-17', the profile of els-03 expects "
    "'A-03': "
    "swap the cables or correct laser_line.serial_number";

// As its own host left it: lit, open, armed.
TEST_F(LaserAndHosts, AnotherLaserIsClosedAndSentNothingElse) {
  ASSERT_TRUE(host->Lamp(true, synchronizer::FakeLaser::kRateHz));
  StepFor(milliseconds(10));
  PassTicks(30);  // warm
  ASSERT_TRUE(host->OpenShutters(1));
  ASSERT_TRUE(host->Arm({50, false, std::vector<bool>(100, true)}));
  StepFor(milliseconds(10));
  ASSERT_EQ(laser.shutters(), 1);
  laser.serial_number = "B-17";
  const std::size_t before = laser.received.size();
  Connect(kA03);
  EXPECT_EQ(host->refusal(), kRefusal);
  EXPECT_EQ(host->message(), kRefusal);
  EXPECT_EQ(host->session(), 0u);
  ExpectEverythingRefused();
  StepFor(milliseconds(2000));
  PassTicks(200);
  ExpectOnlyClosed(before);
}

TEST_F(LaserAndHosts, ALaserWithoutASerialNumberIsRefusedToo) {
  laser.serial_number = "";
  const std::size_t before = laser.received.size();
  Connect(kA03);
  EXPECT_NE(host->refusal().find("a laser without a serial number"), std::string::npos);
  ExpectEverythingRefused();
  ExpectOnlyClosed(before);
}

TEST_F(LaserAndHosts, AnotherLaserAfterAReconnectIsRefusedAndTheRightOneTakenBack) {
  Connect(kA03);
  ASSERT_TRUE(host->up());
  const std::uint64_t session = host->session();
  const std::size_t before = laser.received.size();
  Replug("B-17");
  EXPECT_EQ(host->refusal(), kRefusal);
  ExpectEverythingRefused();
  ExpectOnlyClosed(before);
  to_laser->cut = to_host->cut = true;
  StepFor(milliseconds(600));
  EXPECT_EQ(host->refusal(), "") << "no device answers, so none is refused";
  EXPECT_FALSE(host->up());
  Replug("A-03");
  EXPECT_EQ(host->refusal(), "");
  EXPECT_TRUE(host->up());
  EXPECT_GT(host->session(), session) << "what was sent before may be lost";
  EXPECT_TRUE(host->Lamp(true, synchronizer::FakeLaser::kRateHz));
  StepFor(milliseconds(10));
  EXPECT_TRUE(laser.lamp_on());
}

/// A device that sends what a test gives it, right after the handshake.
class LaserThatReports : public LaserAndHosts {
 protected:
  void ConnectTo(const link::Bytes& identity) {
    link::ReliableLink device(link::Side::kDevice, End(to_laser, to_host),
                              [this] { return now; });
    host = MakeVirtualLaserDriver(
        Profile(kA03),
        [this]() -> Result<std::unique_ptr<link::ByteStream>> {
          return End(to_host, to_laser);
        },
        [this] { return now; });
    const auto send = [&](link::LaserFrame type, const link::Bytes& payload) {
      EXPECT_TRUE(device.Send(static_cast<std::uint8_t>(type), payload));
    };
    bool sent = false;
    for (int i = 0; i < 100; ++i) {
      now += milliseconds(1);
      EXPECT_TRUE(device.Poll([](std::uint8_t, std::span<const std::byte>) {}));
      if (device.up() && !sent) {
        sent = true;
        send(link::LaserFrame::kLaserIdentity, identity);
        send(link::LaserFrame::kPulseReport,
             Encode(link::PulseReport{7, {TickOutcome::kFiredSeen}}));
        send(link::LaserFrame::kPastReport,
             Encode(link::PastReport{7, {TickOutcome::kFiredSeen}}));
        link::LaserStatus status;
        status.pulse_count = 4711;
        send(link::LaserFrame::kLaserStatus, Encode(status));
      }
      host->Poll([this](const link::PulseReport& r) { reports.push_back(r); },
                 [this](const link::PastReport& r) { pasts.push_back(r); });
    }
    EXPECT_TRUE(sent);
  }
};

// Its ticks are of another clock: they would end points that were never fired.
TEST_F(LaserThatReports, OfAnotherLaserNothingIsTaken) {
  ConnectTo(Encode(link::LaserIdentity{9, true, 1, {100}, "test", "B-17"}));
  EXPECT_EQ(host->refusal(), kRefusal);
  EXPECT_TRUE(reports.empty());
  EXPECT_TRUE(pasts.empty());
  EXPECT_EQ(host->status_number(), 0u);
  EXPECT_EQ(host->status().pulse_count, 0u);
  EXPECT_NE(host->identity().power_up, 9u);
}

TEST_F(LaserThatReports, OfTheRightOneAllIsTaken) {
  ConnectTo(Encode(link::LaserIdentity{9, true, 1, {100}, "test", "A-03"}));
  EXPECT_EQ(host->refusal(), "");
  EXPECT_EQ(reports.size(), 1u);
  EXPECT_EQ(pasts.size(), 1u);
  EXPECT_EQ(host->status().pulse_count, 4711u);
}

TEST_F(LaserThatReports, AnIdentityThatCannotBeReadIsRefusedWithTheRemedy) {
  link::Bytes older = Encode(link::LaserIdentity{9, true, 1, {100}, "test", ""});
  older.pop_back();  // no field of the serial number
  ConnectTo(older);
  EXPECT_FALSE(host->up());
  EXPECT_EQ(
      host->message(),
      "laser line: a frame LaserIdentity is malformed: the laser at /dev/ttyUSB0 must "
      "use version 13 of the frames (docs/protocols.md)");
  EXPECT_TRUE(reports.empty());
}

TEST(LaserDrivers, AnUnknownOneNamesWhatThereIs) {
  for (const char* protocol : {"", "grbl", "virtual-stage"}) {
    MachineSpec machine = Profile("");
    machine.mutable_laser_line()->set_protocol(protocol);
    const auto driver = MakeLaserDriver(machine);
    ASSERT_FALSE(driver) << protocol;
    EXPECT_EQ(driver.error().code, ErrorCode::kUnsupported);
    EXPECT_EQ(driver.error().value, protocol);
    EXPECT_EQ(driver.error().message, "laser_line.protocol: no driver for '" +
                                          std::string(protocol) +
                                          "'; there are: virtual-laser, motion-output");
  }
}

TEST(LaserDrivers, ADeviceThatCannotBeIsRefusedAtOnce) {
  MachineSpec machine = Profile("");
  machine.mutable_laser_line()->set_protocol("virtual-laser");
  EXPECT_TRUE(MakeLaserDriver(machine));
  machine.mutable_laser_line()->set_device("tcp:10.0.0.1");
  EXPECT_EQ(MakeLaserDriver(machine).error().code, ErrorCode::kInvalidValue);
  machine.mutable_laser_line()->clear_device();
  EXPECT_EQ(MakeLaserDriver(machine).error().code, ErrorCode::kMissing);
}

// Every window carries its energy, so whatever the line loses and repeats, a pulse has
// that of the window which armed it.
TEST_F(LaserAndHosts, ALineThatLosesBytesFiresNoPulseOfAnotherEnergy) {
  ASSERT_TRUE(host->Lamp(true, synchronizer::FakeLaser::kRateHz));
  StepFor(milliseconds(10));
  PassTicks(30);  // warm
  const auto energy_of = [](std::uint64_t tick) { return 1.0 + (tick - 31) / 4 % 7; };
  to_laser->drop_ratio = to_host->drop_ratio = 0.002;
  to_laser->damage_ratio = to_host->damage_ratio = 0.002;
  std::uint64_t armed = 0;
  for (std::uint64_t first = 31; first < 2031; first += 4) {
    if (host->up()) (void)host->OpenShutters(1);
    const std::vector<bool> fire(4, true);
    armed += host->Arm({first, false, fire, false, energy_of(first)}) ? 1 : 0;
    StepFor(milliseconds(40));
    while (laser.tick() < first + 3) PassTicks(1);
  }
  ASSERT_GT(armed, 400u);
  ASSERT_GT(laser.cracks().size(), 1000u);
  for (const auto& crack : laser.cracks())
    EXPECT_EQ(crack.energy_mj, energy_of(crack.tick)) << crack.tick;
}

// A device of version 7 takes none of our frames, and we take none of its.
TEST_F(LaserAndHosts, AnArmWindowOfAnOlderVersionFiresNothing) {
  ASSERT_TRUE(host->Lamp(true, synchronizer::FakeLaser::kRateHz));
  ASSERT_TRUE(host->OpenShutters(1));
  StepFor(milliseconds(10));
  PassTicks(30);
  link::ArmWindow window{31, false, {true}, false, 30};
  auto old = Encode(window);
  old.erase(old.begin() + 11, old.begin() + 19);  // the energy
  std::vector<std::byte> bytes;
  link::AppendFrame({static_cast<std::uint8_t>(link::LaserFrame::kArmWindow), 1, 1}, old,
                    bytes);
  bytes[2] = std::byte{7};
  std::size_t taken = 0;
  link::FrameParser().Feed(bytes, [&](const auto&, auto) { ++taken; });
  EXPECT_EQ(taken, 0u);
  EXPECT_FALSE(link::Decode<link::ArmWindow>(old));
  PassTicks(5);
  EXPECT_TRUE(laser.cracks().empty());
}

}  // namespace
}  // namespace intaglio::drivers
