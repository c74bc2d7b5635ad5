#include "services/client/shop/stop_reset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/bus/open_chain.h"

namespace intaglio::client {
namespace {

constexpr char kButton[] = "its own stop button is pressed";

/// What keeps a machine from firing besides the stops of the bus.
std::vector<std::string> OpenInterlocks(const MachineStops& stops) {
  if (!stops.laser_line_up)
    return {"its laser does not answer, so that key and door are not known"};
  if (bus::IsChainOpen(stops.key_on, stops.door_closed, stops.own_stop_released))
    return {std::string(bus::kChainIsOpen)};
  std::vector<std::string> open;
  if (!stops.key_on) open.emplace_back("the key is off");
  if (!stops.door_closed) open.emplace_back("the door is open");
  if (!stops.own_stop_released) open.emplace_back(kButton);
  return open;
}

bool HoldsOwnStop(const MachineStops& stops) {
  return stops.laser_line_up && !stops.own_stop_released;
}

}  // namespace

Status StopReset::Turn(const MachineStops& stops, Clock::time_point now) {
  switch (phase_) {
    case Phase::kBegins:
      return Begin(stops);
    case Phase::kPresses:
      if (Names(stops.held, seen_.front().source, seen_.front().number)) return Release();
      return {};
    case Phase::kReleases:
      if (!IsReleased(stops)) return {};
      own_stop_ends_ = now + kOwnStopTime;
      phase_ = Phase::kOwnStop;
      [[fallthrough]];
    case Phase::kOwnStop:
      if (!HoldsOwnStop(stops) || now >= own_stop_ends_) phase_ = Phase::kOver;
      return {};
    case Phase::kOver:
      break;
  }
  return {};
}

Status StopReset::Begin(const MachineStops& stops) {
  if (!seen_.empty() || !HoldsOwnStop(stops)) return Release();
  const std::uint64_t number = INTAGLIO_TRY(source_->Press(reason_));
  seen_ = {{source_->name(), number}};
  phase_ = Phase::kPresses;
  return {};
}

Status StopReset::Release() {
  INTAGLIO_TRY(source_->Release(seen_, reason_));
  phase_ = Phase::kReleases;
  return {};
}

bool StopReset::IsReleased(const MachineStops& stops) const {
  return std::ranges::none_of(stops.held, [this](const HeldPress& press) {
    return Names(seen_, press.source, press.number);
  });
}

std::string TextOf(const HeldPress& press) {
  return fmt::format("{} (number {})", press.source, press.number);
}

std::string WhyStillHeld(const std::string& cell, const MachineStops& stops) {
  const auto open = OpenInterlocks(stops);
  const std::string also = open.empty() ? "" : fmt::format("; {}", fmt::join(open, ", "));
  if (stops.pressed && stops.held.empty()) {
    return fmt::format(
        "{} is still stopped by more presses than it can name{}: restart "
        "its synchronizer",
        cell, also);
  }
  if (stops.pressed) {
    std::vector<std::string> held;
    for (const HeldPress& press : stops.held) held.push_back(TextOf(press));
    return fmt::format(
        "{} is still stopped by a press that came during the reset: {}{}; "
        "check the machine, then reset it again",
        cell, fmt::join(held, ", "), also);
  }
  if (open.empty()) return "";
  return fmt::format("{}: the stop is reset, but the machine is still held: {}; then {}",
                     cell, fmt::join(open, ", "),
                     open.back() == kButton
                         ? "release the button and reset it again"
                         : "a job continues when it is armed or resumed");
}

}  // namespace intaglio::client
