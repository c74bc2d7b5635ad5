#pragma once

// A mill or a laser cutter as a program, in real time or at a multiple of it: a virtual
// grbl behind a line, the tool in it and the sheet under it. What the tool does is
// written to a record as it goes (engrave/formats/tool_way.h); nobody is asked for it.
//
// Its panel takes lines of text: door open|close, hold, reset, estop press|release,
// limit, alarm, error, power off|on, unplug, plug.

#include <signal.h>

#include <filesystem>
#include <string>

#include "engrave/formats/tool_way.h"
#include "proto/truth.pb.h"
#include "services/virtual_engraver/mill/virtual_grbl.h"

namespace intaglio::virtual_engraver {

struct MillProgramOptions {
  grbl::VirtualGrblOptions controller;
  formats::ToolWayHeader sheet;      ///< the tool in it, too
  std::string line, panel;           ///< as of main.cc; an empty panel: none
  double speed = 1;                  ///< of its clock, times real time
  std::filesystem::path cut_record;  ///< empty: none
  /// Texts for tests; empty: none. Each flash of a laser when it has ended: "flash X Y Z
  /// LIT_US REST_US LINE", where it began, in mm; "rest US" follows with the whole time
  /// lit at rest.
  std::filesystem::path flashes;
  /// "US X Y Z ON S" for each end of a straight piece of the tool's way.
  std::filesystem::path way;
};

/// Controller, tool and sheet of truth.mill.
MillProgramOptions MillOptionsOf(const MachineTruth& truth);

/// Serves until `stop_asked` is not 0; prints "ready LINE" first. Throws
/// std::runtime_error when a line, the panel or a record cannot be opened.
int ServeMill(const MillProgramOptions& options, volatile sig_atomic_t& stop_asked);

}  // namespace intaglio::virtual_engraver
