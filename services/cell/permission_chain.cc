#include "services/cell/permission_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "services/platform/bus/open_chain.h"
#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::cell {
namespace {

constexpr std::uint64_t kEveryRenewal = std::numeric_limits<std::uint64_t>::max();

bool IsChainOpen(const ChainLinks& links) {
  return bus::IsChainOpen(links.key_on, links.door_closed, links.stop_released);
}

// Who lets go of one gives a new permission. What a line that is down reported last is
// not known to hold or not.
Missing OpenInterlock(const ChainLinks& links) {
  if (!links.stop_not_pressed) return Missing::kEmergencyStop;
  if (!links.laser_line_up) return Missing::kNothing;
  if (IsChainOpen(links)) return Missing::kChain;
  if (!links.key_on) return Missing::kKey;
  if (!links.door_closed) return Missing::kDoor;
  if (!links.stop_released) return Missing::kEmergencyStop;
  if (!links.inputs_hold) return Missing::kInput;
  return Missing::kNothing;
}

// The one that a Reset closes, and no other.
bool OnlyMachineStopIsOpen(const ChainLinks& links) {
  ChainLinks released = links;
  released.stop_released = true;
  return !links.stop_released && links.laser_line_up &&
         OpenInterlock(released) == Missing::kNothing;
}

Missing ReasonOf(UnseenEvent event) {
  switch (event) {
    case UnseenEvent::kNone:
      break;
    case UnseenEvent::kOpened:
      return Missing::kOpenedUnseen;
    case UnseenEvent::kPowerCycle:
      return Missing::kPowerCycle;
    case UnseenEvent::kNotWatched:
      return Missing::kNotWatched;
    case UnseenEvent::kLaserAway:
      return Missing::kLaserAway;
    case UnseenEvent::kMotionAway:
      return Missing::kMotionAway;
  }
  return Missing::kNothing;
}

bool IsGranted(const ChainLinks& links) {
  return links.permission_fresh && links.permission_granted;
}

}  // namespace

Missing FirstMissing(const ChainLinks& links, bool with_shutters) {
  if (!links.permission_fresh || !links.permission_granted) return Missing::kPermission;
  if (!links.stop_not_pressed) return Missing::kEmergencyStop;
  if (!links.laser_line_up) return Missing::kLaserLine;
  if (IsChainOpen(links)) return Missing::kChain;
  if (!links.key_on) return Missing::kKey;
  if (!links.door_closed) return Missing::kDoor;
  if (!links.stop_released) return Missing::kEmergencyStop;
  if (!links.inputs_hold) return Missing::kInput;
  if (!links.no_safe_state) return Missing::kSafeState;
  if (!links.lamp_sync_counted) return Missing::kLampSync;
  if (!links.lamp_warm) return Missing::kLamp;
  if (!links.motion_fresh) return Missing::kMotionState;
  if (!links.motion_without_fault) return Missing::kMotionFault;
  if (!links.block_at_place) return Missing::kBlockPlace;
  if (with_shutters && !links.shutters_open) return Missing::kShutter;
  if (with_shutters && !links.door_locked) return Missing::kDoorLock;
  return Missing::kNothing;
}

std::string TextOf(Missing missing) {
  switch (missing) {
    case Missing::kNothing:
      return "";
    case Missing::kPermission:
      return "waits for the permission of the job service";
    case Missing::kEmergencyStop:
      return "emergency stop is pressed: release and reset it, then resume";
    case Missing::kLaserLine:
      return "the laser line is down: check the cable and the controller, then resume";
    case Missing::kChain:
      return fmt::format("{}: close them, then resume", bus::kChainIsOpen);
    case Missing::kKey:
      return "the key switch is off: turn it on, then resume";
    case Missing::kDoor:
      return "the door is open: close it, then resume";
    case Missing::kInput:
      return "an input that the machine profile names is not as a job needs it: check "
             "what is connected to it, then resume";
    case Missing::kSafeState:
      return "the laser controller has closed its shutters by itself: check the machine, "
             "then resume to reset it";
    case Missing::kLampSync:
      return "the lamp sync is too short to be counted: check its cable, and "
             "laser.timing.min_sync_width_us of the profile, then resume";
    case Missing::kLamp:
      return "the lamp is not warm yet";
    case Missing::kMotionState:
      return "the motion bridge is silent: check that intaglio-motion-bridge runs, then "
             "resume";
    case Missing::kMotionFault:
      return "the stage reports a fault";
    case Missing::kBlockPlace:
      return "the stage that carries the block is not at the job's place: check that "
             "nothing holds or pushes it, then resume, and it moves there";
    case Missing::kShutter:
      return "the shutter does not open: check its drive, then resume";
    case Missing::kDoorLock:
      return "the lock of the door does not hold while a shutter is open: check its "
             "magnet, then resume";
    case Missing::kOpenedUnseen:
      return "key, door, stop button or an input was opened, or the controller stopped "
             "by itself (hold, alarm, limit, error): check the machine and what is in "
             "it, then resume or cancel";
    case Missing::kPowerCycle:
      return "the controller was switched off and on, or reset, or is watched anew: "
             "check its zero, and that the right block or piece is in the machine, then "
             "resume or cancel";
    case Missing::kNotWatched:
      return "key and door were not supervised until now: check that the right block or "
             "piece is in the machine, then resume or cancel";
    case Missing::kLaserAway:
      return fmt::format(
          "the laser controller was silent for more than {} s: check that the right "
          "block or piece is in the machine, then resume or cancel",
          host::kMaxAbsence.count());
    case Missing::kMotionAway:
      return fmt::format(
          "the motion controller was silent for more than {} s: check that the right "
          "block or piece is in the machine, then resume or cancel",
          host::kMaxAbsence.count());
  }
  return "";
}

