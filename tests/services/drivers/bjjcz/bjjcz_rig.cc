#include "tests/services/drivers/bjjcz/bjjcz_rig.h"

#include <algorithm>

#include "services/drivers/mark_drivers.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

class BjjczMarkRig final : public MarkRig {
 public:
  BjjczMarkRig(const MachineSpec& profile, const std::string& serial_number)
      : profile_(profile), machine_(profile.bjjcz_board().laser() == BJJCZ_LASER_FIBRE) {
    driver = MakeDriver(serial_number);
  }

  void CutLine(bool cut) override { machine_.Cut(cut); }
  bool Inflict(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) {
      machine_.SwitchOff();
    } else if (fault == ControllerFault::kEmergencyStop) {
      machine_.board.SetInput(kBjjczDoorInput, false);
    } else if (fault == ControllerFault::kUnplug) {
      machine_.Cut(true);
    } else {
      return false;  // it has neither limits nor a hold nor a reset of its own
    }
    return true;
  }
  void Relieve(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) machine_.SwitchOn();
    if (fault == ControllerFault::kEmergencyStop)
      machine_.board.SetInput(kBjjczDoorInput, true);
    if (fault == ControllerFault::kUnplug) machine_.Cut(false);
  }
  bool knows_power_ups() const override { return false; }
  void SetDoor(bool closed) override { machine_.board.SetInput(kBjjczDoorInput, closed); }
  std::unique_ptr<MarkDriver> MakeDriver(const std::string& serial_number) override {
    MachineSpec profile = profile_;
    if (!serial_number.empty())
      profile.mutable_mark_line()->set_serial_number(serial_number);
    return MakeBjjczDriverAt(machine_, profile);
  }
  std::uint64_t work_count() override { return machine_.board.work_count(); }
  bool is_on() override { return machine_.board.lit(); }
  bool guide_is_on() override {
    return (machine_.board.outputs() >> profile_.bjjcz_board().guide_output() & 1) != 0;
  }
  bool gate_is_open() override {
    return (machine_.board.outputs() >> profile_.bjjcz_board().gate_output() & 1) != 0;
  }
  Vec2 guide_at_mm() override {
    const auto place = machine_.board.place();
    return Vec2(place[0] - 32768, place[1] - 32768) * place_tolerance_mm() * 2;
  }
  double place_tolerance_mm() override {
    return profile_.scan_head().field_mm() / 65536 / 2;
  }
  bool can_lose_place() const override { return false; }
  mark::MarkSet MarksFor(int count) override {
    mark::Pen pen;
    pen.name = "mark";
    pen.speed_mm_s = 100;
    pen.power_ratio = 0.5;
    pen.frequency_hz = 20000;
    mark::MarkSet set{{pen}, {}};
    for (int i = 0; i < count; ++i) {
      mark::Mark mark;
      mark.closed = true;
      mark.places = {{Vec2(10.0 * i - 30, 5), 1}, {Vec2(10.0 * i - 22, 5), 1}};
      set.marks.push_back(mark);
    }
    return set;
  }
  std::chrono::milliseconds stop_time() const override { return 60ms; }

 private:
  void AdvanceController() override { machine_.Advance(); }

  MachineSpec profile_;
  BjjczMachine machine_;
};

}  // namespace

MachineSpec BjjczProfile(BjjczLaser laser) {
  MachineSpec machine;
  machine.set_name("board");
  machine.mutable_mark_line()->set_protocol("bjjcz");
  machine.mutable_mark_line()->set_device("/dev/null");
  machine.mutable_mark_line()->set_serial_number(kBjjczSerialNumber);
  machine.mutable_scan_head()->set_field_mm(100);
  machine.mutable_scan_head()->set_jump_mm_s(5000);
  machine.mutable_scan_head()->set_laser_on_delay_s(20e-6);
  machine.mutable_scan_head()->set_laser_off_delay_s(30e-6);
  machine.mutable_scan_head()->set_jump_delay_s(200e-6);
  machine.mutable_bjjcz_board()->set_laser(laser);
  machine.mutable_bjjcz_board()->set_door_input(kBjjczDoorInput);
  machine.mutable_bjjcz_board()->set_lamp_output(5);
  machine.mutable_bjjcz_board()->set_guide_output(8);
  return machine;
}

std::unique_ptr<MarkDriver> MakeBjjczDriverAt(BjjczMachine& machine,
                                              const MachineSpec& profile) {
  const auto kinds = MarkDriverKinds();
  const auto kind = std::ranges::find(kinds, "bjjcz", &MarkDriverKind::protocol);
  return kind->make(profile, machine.Opener(), machine.clock());
}

std::unique_ptr<MarkRig> MakeBjjczMarkRigOf(const MachineSpec& profile) {
  return std::make_unique<BjjczMarkRig>(profile, "");
}

std::unique_ptr<MarkRig> MakeBjjczMarkRig(const std::string& name,
                                          const std::string& serial_number) {
  return std::make_unique<BjjczMarkRig>(
      BjjczProfile(name == "bjjcz_fibre" ? BJJCZ_LASER_FIBRE : BJJCZ_LASER_UV),
      serial_number);
}

}  // namespace intaglio::drivers
