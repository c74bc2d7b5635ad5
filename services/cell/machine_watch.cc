#include "services/cell/machine_watch.h"

#include <utility>

#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::cell {

using namespace std::chrono_literals;

bool MachineWatch::Silence::IsTooLong(bool present, std::chrono::nanoseconds now) {
  if (present) {
    since_ = -1ns;
    return false;
  }
  if (since_ < 0ns) since_ = now;
  return now - since_ > host::kMaxAbsence;
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
  const bool laser_away = laser_.IsTooLong(sight.laser_line_up, now);
  const bool motion_away = motion_.IsTooLong(sight.motion_fresh, now);
  const UnseenEvent event = Compare(sight);
  if (event != UnseenEvent::kNone) return event;
  if (laser_away) return UnseenEvent::kLaserAway;
  return motion_away ? UnseenEvent::kMotionAway : UnseenEvent::kNone;
}

}  // namespace intaglio::cell