void PermissionChain::Spend() {
  spent_ = {std::max(spent_.number, grant_.number), kEveryRenewal};
  state_ = State::kLatched;
}

void PermissionChain::Latch(bool only_renewal, Missing by) {
  spent_by_ = by;
  if (!only_renewal) return Spend();
  spent_ = std::max(spent_, grant_);
  state_ = State::kLatched;
}

bool PermissionChain::IsNewestGranted(const ChainLinks& links) const {
  return IsGranted(links) && IsNewest(links);
}

void PermissionChain::BeginJob() {
  state_ = State::kClear;
  grant_ = spent_ = {};
  spent_by_ = before_first_grant_ = Missing::kNothing;
}

void PermissionChain::Watch(const ChainLinks& links, std::chrono::nanoseconds now) {
  (void)CheckForUnseenEvent(links, now);
}

Missing PermissionChain::CheckForUnseenEvent(const ChainLinks& links,
                                             std::chrono::nanoseconds now) {
  const bool closed =
      links.key_on && links.door_closed && links.stop_released && links.inputs_hold;
  const bool motion_seen = links.motion_fresh && !links.motion_line_down;
  return ReasonOf(
      watch_.Update({links.laser_line_up, closed, links.counters, motion_seen}, now));
}

Missing PermissionChain::Turn(const ChainLinks& links, std::chrono::nanoseconds now) {
  Missing unseen = CheckForUnseenEvent(links, now);
  if (links.grant.number > grant_.number) watch_.AcceptSilences(now);
  grant_ = std::max(grant_, links.grant);
  const bool had_worth = HasWorth();
  if (grant_.number == 0) {
    if (unseen != Missing::kNothing) before_first_grant_ = unseen;
    unseen = Missing::kNothing;
  } else if (before_first_grant_ != Missing::kNothing) {
    unseen = std::exchange(before_first_grant_, Missing::kNothing);
  }
  if (unseen != Missing::kNothing) Spend();
  Missing by = AdvanceState(links, now);
  if (by == Missing::kNothing) by = unseen;
  if (!had_worth) by = Missing::kNothing;
  if (by != Missing::kNothing) spent_by_ = by;
  if (!has_spent()) spent_by_ = Missing::kNothing;
  return by;
}

Missing PermissionChain::AdvanceState(const ChainLinks& links,
                                      std::chrono::nanoseconds now) {
  const bool newer = grant_ > spent_, armed_anew = grant_.number > spent_.number;
  const Missing open = OpenInterlock(links);
  const bool may_clear = links.laser_line_up && IsNewestGranted(links);
  switch (state_) {
    case State::kClear:
      if (open == Missing::kNothing) return Missing::kNothing;
      break;
    case State::kLatched:
      if (open == Missing::kNothing ? newer
                                    : armed_anew && OnlyMachineStopIsOpen(links)) {
        if (!may_clear) return Missing::kNothing;
        state_ = open == Missing::kNothing ? State::kClear : State::kResetting;
        resetting_since_ = now;
        return Missing::kNothing;
      }
      if (open == Missing::kNothing) return Missing::kNothing;
      break;
    case State::kResetting:
      if (may_clear && open == Missing::kNothing) {
        state_ = State::kClear;
        return Missing::kNothing;
      }
      // A permission that is only late is waited for, too.
      if (links.permission_granted && links.laser_line_up &&
          (open == Missing::kNothing || OnlyMachineStopIsOpen(links)) &&
          now - resetting_since_ <= kResetTime) {
        return Missing::kNothing;
      }
      break;
  }
  Spend();
  return open;
}

Missing PermissionChain::WhatIsMissing(const ChainLinks& links,
                                       bool with_shutters) const {
  const Missing missing = FirstMissing(links, with_shutters);
  const bool worth = state_ == State::kClear && IsNewest(links) && links.grant > spent_;
  return missing == Missing::kNothing && !worth ? Missing::kPermission : missing;
}

// Itself, or a renewal of it.
bool PermissionChain::HasWorth() const { return grant_.number > 0 && !has_lost(grant_); }

bool PermissionChain::has_lost(const Grant& grant) const {
  return Grant{grant.number, kEveryRenewal} <= spent_;
}

bool PermissionChain::has_grant(const ChainLinks& links) const {
  return state_ == State::kClear && IsNewestGranted(links) && links.grant > spent_;
}

bool PermissionChain::may_reset(const ChainLinks& links) const {
  return state_ != State::kLatched && IsNewestGranted(links) && links.grant > spent_;
}

}  // namespace intaglio::cell
