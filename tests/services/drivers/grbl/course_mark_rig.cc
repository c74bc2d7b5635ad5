#include "tests/services/drivers/grbl/course_mark_rig.h"

#include "tests/services/drivers/grbl/course_rig.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

grbl::VirtualGrblOptions OptionsOf(const std::string& name) {
  grbl::VirtualGrblOptions options = grbl::Grbl11();
  options.laser_mode = name == "grbl_laser";
  options.homing = name == "grbl_mill_that_homes";
  options.home_steps = {250, 250, 250};
  return options;
}

class CourseMarkRig final : public MarkRig {
 public:
  CourseMarkRig(const std::string& name, const std::string& serial_number)
      : laser_(name == "grbl_laser"), machine_(OptionsOf(name)) {
    BeginByItsPanel(OptionsOf(name).homing);
    driver = MakeDriver(serial_number);
  }

  void CutLine(bool cut) override { machine_.Cut(cut); }
  bool Inflict(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) machine_.SwitchOff();
    if (fault == ControllerFault::kUnplug) machine_.Cut(true);
    return fault == ControllerFault::kPowerCycle || fault == ControllerFault::kUnplug ||
           machine_.Inflict(fault);
  }
  void Relieve(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) machine_.SwitchOn();
    if (fault == ControllerFault::kUnplug) machine_.Cut(false);
    machine_.Relieve(fault);
  }
  void SetDoor(bool closed) override { machine_.grbl.SetDoor(!closed); }
  std::unique_ptr<MarkDriver> MakeDriver(const std::string& serial_number) override {
    MachineSpec profile = CourseProfile(laser_ ? COURSE_TOOL_LASER : COURSE_TOOL_SPINDLE);
    profile.mutable_mark_line()->set_serial_number(serial_number);
    return MakeGrblCourseDriver(profile, machine_.opener(), machine_.clock());
  }
  std::uint64_t work_count() override { return machine_.grbl.motion().steps_made(); }
  bool is_on() override {
    return laser_ ? machine_.grbl.motion().lit() : machine_.grbl.spindle_on();
  }
  mark::MarkSet MarksFor(int count) override {
    return Squares(laser_ ? LaserPen() : MillPen(), count);
  }
  // Feed hold, and the reset at rest.
  std::chrono::milliseconds stop_time() const override { return 400ms; }

 private:
  void AdvanceController() override { machine_.Advance(); }
  /// Not where a controller is that was switched on just now.
  void BeginByItsPanel(bool homes) {
    if (homes) machine_.grbl.Write("$H\n");
    machine_.grbl.Write("G0X0.5\n");
    machine_.grbl.Advance(10e6);
    (void)machine_.grbl.Read();
  }

  bool laser_;
  GrblMachine machine_;
};

}  // namespace

std::unique_ptr<MarkRig> MakeCourseMarkRig(const std::string& name,
                                           const std::string& serial_number) {
  return std::make_unique<CourseMarkRig>(name, serial_number);
}

}  // namespace intaglio::drivers
