#pragma once

// The virtual engraver as a scan head: its options from a truth file, its panel, and its
// loop.

#include <csignal>
#include <string>

#include "proto/truth.pb.h"
#include "services/virtual_engraver/head/head_machine.h"
#include "services/virtual_engraver/lines/machine_line.h"

namespace intaglio::virtual_engraver {

/// `truth` is checked (truth/truth_check.h).
HeadOptions HeadOptionsOf(const MachineTruth& truth);

/// The buttons of the panel: key on|off, door open|close, estop press|release, plug,
/// unplug, status, quit.
class HeadCommands {
 public:
  HeadCommands(HeadMachine& machine, std::string device)
      : machine_(machine), device_(std::move(device)) {}

  Status Plug();
  /// A host that closes its end is a lost line, before any silence shows it.
  void TakeHangUp();
  /// "ok", "ok {...}" or "error why".
  std::string Do(const std::string& command);
  bool quit() const { return quit_; }
  /// What a host has to open.
  const std::string& device() const { return device_; }
  const MachineLine* line() const { return line_.get(); }

 private:
  HeadMachine& machine_;
  std::string device_;
  std::unique_ptr<MachineLine> line_;
  bool quit_ = false;
};

struct HeadProgramOptions {
  HeadOptions head;
  std::string line, panel, record;
};

/// Until `stop` or "quit" of the panel. Returns the exit code.
int ServeHead(const HeadProgramOptions& options, const volatile sig_atomic_t& stop);

}  // namespace intaglio::virtual_engraver
