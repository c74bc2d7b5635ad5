#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "services/platform/command_line/program.h"
#include "services/platform/link/line_session.h"
#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/commands.h"
#include "services/virtual_engraver/panel.h"

namespace {

using namespace intaglio;
using namespace intaglio::virtual_engraver;

volatile sig_atomic_t stop_asked = 0;

struct Options {
  std::string laser_line, motion_line, panel, glass_record;
  MachineOptions machine;
  std::vector<double> travel_min = {0, 0, 0}, travel_max = {170, 170, 170};
  std::vector<double> block_size = {100, 100, 100}, block_origin = {0, 0, 0};
  double tolerance_um = 10;
  int channels = 1;
  std::string speed = "1", positioner;
  std::vector<std::string> faults;
  unsigned seed = 0;
  double clock_drift_ppm = 0;
  double line_jitter_ms = 0;
  pid_t die_with_parent = 0;  // its process id; -1: whoever is the parent at first
};

Vec3 ToVec3(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

void AddOptions(command_line::Command app, Options& o) {
  const auto triple = [&app](const char* name, std::vector<double>& value,
                             const char* text) {
    app.AddOption(name, value, text).SplitAt(',').TakeValues(3).ShowDefault();
  };
  MachineOptions& m = o.machine;
  app.AddOption("--laser-line", o.laser_line, "symbolic link to make for the laser line")
      .Require();
  app.AddOption("--motion-line", o.motion_line,
                "symbolic link to make for the motion line")
      .Require();
  app.AddOption("--glass-record", o.glass_record, "file that remembers every crack")
      .Require();
  app.AddOption("--panel", o.panel, "Unix socket for buttons and misbehaviour");
  app.AddFlag("--die-with-parent{-1}", o.die_with_parent,
              "power off when the process that started this one ends; =PID names it, "
              "should it be quicker");
  app.AddOption("--rates", m.laser.rates_hz, "lamp sync rates, Hz; the first at power-up")
      .SplitAt(',')
      .Within(0.1, 100000.0)
      .ShowDefault();
  app.AddOption("--warm-up", m.laser.warm_up_s, "lamp warm-up, s of machine time")
      .Within(0.0, 3600.0)
      .ShowDefault();
  triple("--travel-min", o.travel_min, "lower ends of the axes, mm");
  triple("--travel-max", o.travel_max, "upper ends of the axes, mm");
  triple("--block-size", o.block_size, "block, mm");
  triple("--block-origin", o.block_origin, "its corner in the machine frame, mm");
  app.AddOption("--positioner", o.positioner,
                "what the axes carry: X,Y,Z, each head or block, -head or -block if it "
                "counts down; or arm,PIVOT_DISTANCE_MM,ARM_LENGTH_MM,Z, where the axes "
                "are arm (rad), table (rad), z; default: the head");
  app.AddOption("--stage-lag", m.stage.lag_s, "first-order lag of the stage, s")
      .Within(0.0, 0.1)
      .ShowDefault();
  app.AddOption("--position-tolerance-um", o.tolerance_um, "of the in-position output")
      .Within(0.001, 10000.0)
      .ShowDefault();
  app.AddOption("--brake-acceleration", m.stage.brake_acceleration_mm_s2, "mm/s^2")
      .Within(1.0, 1e6)
      .ShowDefault();
  app.AddOption("--refractive-index", m.block.refractive_index,
                "of the block at the wavelength")
      .Within(1.0, 4.0)
      .ShowDefault();
  app.AddOption("--na", m.block.numerical_aperture, "numerical aperture in air")
      .Within(0.001, 0.95)
      .ShowDefault();
  app.AddOption("--channels", o.channels, "channels with a shutter and a block each")
      .Within(1, 4)
      .ShowDefault();
  app.AddOption("--laser-serial", m.laser.serial_number,
                "serial number that the laser controller reports; '': none")
      .ShowDefault();
  app.AddOption("--motion-serial", m.stage.serial_number,
                "serial number that the stage's controller reports; '': none")
      .ShowDefault();
  app.AddOption("--speed", o.speed, "1, N times real time, or lockstep").ShowDefault();
  app.AddOption("--clock-drift-ppm", o.clock_drift_ppm,
                "the stage's controller runs on a clock of its own, this much too fast; "
                "0: on the laser's ticks")
      .Within(-200.0, 200.0)
      .ShowDefault();
  app.AddOption("--line-jitter-ms", o.line_jitter_ms,
                "what is said on a serial line arrives up to this much later")
      .Within(0.0, 2.0)
      .ShowDefault();
  app.AddOption("--fault", o.faults, "\"AT_TICK COMMAND\": misbehave by itself");
  app.AddOption("--seed", o.seed, "of random misbehaviour").ShowDefault();
}

/// What the line can carry, so that the host reads what was typed.
Status CheckSerialNumber(const char* option, const std::string& text) {
  const bool printable =
      std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (printable && text.size() <= 64) return {};
  return Fail(ErrorCode::kInvalidValue,
              std::string(option) + ": give 0 to 64 printable ASCII characters", text);
}

Status Finish(Options& o) {
  MachineOptions& m = o.machine;
  m.stage.travel_min_mm = ToVec3(o.travel_min);
  m.stage.travel_max_mm = ToVec3(o.travel_max);
  m.block.size_mm = ToVec3(o.block_size);
  m.block.origin_mm = ToVec3(o.block_origin);
  m.stage.position_tolerance_mm = o.tolerance_um / 1000;
  const auto positioner = ParsePositioner(o.positioner);
  if (!positioner) {
    return Fail(positioner.error().code, "--positioner: " + positioner.error().message);
  }
  m.positioner = *positioner;
  m.stage.focus_per_axis_unit_mm = FocusPerAxisUnitMm(
      m.positioner, {m.block.origin_mm, m.block.origin_mm + m.block.size_mm});
  m.laser.channels = static_cast<std::uint8_t>(o.channels);
  m.laser.power_up = std::random_device{}();
  m.laser.lockstep = m.stage.waits_for_motion = o.speed == "lockstep";
  m.seed = o.seed;
  m.line_jitter = std::chrono::nanoseconds(std::llround(1e6 * o.line_jitter_ms));
  if (o.clock_drift_ppm != 0) {
    m.stage.own_clock = OwnClockOptions{o.clock_drift_ppm, 1e-3 * o.line_jitter_ms,
                                        std::max(1u, std::random_device{}()), o.seed};
  }
  if ((m.stage.travel_max_mm.array() <= m.stage.travel_min_mm.array()).any()) {
    return Fail(ErrorCode::kInvalidValue,
                "--travel-max has to be above --travel-min in each axis");
  }
  if ((m.block.size_mm.array() <= 0).any()) {
    return Fail(ErrorCode::kInvalidValue, "--block-size has to be positive in each axis");
  }
  if (auto good = CheckSerialNumber("--laser-serial", m.laser.serial_number); !good)
    return good;
  if (auto good = CheckSerialNumber("--motion-serial", m.stage.serial_number); !good)
    return good;
  if (m.laser.lockstep) return {};
  char* end = nullptr;
  m.speed = std::strtod(o.speed.c_str(), &end);
  if (*end != '\0' || !(m.speed >= 0.01 && m.speed <= 1000)) {
    return Fail(ErrorCode::kInvalidValue,
                "--speed '" + o.speed + "': 0.01..1000, or lockstep", o.speed);
  }
  return {};
}

// A host that closes its port is a lost line, before any silence tells.
void TakeHangUps(Machine& machine, Plugs& plugs) {
  if (plugs.laser && plugs.laser->HostHasGone()) {
    machine.PlugLaserLine(plugs.laser->MachineEnd());
  }
  if (plugs.motion && plugs.motion->HostHasGone()) {
    machine.PlugMotionLine(plugs.motion->MachineEnd());
  }
}

void WaitFor(const Plugs& plugs, const Panel* panel, std::chrono::nanoseconds time) {
  std::vector<pollfd> fds;
  for (const auto* line : {&plugs.laser, &plugs.motion}) {
    // A line without a host is ready at any time.
    if (*line && (*line)->host_there()) fds.push_back({(*line)->fd(), POLLIN, 0});
  }
  if (panel != nullptr) {
    for (const int fd : panel->fds()) fds.push_back({fd, POLLIN, 0});
  }
  const timespec timeout{0, static_cast<long>(time.count())};
  ppoll(fds.data(), fds.size(), &timeout, nullptr);
}

int Serve(Options& options) {
  auto glass =
      Glass::Create(options.glass_record, {options.machine.block.size_mm,
                                           options.machine.block.refractive_index,
                                           options.machine.block.numerical_aperture});
  if (!glass) throw std::runtime_error(glass.error().message);
  // A machine of steel does not wait for a busy host. In lockstep it waits for everybody.
  if (!options.machine.laser.lockstep) (void)link::AskForRealTime();
  std::vector<ScheduledFault> faults;
  for (const std::string& text : options.faults) {
    auto fault = ParseFault(text);
    if (!fault) throw std::runtime_error(fault.error().message);
    faults.push_back(std::move(*fault));
  }
  Machine machine(options.machine, std::move(*glass), link::MonotonicClock());
  Plugs plugs{options.laser_line, options.motion_line, {}, {}, options.seed};
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
  std::cout << "ready laser=" << options.laser_line << " motion=" << options.motion_line
            << std::endl;
  while (stop_asked == 0 && !commands.quit()) {
    TakeHangUps(machine, plugs);
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
  std::cout << "ends with " << machine.glass().crack_count() << " cracks in the glass"
            << std::endl;
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const pid_t parent = getppid();
  command_line::Program program("virtual-engraver",
                                "a laser engraving machine behind two pseudo-terminals");
  program.root().SetFooter(
      "Example: virtual-engraver --laser-line /tmp/laser --motion-line /tmp/motion "
      "--glass-record /tmp/glass.rec --panel /tmp/panel --speed lockstep\n"
      "Usually started by `intaglio run` or `intaglio up`; docs/protocols.md says what "
      "it speaks.");
  Options options;
  AddOptions(program.root(), options);
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  if (options.die_with_parent != 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const pid_t starter = options.die_with_parent > 0 ? options.die_with_parent : parent;
    if (getppid() != starter) return 1;  // it was quicker
  }
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
    return Serve(options);
  } catch (const std::exception& error) {
    std::cerr << "virtual-engraver: " << error.what() << "\n";
    return 1;
  }
}
