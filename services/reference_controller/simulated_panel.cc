#include "services/reference_controller/simulated_panel.h"

#include <algorithm>
#include <iterator>

#include "engrave/core/try.h"
#include "services/platform/link/laser_protocol.h"

namespace intaglio::reference_controller {
namespace {

struct Act {
  const char* command;
  Input input;
  bool on;
  bool of_laser, of_stage;
};

constexpr Act kActs[] = {
    {"key on", Input::kKey, true, true, false},
    {"key off", Input::kKey, false, true, false},
    {"door close", Input::kDoor, true, true, false},
    {"door open", Input::kDoor, false, true, false},
    {"estop release", Input::kStop, true, true, true},
    {"estop press", Input::kStop, false, true, true},
    {"drives ok", Input::kDrives, true, false, true},
    {"drives fault", Input::kDrives, false, false, true},
};

}  // namespace

Result<SimulatedPanel> SimulatedPanel::Open(const std::filesystem::path& socket,
                                            SimulatedPins& laser, SimulatedStage* stage) {
  auto panel = INTAGLIO_TRY(virtual_engraver::Panel::Open(socket));
  return SimulatedPanel(std::move(panel), laser, stage);
}

// One digit: there are up to 8 of them.
std::string SimulatedPanel::DoInput(const std::string& command) {
  const std::string text = command.substr(std::string("input ").size());
  const bool on = text.ends_with(" on");
  const int index = text.empty() ? -1 : text[0] - '1';
  const bool known =
      text.size() > 1 && (on ? text.substr(1) == " on" : text.substr(1) == " off");
  if (!known || index < 0 || index >= link::kMaxAccessories ||
      !laser_.Has(SpareInput(index)))
    return "error the board has no such input, or not this: input N on|off";
  laser_.Hold(SpareInput(index), on);
  return "ok";
}

std::string SimulatedPanel::Do(const std::string& command) {
  if (command.starts_with("input ")) return DoInput(command);
  const auto* const act =
      std::ranges::find_if(kActs, [&](const Act& one) { return command == one.command; });
  if (act == std::end(kActs)) {
    return "error unknown command '" + command +
           "': key on|off, door open|close, estop press|release, drives fault|ok, "
           "input N on|off";
  }
  if (!act->of_laser && stage_ == nullptr) return "error there is no --stage-board";
  if (act->of_laser) laser_.Hold(act->input, act->on);
  if (act->of_stage && stage_ != nullptr) stage_->Hold(act->input, act->on);
  return "ok";
}

}  // namespace intaglio::reference_controller
