#pragma once

// The commands of the panel and of --fault: buttons, and kinds of misbehaviour.
//
//   key on|off            door open|close|force   estop press|release
//   lock break|mend       air on|off
//   stick x|y|z|all       unstick                 miss N
//   blind N               lamp cold               lamp-sync miss N | late MS
//   limit                 buffer starved|full
//   push-block X Y
//   drop-bytes RATIO laser|motion                 unplug laser|motion
//   plug laser|motion     clock-drift PPM         status
//   quit

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/virtual_engraver/lines/machine_line.h"
#include "services/virtual_engraver/machine.h"

namespace intaglio::virtual_engraver {

/// The two plugs at the back of the machine.
struct Plugs {
  struct Plug {
    /// As OpenMachineLine takes it; once it was plugged in, what a host has to open.
    std::string device;
    std::unique_ptr<MachineLine> line = {};  ///< null: unplugged
  };
  Plug laser, motion;
  unsigned seed = 0;
  bool one_line = false;  ///< laser.device carries both; motion has no line
};

class Commands {
 public:
  Commands(Machine& machine, Plugs& plugs) : machine_(machine), plugs_(plugs) {}

  Status PlugLaser();
  Status PlugMotion();
  /// A host that closes its end is a lost line, before any silence shows it.
  void TakeHangUps();
  /// "ok", "ok {...}" or "error why".
  std::string Do(const std::string& command);
  bool quit() const { return quit_; }

 private:
  void PlugEnd(std::unique_ptr<link::ByteStream> end);
  std::string DoCommand(const std::vector<std::string>& words);
  std::string DoLamp(const std::vector<std::string>& words);
  std::string DoDoor(const std::string& verb, const std::string& what);
  std::string DoInput(const std::vector<std::string>& words);
  std::string DoStage(const std::vector<std::string>& words);
  std::string Line(const std::string& verb, const std::string& which);
  Machine& machine_;
  Plugs& plugs_;
  bool quit_ = false;
};

/// "AT_TICK COMMAND", done once the machine has reached that tick.
struct ScheduledFault {
  std::uint64_t tick = 0;
  std::string command;
};
Result<ScheduledFault> ParseFault(const std::string& text);

}  // namespace intaglio::virtual_engraver
