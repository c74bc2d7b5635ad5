#include "tests/services/drivers/linuxcnc/linuxcnc_mark_rig.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "services/drivers/linuxcnc/marks/linuxcnc_course_driver.h"
#include "tests/test_folder.h"

namespace intaglio::linuxcnc {
namespace {

using drivers::ControllerFault;

constexpr char kSerialNumber[] = "L-07";

std::filesystem::path NextFolder() {
  static int number = 0;
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  return test::FreshFolder(fmt::format("linuxcnc_beam/{}_{}", getpid(), ++number) +
                           info->test_suite_name());
}

/// The input of the machine that a fault lets go; null: there is none.
const char* InputOf(ControllerFault fault) {
  switch (fault) {
    case ControllerFault::kEmergencyStop:
      return "stop-released";
    case ControllerFault::kLimit:
    case ControllerFault::kAlarm:
      return "drives-ready";
    default:
      return nullptr;
  }
}

}  // namespace

MachineSpec CutterProfile(const std::filesystem::path& folder) {
  MachineSpec profile;
  profile.set_name("cutter");
  profile.mutable_mark_line()->set_protocol("linuxcnc-course");
  profile.mutable_mark_line()->set_device(folder.string());
  for (AxisLimits* axis : {profile.mutable_x(), profile.mutable_y()}) {
    axis->set_travel_min_mm(-90);
    axis->set_travel_max_mm(90);
    axis->set_max_speed_mm_s(50);
    axis->set_max_acceleration_mm_s2(2000);
  }
  profile.mutable_block_origin_mm()->set_x(10);
  profile.mutable_block_origin_mm()->set_y(20);
  profile.set_position_tolerance_um(20);
  profile.mutable_course_tool()->set_kind(COURSE_TOOL_LASER);
  return profile;
}

mark::Pen CutterPen(double speed_mm_s) {
  mark::Pen pen;
  pen.name = "cut";
  pen.speed_mm_s = speed_mm_s;
  pen.power_ratio = 1;
  return pen;
}

BeamRig::BeamRig(const std::string& serial_number, void (*change)(MachineSpec& profile))
    : machine(NextFolder(), kSerialNumber, {}, true), change_(change) {
  tap.Plug();
  driver = MakeDriver(serial_number);
}

BeamRig::~BeamRig() {
  driver.reset();
  tap.Unplug();
}

std::unique_ptr<drivers::MarkDriver> BeamRig::MakeDriver(
    const std::string& serial_number) {
  driver.reset();
  MachineSpec profile = CutterProfile(machine.folder());
  if (change_ != nullptr) change_(profile);
  profile.mutable_mark_line()->set_serial_number(serial_number.empty() ? kSerialNumber
                                                                       : serial_number);
  return std::make_unique<drivers::LinuxcncCourseDriver>(profile, tap.Opener(),
                                                         link::MonotonicClock());
}

void BeamRig::AdvanceController() {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  tap.Pump();
}

void BeamRig::Command(const std::string& command) {
  machine.Command(command);
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
}

bool BeamRig::Inflict(ControllerFault fault) {
  if (fault == ControllerFault::kUnplug) {
    tap.Cut(true);
  } else if (fault == ControllerFault::kPowerCycle) {
    tap.Unplug();
    machine.PowerOff();
  } else if (const char* input = InputOf(fault)) {
    machine.Command(fmt::format("sets {} 0", input));
  } else {
    return false;
  }
  return true;
}

void BeamRig::Relieve(ControllerFault fault) {
  if (fault == ControllerFault::kUnplug) tap.Cut(false);
  if (fault == ControllerFault::kPowerCycle) {
    machine.PowerOn();
    tap.Plug();
  }
  if (const char* input = InputOf(fault)) Command(fmt::format("sets {} 1", input));
}

void BeamRig::SetDoor(bool closed) {
  machine.Command(fmt::format("sets door-closed {:d}", closed));
}

mark::MarkSet BeamRig::MarksFor(int count) {
  mark::MarkSet set{{CutterPen(10)}, {}};
  for (int i = 0; i < count; ++i) {
    mark::Mark square;
    const double x = 3.0 * i, y = 1, side = 2;
    square.closed = true;
    square.places = {{{x, y}}, {{x + side, y}}, {{x + side, y + side}}, {{x, y + side}}};
    set.marks.push_back(square);
  }
  return set;
}

std::unique_ptr<drivers::MarkRig> MakeBeamRig(const std::string& serial_number) {
  if (!EnterNamespace().empty()) return nullptr;
  return std::make_unique<BeamRig>(serial_number);
}

}  // namespace intaglio::linuxcnc
