// What a line learns of its controller, and how it brings it to a known state.

#include <utility>

#include "services/drivers/grbl/grbl_line.h"

namespace intaglio::drivers {

void GrblLine::TakeSetting(const GrblSetting& setting) {
  if (setting.number == 12) traits_.arc_tolerance_mm = setting.value;
  if (setting.number == 30) traits_.max_power = setting.value;
  if (setting.number == 22) traits_.homing = (static_cast<int>(setting.value) & 1) != 0;
  if (setting.number == 32) traits_.laser_mode = setting.value == 1;
  if (setting.number >= 100 && setting.number <= 102) {
    traits_.steps_per_mm[setting.number - 100] = setting.value;
  }
  if (setting.number >= 110 && setting.number <= 112) {
    traits_.max_speed_mm_s[setting.number - 110] = setting.value / 60;
  }
}

std::string GrblLine::RefusalOfTraits() const {
  if (auto why = link::RefusalOf(expected_, traits_.serial_number); !why.empty()) {
    return why;
  }
  if (tool_ == GrblTool::kLaser && !traits_.laser_mode) {
    return "the controller is not in laser mode, so the laser could stay lit at rest: "
           "set "
           "$32=1";
  }
  if (tool_ == GrblTool::kSpindle && traits_.laser_mode) {
    return "the controller is in laser mode, in which a spindle stops in every G0: set "
           "$32=0";
  }
  if (!(traits_.max_power > 0) || !(traits_.steps_per_mm.minCoeff() > 0)) {
    return "the controller does not report $30 and $100-$102: check its version with $$";
  }
  return "";
}

void GrblLine::Identified(std::vector<Event>& events) {
  refusal_ = RefusalOfTraits();
  if (!refusal_.empty()) {
    message_ = refusal_;
    phase_ = Phase::kRefused;
    return;
  }
  phase_ = Phase::kUp;
  phase_at_ = now();
  ++sessions_;
  message_.clear();
  events.emplace_back(GrblUp{});
  if (std::exchange(found_held_, false)) events.emplace_back(GrblHeld{});
  awaits_status_ = true;
  if (!alarm_) SetUp();
  next_status_ = {};
}

void GrblLine::SetUp() {
  setting_up_ = true;
  set_up_ = false;
  SendOwn({"M5S0", "G21G90G94G54G1"});
}

bool GrblLine::Recover(const GrblStatus& newest) {
  // A line of the set-up waits while it holds.
  if (phase_ != Phase::kUp || homing_ || awaits_status_) return false;
  const bool holds = newest.state == GrblState::kHold || newest.state == GrblState::kDoor;
  if (holds && newest.substate == 0) {
    Reset();
  } else if (locked() && newest.state == GrblState::kAlarm && !traits_.homing) {
    Unlock();
  } else if (needs_recovery() && newest.state == GrblState::kIdle) {
    SetUp();
  }
  return takes_lines() && newest.state == GrblState::kIdle;
}

void GrblLine::Unlock() {
  if (phase_ != Phase::kUp || set_up_ || setting_up_) return;
  LosePlace();
  SendOwn({"$X"});
  SetUp();
}

}  // namespace intaglio::drivers
