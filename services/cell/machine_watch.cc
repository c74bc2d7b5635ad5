#include "services/cell/machine_watch.h"

#include <utility>

namespace intaglio::cell {

namespace {

bool IsAwayTooLong(host::AbsenceSum& absence, bool present,
                   std::chrono::nanoseconds now) {
  if (present) {
    absence.End(now);
  } else {
    absence.Begin(now);
  }
  return absence.IsTooLong(now);
}

}  // namespace

void MachineWatch::AcceptSilences(std::chrono::nanoseconds now) {
  for (host::AbsenceSum* absence : {&laser_, &motion_}) {
    if (!absence->absent()) absence->Restart(now);
  }
}

UnseenEvent MachineWatch::Compare(const Sight& sight) {
  if (!sight.laser_line_up || sight.counters.power_up == 0) return UnseenEvent::kNone;
  const MachineCounters known = std::exchange(known_, sight.counters);
  if (known.power_up == 0) return UnseenEvent::kNotWatched;
  if (known.power_up != known_.power_up) return UnseenEvent::kPowerCycle;
  // One that is open now is seen, and acts by itself.
  const bool opened = known.openings != known_.openings && sight.interlocks_closed;
  return opened ? UnseenEvent::kOpened : UnseenEvent::kNone;
}

UnseenEvent MachineWatch::Update(const Sight& sight, std::chrono::nanoseconds now) {
  const bool laser_away = IsAwayTooLong(laser_, sight.laser_line_up, now);
  const bool motion_away = IsAwayTooLong(motion_, sight.motion_seen, now);
  const UnseenEvent event = Compare(sight);
  if (event != UnseenEvent::kNone) return event;
  if (laser_away) return UnseenEvent::kLaserAway;
  return motion_away ? UnseenEvent::kMotionAway : UnseenEvent::kNone;
}

}  // namespace intaglio::cell
