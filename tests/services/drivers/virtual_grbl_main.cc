// The virtual grbl as a program, in real time:
//
//   virtual-grbl --line LINE --record FILE [--way FILE] [--panel SOCKET] [--hal]
//                [--spindle]
//
// LINE: a path, for a symbolic link to a pseudo-terminal, or "tcp:127.0.0.1:0" for a TCP
// port; "ready LINE" on the output has what a host opens. Each flash of the laser is a
// line of the record when it has ended: "flash X Y Z LIT_US REST_US LINE", where it
// began, in mm; "rest US" follows with the whole time lit at rest. The way has a line for
// each end of a straight piece of the tool's way, "US X Y Z ON S": since the start, the
// true place in mm of the machine's axes as they were at the start, over power cycles and
// lost steps, and whether output or spindle was on along it, with which S.
// The panel takes lines of text (services/virtual_engraver/panel.h): door open|close,
// hold, reset, estop press|release, limit, alarm, error, power off|on, unplug, plug.
// SIGTERM ends it.

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
#include <string>
#include <thread>

#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/machine_line.h"
#include "services/virtual_engraver/panel.h"
#include "tests/services/drivers/virtual_grbl.h"

namespace {

using namespace intaglio;
volatile sig_atomic_t ends = 0;

/// Writes the flashes that have ended since the last call.
void Record(const grbl::VirtualGrblMotion& motion, std::size_t& written,
            std::ofstream& record, double steps_per_mm) {
  const auto& flashes = motion.flashes();
  const std::size_t ended = flashes.size() - (motion.lit() ? 1 : 0);
  if (written == ended) return;
  for (; written < ended; ++written) {
    const grbl::Flash& flash = flashes[written];
    record << "flash";
    for (const auto steps : flash.on_at) {
      record << ' ' << static_cast<double>(steps) / steps_per_mm;
    }
    record << ' ' << flash.off_us - flash.on_us << ' ' << flash.at_rest_us << ' '
           << flash.line << '\n';
  }
  record << "rest " << motion.lit_at_rest_us() << std::endl;
}

void RecordWay(const grbl::VirtualGrblMotion& motion, std::size_t& written,
               std::ofstream& file, double steps_per_mm) {
  const auto& way = motion.way();
  if (written == way.size()) return;
  for (; written < way.size(); ++written) {
    const grbl::WayEnd& end = way[written];
    file << std::llround(end.at_us);
    for (const auto steps : end.at)
      file << ' ' << static_cast<double>(steps) / steps_per_mm;
    file << ' ' << end.on << ' ' << end.power << '\n';
  }
  file.flush();
}

/// What a person does at the machine; the answer for the panel.
std::string Act(const std::string& command, grbl::VirtualGrbl& controller,
                bool& unplugged) {
  const std::map<std::string, std::function<void()>> acts = {
      {"door open", [&] { controller.SetDoor(true); }},
      {"door close", [&] { controller.SetDoor(false); }},
      {"hold", [&] { controller.PressHold(); }},
      {"reset", [&] { controller.PressReset(); }},
      {"estop press", [&] { controller.SetEmergencyStop(true); }},
      {"estop release", [&] { controller.SetEmergencyStop(false); }},
      {"limit", [&] { controller.HitLimit(); }},
      {"alarm", [&] { controller.FailDrive(); }},
      {"error", [&] { controller.RefuseNextLine(); }},
      {"power off", [&] { controller.SwitchOff(); }},
      {"power on", [&] { controller.PowerCycle(); }},
      {"unplug", [&] { unplugged = true; }},
      {"plug", [&] { unplugged = false; }},
  };
  const auto act = acts.find(command);
  if (act == acts.end()) return "error: the panel has no '" + command + "'";
  act->second();
  return "ok";
}

struct Files {
  std::string record, way, panel;
};

void Serve(virtual_engraver::MachineLine& line, const grbl::VirtualGrblOptions& options,
           const Files& files, std::optional<virtual_engraver::Panel> panel) {
  using Clock = std::chrono::steady_clock;
  grbl::VirtualGrbl controller(options);
  std::ofstream record(files.record), way;
  if (!files.way.empty()) way.open(files.way);
  bool unplugged = false, connected = false;
  auto bytes = line.MachineEnd();
  std::size_t written = 0, way_written = 0;
  auto last = Clock::now();
  while (ends == 0) {
    if (line.HostHasGone()) {
      bytes = line.MachineEnd();
      connected = false;
    }
    std::array<std::byte, 256> buffer;
    const auto count = bytes->Read(buffer);
    if (count && *count > 0 && !unplugged) {
      connected = true;
      controller.Write({reinterpret_cast<const char*>(buffer.data()), *count});
    }
    if (panel) {
      panel->Poll([&](const std::string& command) {
        return Act(command, controller, unplugged);
      });
    }
    const auto now = Clock::now();
    controller.Advance(std::chrono::duration<double, std::micro>(now - last).count());
    last = now;
    const std::string sent = controller.Read();
    // Nobody keeps what a serial line carries while no host listens.
    if (!sent.empty() && connected && !unplugged)
      (void)bytes->Write(std::as_bytes(std::span(sent)));
    Record(controller.motion(), written, record, options.motion.steps_per_mm);
    if (way.is_open())
      RecordWay(controller.motion(), way_written, way, options.motion.steps_per_mm);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::string device;
  Files files;
  bool hal = false, spindle = false;
  CLI::App app("A grbl for tests.");
  app.add_option("--line", device)->required();
  app.add_option("--record", files.record)->required();
  app.add_option("--way", files.way);
  app.add_option("--panel", files.panel);
  app.add_flag("--hal", hal);
  app.add_flag("--spindle", spindle, "a mill: $32=0, $30=24000");
  CLI11_PARSE(app, argc, argv);
  signal(SIGTERM, [](int) { ends = 1; });
  auto line = virtual_engraver::OpenMachineLine(device, "virtual grbl");
  if (!line) {
    std::cerr << line.error().message << "\n";
    return 2;
  }
  grbl::VirtualGrblOptions options = hal ? grbl::GrblHal() : grbl::Grbl11();
  options.travel_min_mm = Vec3::Constant(-2);
  options.travel_max_mm = Vec3::Constant(172);
  if (spindle) {
    options.laser_mode = false;
    options.max_power = 24000;
  }
  std::optional<virtual_engraver::Panel> panel;
  if (!files.panel.empty()) {
    auto opened = virtual_engraver::Panel::Open(files.panel);
    if (!opened) {
      std::cerr << opened.error().message << "\n";
      return 2;
    }
    panel.emplace(std::move(*opened));
  }
  // A machine of steel does not wait for a busy host.
  (void)link::AskForRealTime();
  std::cout << "ready " << (*line)->device() << std::endl;
  Serve(**line, options, files, std::move(panel));
  return 0;
}
