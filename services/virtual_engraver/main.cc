#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <random>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/platform/command_line/parent_death.h"
#include "services/platform/command_line/program.h"
#include "services/platform/link/line_session.h"
#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/commands.h"
#include "services/virtual_engraver/head/head_program.h"
#include "services/virtual_engraver/lines/panel.h"
#include "services/virtual_engraver/mill/mill_program.h"
#include "services/virtual_engraver/truth/truth_file.h"
#include "services/virtual_engraver/truth_options.h"

namespace {

using namespace intaglio;
using namespace intaglio::virtual_engraver;

volatile sig_atomic_t stop_asked = 0;

struct Options {
  std::string truth_file;
  std::string laser_line, motion_line, panel, glass_record;
  std::string head_line, mark_record;
  std::string mill_line, cut_record;
  MachineOptions machine;
  std::string speed = "1";
  std::vector<std::string> faults;
  int die_with_parent = 0;
};

void AddOptions(command_line::Command app, Options& o) {
  app.AddOption("--truth", o.truth_file,
                "truth file: the physics of this machine (proto/truth.proto)")
      .Require();
  app.AddOption("--laser-line", o.laser_line,
                "laser line: the symbolic link to make for a pseudo-terminal, or "
                "tcp:HOST:PORT to listen there (port 0: a free one)");
  app.AddOption("--motion-line", o.motion_line,
                "motion line, as --laser-line; the same symbolic link: one line carries "
                "both, as of a controller that moves and switches the laser");
  app.AddOption("--glass-record", o.glass_record, "file that records every crack");
  app.AddOption("--head-line", o.head_line,
                "in place of the three: a scan head behind this line, as --laser-line");
  app.AddOption("--mark-record", o.mark_record, "file that records what it burns");
  app.AddOption("--mill-line", o.mill_line,
                "in place of the three: a mill or a laser cutter with a controller of "
                "the grbl family behind this line, as --laser-line");
  app.AddOption("--cut-record", o.cut_record, "file that records what its tool does");
  app.AddOption("--panel", o.panel, "Unix socket for buttons and injected faults");
  command_line::AddParentFlag(app, o.die_with_parent);
  app.AddOption("--speed", o.speed, "1, N times real time, or lockstep").ShowDefault();
  app.AddOption("--fault", o.faults, "\"AT_TICK COMMAND\": inject a fault at a tick");
}

Status CheckLines(const Options& o) {
  const bool mill = !o.mill_line.empty(), head = mill || !o.head_line.empty();
  const std::pair<const char*, bool> needed[] = {
      {"--laser-line", head || !o.laser_line.empty()},
      {"--motion-line", head || !o.motion_line.empty()},
      {"--glass-record", head || !o.glass_record.empty()},
      {"--mark-record", !head || mill || !o.mark_record.empty()},
      {"--cut-record", !mill || !o.cut_record.empty()}};
  for (const auto& [name, given] : needed) {
    if (!given) return Fail(ErrorCode::kMissing, std::string(name) + " is required");
  }
  return {};
}

int ServeScanHead(const Options& o) {
  const auto truth = ReadTruthFile(o.truth_file);
  if (!truth) throw std::runtime_error(truth.error().message);
  HeadProgramOptions head{HeadOptionsOf(*truth), o.head_line, o.panel, o.mark_record};
  head.head.power_up = o.machine.laser.power_up;
  head.head.lockstep = o.machine.laser.lockstep;
  return ServeHead(head, stop_asked);
}

int ServeContours(const Options& o) {
  const auto truth = ReadTruthFile(o.truth_file);
  if (!truth) throw std::runtime_error(truth.error().message);
  MillProgramOptions mill = MillOptionsOf(*truth);
  mill.line = o.mill_line;
  mill.panel = o.panel;
  mill.cut_record = o.cut_record;
  mill.speed = o.machine.speed;
  return ServeMill(mill, stop_asked);
}

/// A mill goes by the clock, and has no ticks.
Status CheckMill(const Options& o) {
  if (o.mill_line.empty() || (o.speed != "lockstep" && o.faults.empty())) return {};
  return Fail(ErrorCode::kUnsupported,
              "a virtual mill has neither lockstep nor --fault: give --speed, e.g. 10, "
              "and press its buttons at its --panel");
}

Status Finish(Options& o) {
  INTAGLIO_TRY(CheckLines(o));
  INTAGLIO_TRY(CheckMill(o));
  const auto truth = INTAGLIO_TRY(ReadTruthFile(o.truth_file));
  MachineOptions& m = o.machine;
  m = OptionsOf(truth);
  m.laser.power_up = std::max(1u, std::random_device{}());
  if (m.stage.own_clock) {
    m.stage.own_clock->power_up = std::max(1u, std::random_device{}());
  }
  m.laser.lockstep = m.stage.waits_for_motion = o.speed == "lockstep";
  if (m.laser.lockstep) return {};
  char* end = nullptr;
  m.speed = std::strtod(o.speed.c_str(), &end);
  if (*end != '\0' || !(m.speed >= 0.01 && m.speed <= 1000)) {
    return Fail(ErrorCode::kInvalidValue,
                "--speed '" + o.speed + "': 0.01..1000, or lockstep", o.speed);
  }
  return {};
}

void WaitFor(const Plugs& plugs, const Panel* panel, std::chrono::nanoseconds time) {
  std::vector<pollfd> fds;
  for (const auto* plug : {&plugs.laser, &plugs.motion}) {
    if (!plug->line) continue;
    for (const int fd : plug->line->descriptors()) fds.push_back({fd, POLLIN, 0});
  }
  if (panel != nullptr) {
    for (const int fd : panel->fds()) fds.push_back({fd, POLLIN, 0});
  }
  const timespec timeout{0, static_cast<long>(time.count())};
  ppoll(fds.data(), fds.size(), &timeout, nullptr);
}

int Serve(Options& options) {
  auto glass = Glass::Create(
      options.glass_record,
      {options.machine.block.size_mm, options.machine.block.refractive_index,
       options.machine.block.numerical_aperture, options.machine.laser.power_up});
  if (!glass) throw std::runtime_error(glass.error().message);
  // A machine of steel does not wait for a busy host. In lockstep it waits for every
  // process.
  if (!options.machine.laser.lockstep) (void)link::AskForRealTime();
  std::vector<ScheduledFault> faults;
  for (const std::string& text : options.faults) {
    auto fault = ParseFault(text);
    if (!fault) throw std::runtime_error(fault.error().message);
    faults.push_back(std::move(*fault));
  }
  std::ranges::stable_sort(faults, {}, &ScheduledFault::tick);
  Machine machine(options.machine, std::move(*glass), link::MonotonicClock());
  Plugs plugs{{options.laser_line}, {options.motion_line}, options.machine.seed};
  plugs.one_line = options.laser_line == options.motion_line &&
                   !options.laser_line.starts_with("tcp:");
  Commands commands(machine, plugs);
  for (const auto& plugged : {commands.PlugLaser(), commands.PlugMotion()}) {
    if (!plugged) throw std::runtime_error(plugged.error().message);
  }
  std::optional<Panel> panel;
  if (!options.panel.empty()) {
    auto opened = Panel::Open(options.panel);
    if (!opened) throw std::runtime_error(opened.error().message);
    panel.emplace(std::move(*opened));
  }
  std::cout << "ready laser=" << plugs.laser.device << " motion=" << plugs.motion.device
            << std::endl;
  while (stop_asked == 0 && !commands.quit()) {
    commands.TakeHangUps();
    machine.StopAt(faults.empty() ? UINT64_MAX : faults.front().tick);
    const auto idle = machine.Turn();
    std::erase_if(faults, [&](const ScheduledFault& fault) {
      if (machine.laser().tick() < fault.tick) return false;
      std::cout << "tick " << machine.laser().tick() << ": " << fault.command << ": "
                << commands.Do(fault.command) << std::endl;
      return true;
    });
    if (panel)
      panel->Poll([&](const std::string& command) { return commands.Do(command); });
    if (idle.count() > 0) WaitFor(plugs, panel ? &*panel : nullptr, idle);
  }
  machine.laser().EnterSafeState();
  const auto flushed = machine.glass().Flush();
  if (!flushed) throw std::runtime_error(flushed.error().message);
  std::cout << "ends with " << Counted(machine.glass().crack_count(), "crack")
            << " in the glass" << std::endl;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const pid_t parent = getppid();
  command_line::Program program("virtual-engraver",
                                "a laser engraving machine behind two lines");
  program.root().SetFooter(
      "Example: virtual-engraver --truth els-03-truth.textproto --laser-line /tmp/laser "
      "--motion-line /tmp/motion --glass-record /tmp/glass.rec --panel /tmp/panel "
      "--speed lockstep\n"
      "Usually started by `intaglio run` or `intaglio up`; docs/protocols.md describes "
      "its protocols.");
  Options options;
  AddOptions(program.root(), options);
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  if (!command_line::EndWithParent(options.die_with_parent, parent))
    return 1;  // it was quicker
  if (const auto finished = Finish(options); !finished) {
    std::cerr << "virtual-engraver: " << finished.error().message << "\n";
    return 2;
  }
  struct sigaction action = {};
  action.sa_handler = [](int) { stop_asked = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
  try {
    if (!options.mill_line.empty()) return ServeContours(options);
    return options.head_line.empty() ? Serve(options) : ServeScanHead(options);
  } catch (const std::exception& error) {
    std::cerr << "virtual-engraver: " << error.what() << "\n";
    return 1;
  }
}
