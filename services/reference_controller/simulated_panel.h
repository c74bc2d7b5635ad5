#pragma once

// Buttons and switches of simulated boards, as lines of text on a Unix-domain socket
// (services/virtual_engraver/lines/panel.h):
//
//   key on|off, door open|close, estop press|release, drives fault|ok,
//   input N on|off
//
// The stop button is wired to both boards. A door opens though it is locked, as one that
// is forced.

#include <filesystem>
#include <string>

#include "engrave/core/result.h"
#include "services/reference_controller/simulated_pins.h"
#include "services/reference_controller/simulated_stage.h"
#include "services/virtual_engraver/lines/panel.h"

namespace intaglio::reference_controller {

class SimulatedPanel {
 public:
  /// Both outlive this; without a stage, null. kIo.
  static Result<SimulatedPanel> Open(const std::filesystem::path& socket,
                                     SimulatedPins& laser, SimulatedStage* stage);

  /// Takes what has come; never blocks. From the thread of the laser.
  void Poll() {
    panel_.Poll([this](const std::string& command) { return Do(command); });
  }

 private:
  SimulatedPanel(virtual_engraver::Panel panel, SimulatedPins& laser,
                 SimulatedStage* stage)
      : panel_(std::move(panel)), laser_(laser), stage_(stage) {}
  std::string Do(const std::string& command);
  std::string DoInput(const std::string& command);

  virtual_engraver::Panel panel_;
  SimulatedPins& laser_;
  SimulatedStage* stage_;
};

}  // namespace intaglio::reference_controller
