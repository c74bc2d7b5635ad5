#include "services/virtual_engraver/head/head_program.h"

#include <poll.h>

#include <iostream>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "engrave/core/try.h"
#include "services/platform/link/real_time.h"
#include "services/virtual_engraver/lines/panel.h"

namespace intaglio::virtual_engraver {
namespace {

void Check(const Status& status) {
  if (!status) throw std::runtime_error(status.error().message);
}

void WaitForHead(const HeadCommands& commands, const Panel* panel,
                 std::chrono::nanoseconds time) {
  std::vector<pollfd> fds;
  if (commands.line() != nullptr) {
    for (const int fd : commands.line()->descriptors()) fds.push_back({fd, POLLIN, 0});
  }
  if (panel != nullptr) {
    for (const int fd : panel->fds()) fds.push_back({fd, POLLIN, 0});
  }
  const timespec timeout{0, static_cast<long>(time.count())};
  ppoll(fds.data(), fds.size(), &timeout, nullptr);
}

}  // namespace

HeadOptions HeadOptionsOf(const MachineTruth& truth) {
  const HeadTruth& head = truth.head();
  HeadOptions options;
  HeadPhysicsOptions& p = options.physics;
  if (head.has_field_mm()) p.field_mm = head.field_mm();
  p.half_angle_rad = head.half_angle_deg() * std::numbers::pi / 180;
  p.lens_ratio = head.lens_ratio();
  if (head.has_servo_lag_s()) p.servo_lag_s = head.servo_lag_s();
  if (head.has_encoder_count_um()) p.encoder_count_mm = head.encoder_count_um() / 1e3;
  p.encoder_jitter_mm = head.encoder_jitter_um() / 1e3;
  p.web_mm_s = head.web_mm_s();
  p.web_wave_ratio = head.web_wave_ratio();
  if (head.has_web_wave_s()) p.web_wave_s = head.web_wave_s();
  p.edge_wave_mm = head.edge_wave_mm();
  if (head.has_edge_wave_length_mm()) p.edge_wave_length_mm = head.edge_wave_length_mm();
  p.edge_sensor_mm = head.edge_sensor_mm();
  if (head.has_eye_mm()) p.eye_mm = head.eye_mm();
  p.print.pitch_mm = head.print_pitch_mm();
  p.print.stretch_ratio = head.print_stretch_ratio();
  p.print.ripple_ratio = head.print_ripple_ratio();
  if (head.has_print_ripple_mm()) p.print.ripple_mm = head.print_ripple_mm();
  p.print.missing.assign(head.print_missing().begin(), head.print_missing().end());
  p.print.false_mm.assign(head.print_false_mm().begin(), head.print_false_mm().end());
  p.seed = truth.seed();
  if (head.has_laser_w()) options.laser_w = head.laser_w();
  if (head.has_serial_number()) options.serial_number = head.serial_number();
  if (head.has_queue_ticks()) options.queue_ticks = head.queue_ticks();
  return options;
}

Status HeadCommands::Plug() {
  line_.reset();
  line_ = INTAGLIO_TRY(OpenMachineLine(device_, "scan head's line"));
  device_ = line_->device();
  machine_.Plug(line_->MachineEnd());
  return {};
}

void HeadCommands::TakeHangUp() {
  if (line_ && line_->HostHasGone()) machine_.Plug(line_->MachineEnd());
}

std::string HeadCommands::Do(const std::string& command) {
  HeadController& head = machine_.controller();
  if (command == "key on" || command == "key off") {
    head.SetKey(command == "key on");
  } else if (command == "door close" || command == "door open") {
    head.SetDoor(command == "door close");
  } else if (command == "estop press" || command == "estop release") {
    head.SetStopButton(command == "estop press");
  } else if (command == "unplug") {
    machine_.Plug(nullptr);
    line_.reset();
  } else if (command == "plug") {
    if (const auto plugged = Plug(); !plugged) return "error " + plugged.error().message;
  } else if (command == "status") {
    return "ok " + machine_.StatusLine();
  } else if (command == "quit") {
    quit_ = true;
  } else {
    return "error unknown command '" + command + "'; see docs/protocols.md";
  }
  return "ok";
}

int ServeHead(const HeadProgramOptions& options, const volatile sig_atomic_t& stop) {
  if (!options.head.lockstep) (void)link::AskForRealTime();
  auto made = HeadMachine::Make(options.head, options.record, link::MonotonicClock());
  if (!made) throw std::runtime_error(made.error().message);
  HeadMachine& machine = **made;
  HeadCommands commands(machine, options.line);
  Check(commands.Plug());
  std::optional<Panel> panel;
  if (!options.panel.empty()) {
    auto opened = Panel::Open(options.panel);
    if (!opened) throw std::runtime_error(opened.error().message);
    panel.emplace(std::move(*opened));
  }
  std::cout << "ready head=" << commands.device() << std::endl;
  while (stop == 0 && !commands.quit()) {
    commands.TakeHangUp();
    const auto idle = machine.Turn();
    if (panel)
      panel->Poll([&](const std::string& command) { return commands.Do(command); });
    if (idle.count() > 0) WaitForHead(commands, panel ? &*panel : nullptr, idle);
  }
  machine.controller().LoseHost();
  Check(machine.Flush());
  std::cout << "ends with " << machine.burnt_ticks() << " burnt ticks in the material"
            << std::endl;
  return 0;
}

}  // namespace intaglio::virtual_engraver
