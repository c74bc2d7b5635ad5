// The virtual BJJCZ board as a program, in real time:
//
//   virtual-bjjcz --line LINE --record FILE [--panel SOCKET] [--axis STEPS]
//     [--guide OUTPUT]
//
// LINE: a path, for a symbolic link to a pseudo-terminal, or "tcp:127.0.0.1:0" for a TCP
// port; "ready LINE" on the output has what a host opens. Each mark command that the beam
// made something of is a line of the record when it has ended: "mark X0 Y0 X1 Y1 BEGIN_US
// END_US LIT_US", in places of the board, 32768 the centre; each point that it lit at
// rest is "flash X Y AXIS BEGIN_US LIT_US PULSES", AXIS in steps. With --axis its axis
// was homed, and is there. With --guide each way of the mirrors that began with this
// output on is "guide X0 Y0 X1 Y1", and "gate" behind it, if the gate was on, too. The
// panel takes lines of text (services/virtual_engraver/lines/panel.h): door open|close,
// power off|on, unplug, plug. SIGTERM ends it.

#include <signal.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/lines/machine_line.h"
#include "services/virtual_engraver/lines/panel.h"
#include "tests/services/drivers/bjjcz/virtual_bjjcz.h"

namespace {

using namespace intaglio;
volatile sig_atomic_t ends = 0;
constexpr int kDoorInput = 3;

/// Writes the points that have ended since the last call.
void RecordFlashes(const bjjcz::VirtualBjjcz& board, std::size_t& written,
                   std::ofstream& record) {
  const auto& flashes = board.flashes();
  if (written == flashes.size()) return;
  for (; written < flashes.size(); ++written) {
    const bjjcz::Flash& flash = flashes[written];
    if (flash.lit_us <= 0) continue;
    record << "flash " << flash.at[0] << ' ' << flash.at[1] << ' ' << flash.axis << ' '
           << std::llround(flash.begin_us) << ' ' << flash.lit_us << ' ' << flash.pulses
           << '\n';
  }
  record.flush();
}

/// Writes what has ended since the last call; `guide`: output of a guide laser, -1: none.
void Record(const bjjcz::VirtualBjjcz& board, int guide, std::size_t& written,
            std::ofstream& record) {
  const auto& strokes = board.strokes();
  if (written == strokes.size()) return;
  for (; written < strokes.size(); ++written) {
    const bjjcz::Stroke& stroke = strokes[written];
    if (guide >= 0 && (stroke.outputs >> guide & 1) != 0) {
      record << "guide " << stroke.from[0] << ' ' << stroke.from[1] << ' ' << stroke.to[0]
             << ' ' << stroke.to[1] << ((stroke.outputs & 1) != 0 ? " gate" : "") << '\n';
    }
    if (!stroke.is_mark || stroke.lit_us <= 0) continue;
    record << "mark " << stroke.from[0] << ' ' << stroke.from[1] << ' ' << stroke.to[0]
           << ' ' << stroke.to[1] << ' ' << std::llround(stroke.begin_us) << ' '
           << std::llround(stroke.end_us) << ' ' << stroke.lit_us << '\n';
  }
  record.flush();
}

/// What a person does at the machine; the answer for the panel.
std::string Act(const std::string& command, bjjcz::VirtualBjjcz& board, bool& unplugged) {
  const std::map<std::string, std::function<void()>> acts = {
      {"door open", [&] { board.SetInput(kDoorInput, false); }},
      {"door close", [&] { board.SetInput(kDoorInput, true); }},
      {"power off", [&] { board.SwitchOff(); }},
      {"power on", [&] { board.SwitchOn(); }},
      {"unplug", [&] { unplugged = true; }},
      {"plug", [&] { unplugged = false; }},
  };
  const auto act = acts.find(command);
  if (act == acts.end()) return "error: the panel has no '" + command + "'";
  act->second();
  return "ok";
}

void Serve(virtual_engraver::MachineLine& line, const std::string& record_file, int axis,
           int guide, std::optional<virtual_engraver::Panel> panel) {
  using Clock = std::chrono::steady_clock;
  bjjcz::VirtualBjjczOptions options;
  options.needs_oscillator = false;
  bjjcz::VirtualBjjcz board(options);
  board.SetAxis(axis);
  std::ofstream record(record_file);
  bool unplugged = false;
  auto bytes = line.MachineEnd();
  std::size_t written = 0, written_flashes = 0;
  auto last = Clock::now();
  while (ends == 0) {
    if (line.HostHasGone()) {
      bytes = line.MachineEnd();
      board.Reopen();
    }
    std::array<std::byte, 4096> buffer;
    const auto count = bytes->Read(buffer);
    if (count && *count > 0 && !unplugged)
      board.Write({reinterpret_cast<const char*>(buffer.data()), *count});
    if (panel) {
      panel->Poll(
          [&](const std::string& command) { return Act(command, board, unplugged); });
    }
    const auto now = Clock::now();
    board.Advance(std::chrono::duration<double, std::micro>(now - last).count());
    last = now;
    const std::string sent = board.Read();
    if (!sent.empty() && !unplugged) (void)bytes->Write(std::as_bytes(std::span(sent)));
    Record(board, guide, written, record);
    RecordFlashes(board, written_flashes, record);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string device, record_file, panel_file;
  int axis = 0, guide = -1;
  CLI::App app("A BJJCZ board for tests.");
  app.add_option("--line", device)->required();
  app.add_option("--record", record_file)->required();
  app.add_option("--panel", panel_file);
  app.add_option("--axis", axis);
  app.add_option("--guide", guide);
  CLI11_PARSE(app, argc, argv);
  signal(SIGTERM, [](int) { ends = 1; });
  auto line = virtual_engraver::OpenMachineLine(device, "virtual bjjcz");
  if (!line) {
    std::cerr << line.error().message << "\n";
    return 2;
  }
  std::optional<virtual_engraver::Panel> panel;
  if (!panel_file.empty()) {
    auto opened = virtual_engraver::Panel::Open(panel_file);
    if (!opened) {
      std::cerr << opened.error().message << "\n";
      return 2;
    }
    panel.emplace(std::move(*opened));
  }
  // A machine of steel does not wait for a busy host.
  (void)link::AskForRealTime();
  std::cout << "ready " << (*line)->device() << std::endl;
  Serve(**line, record_file, axis, guide, std::move(panel));
  return 0;
}
