#include "tests/services/drivers/galvo/head_rig.h"

#include <algorithm>

#include "tests/services/drivers/galvo/head_bench.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

class HeadMarkRig final : public MarkRig {
 public:
  explicit HeadMarkRig(const std::string& serial_number)
      : bench_(HeadProfile(), HeadTruthOf(HeadProfile())) {
    driver = MakeDriver(serial_number);
  }

  void CutLine(bool cut) override { cut ? bench_.CutLine() : bench_.JoinLine(); }
  bool Inflict(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) {
      bench_.SwitchOff();
    } else if (fault == ControllerFault::kEmergencyStop) {
      bench_.head().SetStopButton(true);
    } else if (fault == ControllerFault::kUnplug) {
      bench_.CutLine();
    } else {
      return false;  // it has neither axes with limits nor a hold nor a reset
    }
    return true;
  }
  void Relieve(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) bench_.SwitchOn();
    if (fault == ControllerFault::kEmergencyStop) bench_.head().SetStopButton(false);
    if (fault == ControllerFault::kUnplug) bench_.JoinLine();
  }
  void SetDoor(bool closed) override { bench_.head().SetDoor(closed); }
  std::unique_ptr<MarkDriver> MakeDriver(const std::string& serial_number) override {
    MachineSpec profile = HeadProfile();
    profile.mutable_mark_line()->set_serial_number(serial_number);
    return bench_.NewDriver(profile);
  }
  std::uint64_t work_count() override { return bench_.burnt_ticks(); }
  bool is_on() override { return burns_; }
  mark::MarkSet MarksFor(int count) override {
    mark::Pen pen;
    pen.name = "mark";
    pen.speed_mm_s = 100;
    pen.power_ratio = 0.5;
    pen.frequency_hz = 20000;
    mark::MarkSet set{{pen}, {}};
    for (int i = 0; i < count; ++i)
      set.marks.push_back(CircleMark(Vec2(10.0 * i - 30, 5), 8));
    return set;
  }
  std::chrono::milliseconds stop_time() const override { return 60ms; }

 private:
  void AdvanceController() override {
    const std::uint64_t before = bench_.burnt_ticks();
    bench_.AdvanceHead(1ms);
    burns_ = bench_.burnt_ticks() != before;
  }

  HeadBench bench_;
  bool burns_ = false;
};

}  // namespace

std::unique_ptr<MarkRig> MakeHeadMarkRig(const std::string& /*name*/,
                                         const std::string& serial_number) {
  return std::make_unique<HeadMarkRig>(serial_number);
}

}  // namespace intaglio::drivers
