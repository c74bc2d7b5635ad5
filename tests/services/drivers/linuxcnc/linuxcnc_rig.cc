#include "tests/services/drivers/linuxcnc/linuxcnc_rig.h"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "services/drivers/linuxcnc/linuxcnc_driver.h"
#include "tests/test_folder.h"

namespace intaglio::linuxcnc {
namespace {

constexpr char kSerialNumber[] = "L-03";
// The checks arm five ticks ahead.
constexpr double kShortLead_s = 0.05;
constexpr double kTravel_mm = 50, kMotionRate_hz = 100, kSlowRate_hz = 50,
                 kFastRate_hz = 500;

MachineSpec Profile(const std::filesystem::path& folder, const std::string& serial_number,
                    const std::vector<double>& rates_hz) {
  MachineSpec profile;
  profile.set_name("linuxcnc");
  profile.mutable_motion_line()->set_device(folder.string());
  profile.mutable_motion_line()->set_serial_number(serial_number.empty() ? kSerialNumber
                                                                         : serial_number);
  for (AxisLimits* axis :
       {profile.mutable_x(), profile.mutable_y(), profile.mutable_z()}) {
    axis->set_travel_min_mm(-kTravel_mm);
    axis->set_travel_max_mm(kTravel_mm);
    axis->set_max_speed_mm_s(50);
    axis->set_max_acceleration_mm_s2(2000);
  }
  for (const double rate_hz : rates_hz) profile.mutable_laser()->add_rates_hz(rate_hz);
  profile.mutable_laser()->set_pulse_energy_mj(10);
  return profile;
}

std::filesystem::path NextFolder() {
  static int number = 0;
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  return test::FreshFolder(fmt::format("linuxcnc_rig/{}_{}", getpid(), ++number) +
                           info->test_suite_name());
}

/// What both rigs have.
struct Rig {
  Rig() : machine(NextFolder(), kSerialNumber) { tap.Plug(); }
  ~Rig() { tap.Unplug(); }
  std::unique_ptr<drivers::LinuxcncDriver> Driver(const std::string& serial_number,
                                                  const std::vector<double>& rates_hz,
                                                  double lead_s) {
    return std::make_unique<drivers::LinuxcncDriver>(
        Profile(machine.folder(), serial_number, rates_hz), tap.Opener(),
        link::MonotonicClock(), lead_s);
  }
  void Advance() {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    tap.Pump();
  }
  void SwitchOff() {
    tap.Unplug();
    machine.PowerOff();
  }
  void SwitchOn() {
    machine.PowerOn();
    tap.Plug();
  }

  HalTap tap;
  HalMachine machine;
};

class Motion final : public drivers::MotionRig {
 public:
  explicit Motion(const std::string& serial_number) {
    driver =
        rig_.Driver(serial_number, {kMotionRate_hz}, drivers::LinuxcncDriver::kLead_s);
  }
  ~Motion() override { driver.reset(); }
  void CutLine(bool cut) override { rig_.tap.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { rig_.tap.CutAfter(bytes); }
  void PowerCycle() override {
    rig_.SwitchOff();
    StepFor(std::chrono::seconds(1));
    rig_.SwitchOn();
  }
  bool LosePlace() override { return SetHomed(false); }
  bool LosePlaceInMotion() override { return SetHomed(false); }
  bool FindPlace() override { return SetHomed(true); }
  Vec3 actual_mm() override { return rig_.tap.newest().actual_mm; }
  bool moves() override { return rig_.tap.moves(); }
  double rate_hz() const override { return kMotionRate_hz; }
  // The simulated servo thread makes up for what a busy computer has delayed.
  double time_ms() override { return rig_.tap.newest().tick * (1000 / kMotionRate_hz); }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-kTravel_mm); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(kTravel_mm); }
  // halsampler prints six decimals.
  double tolerance_mm() const override { return 2e-6; }
  // 8000 mm/s^2, and the samples that show it.
  std::chrono::milliseconds braking_time() const override {
    return std::chrono::milliseconds(100);
  }
  // Each end of 100 ms is known to a tick of 10 ms.
  double speed_margin() const override { return 1.25; }

 private:
  /// By the axes' file.
  bool SetHomed(bool homed) {
    rig_.machine.Command(fmt::format("sets axes-homed {:d}", homed));
    StepFor(std::chrono::milliseconds(100));
    return true;
  }
  void AdvanceController() override { rig_.Advance(); }
  Rig rig_;
};

class Laser final : public drivers::LaserRig {
 public:
  explicit Laser(const std::string& serial_number) {
    driver = rig_.Driver(serial_number, {kSlowRate_hz, kFastRate_hz}, kShortLead_s);
  }
  ~Laser() override { driver.reset(); }
  void CutLine(bool cut) override { rig_.tap.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { rig_.tap.CutAfter(bytes); }
  void SwitchOff() override { rig_.SwitchOff(); }
  void SwitchOn() override { rig_.SwitchOn(); }
  void Set(Interlock interlock, bool holds) override {
    const char* const name = interlock == Interlock::kKey    ? "key-on"
                             : interlock == Interlock::kDoor ? "door-closed"
                                                             : "stop-released";
    rig_.machine.Command(fmt::format("sets {} {:d}", name, holds));
    // halcmd takes it, and some periods see it.
    for (int i = 0; i < 30; ++i) rig_.Advance();
  }
  std::uint64_t tick() override { return rig_.tap.newest().tick; }
  std::vector<std::uint64_t> FiredTicks() override {
    return rig_.machine.RecordedTicks();
  }
  std::uint8_t shutters() override {
    return rig_.tap.newest().Has(drivers::kHalShutter) ? 1 : 0;
  }
  bool lamp_on() override { return rig_.tap.newest().Has(drivers::kHalLamp); }
  double rate_hz() const override { return kSlowRate_hz; }
  double fast_rate_hz() const override { return kFastRate_hz; }

 private:
  void AdvanceController() override { rig_.Advance(); }
  Rig rig_;
};

}  // namespace

std::unique_ptr<drivers::MotionRig> MakeMotionRig(const std::string& serial_number) {
  if (!EnterNamespace().empty()) return nullptr;
  return std::make_unique<Motion>(serial_number);
}

std::unique_ptr<drivers::LaserRig> MakeLaserRig(const std::string& serial_number) {
  if (!EnterNamespace().empty()) return nullptr;
  return std::make_unique<Laser>(serial_number);
}

}  // namespace intaglio::linuxcnc
