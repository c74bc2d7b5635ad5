#include "services/client/shop/stop_reset.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace intaglio::client {
namespace {

/// What keeps a machine from firing besides the stops of the bus.
std::vector<std::string> OpenInterlocks(const MachineStops& stops) {
  if (!stops.laser_line_up)
    return {"its laser does not answer, so that key and door are not known"};
  std::vector<std::string> open;
  if (!stops.key_on) open.emplace_back("the key is off");
  if (!stops.door_closed) open.emplace_back("the door is open");
  return open;
}

}  // namespace

bool StopReset::IsConfirmed(const MachineStops& stops) const {
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
  return fmt::format(
      "{}: the stop is reset, but the machine is still held: {}; then arm "
      "or resume the job",
      cell, fmt::join(open, ", "));
}

std::string AfterReset(const MachineStops& stops) {
  return fmt::format("{}arm or resume the job to continue",
                     stops.own_stop_released
                         ? ""
                         : "its own stop is pressed, or latched until the next arm; ");
}

}  // namespace intaglio::client
