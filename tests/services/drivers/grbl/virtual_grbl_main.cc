// The virtual grbl as a program, in real time, for tests that judge by its own texts:
//
//   virtual-grbl --line LINE --record FILE [--way FILE] [--panel SOCKET] [--hal]
//                [--spindle]
//
// LINE: a path, for a symbolic link to a pseudo-terminal, or "tcp:127.0.0.1:0" for a TCP
// port; "ready LINE" on the output has what a host opens. What --record (of flashes),
// --way and the panel hold is in services/virtual_engraver/mill/mill_program.h; the way
// is that of true places, over power cycles and lost steps. SIGTERM ends it.

#include <signal.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <stdexcept>

#include "services/virtual_engraver/mill/mill_program.h"

namespace {
volatile sig_atomic_t ends = 0;
}  // namespace

int main(int argc, char** argv) {
  using namespace intaglio;
  virtual_engraver::MillProgramOptions options;
  bool hal = false, spindle = false;
  CLI::App app("A grbl for tests.");
  app.add_option("--line", options.line)->required();
  app.add_option("--record", options.flashes)->required();
  app.add_option("--way", options.way);
  app.add_option("--panel", options.panel);
  app.add_flag("--hal", hal);
  app.add_flag("--spindle", spindle, "a mill: $32=0, $30=24000");
  CLI11_PARSE(app, argc, argv);
  signal(SIGTERM, [](int) { ends = 1; });
  options.controller = hal ? grbl::GrblHal() : grbl::Grbl11();
  options.controller.travel_min_mm = Vec3::Constant(-2);
  options.controller.travel_max_mm = Vec3::Constant(172);
  if (spindle) {
    options.controller.laser_mode = false;
    options.controller.max_power = 24000;
  }
  try {
    return virtual_engraver::ServeMill(options, ends);
  } catch (const std::runtime_error& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
