#include <array>
#include <iostream>
#include <optional>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/motion_drivers.h"
#include "services/job/files/job_file.h"
#include "services/motion_bridge/bridge.h"
#include "services/motion_bridge/laser_socket.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/only_instance.h"
#include "services/platform/host/process/poll_loop.h"

namespace {

using namespace intaglio;

struct Options {
  std::string machine_file;
  std::string device;
};

std::chrono::nanoseconds Now() {
  return std::chrono::steady_clock::now().time_since_epoch();
}

bool SwitchesLaser(const MachineSpec& machine) {
  return machine.laser_line().protocol() == drivers::kMotionOutput;
}

Status CheckLaser(const MachineSpec& machine) {
  return SwitchesLaser(machine) ? drivers::CheckMotionOutput(machine) : Status();
}

void ReportHealth(host::ServiceHost& host, const motion_bridge::Bridge& bridge,
                  const std::optional<motion_bridge::LaserSocket>& laser) {
  const std::string& socket = laser ? laser->message() : std::string();
  const bool ready = bridge.state().link_up && socket.empty();
  host.SetHealth(ready ? intaglio_HEALTH_READY : intaglio_HEALTH_FAULT, {},
                 socket.empty() ? bridge.message() : socket);
}

// The controller's own watchdog would close it, too; not every family has one.
void CloseLaser(motion_bridge::Bridge& bridge, motion_bridge::LaserSocket& laser,
                host::PollLoop& loop) {
  laser.Close();
  const auto end = Now() + std::chrono::milliseconds(500);
  while (!laser.closed() && bridge.state().link_up && Now() < end) {
    bridge.Turn(Now());
    laser.Turn();
    loop.Wait(std::array{bridge.fd()}, std::chrono::milliseconds(5));
  }
}

int Serve(host::ServiceHost& host, const Options& options) {
  auto machine = ReadMachineFile(options.machine_file);
  if (!machine) {
    std::cerr << machine.error().message << "\n";
    return 2;
  }
  if (!options.device.empty()) machine->mutable_motion_line()->set_device(options.device);
  auto driver = drivers::MakeMotionDriver(*machine);
  if (!driver) {
    std::cerr << options.machine_file << ": " << driver.error().message << "\n";
    return 2;
  }
  if (Status whole = CheckLaser(*machine); !whole) {
    std::cerr << options.machine_file << ": " << whole.error().message << "\n";
    return 2;
  }
  host::OnlyInstance only(host, intaglio_ROLE_MOTION_BRIDGE);
  if (only.AwaitTurn()) return only.EndAsSecond("motion bridge");
  motion_bridge::Bridge bridge(host, *machine, options.machine_file, std::move(*driver));
  std::optional<motion_bridge::LaserSocket> laser;
  if (SwitchesLaser(*machine))
    laser.emplace(*bridge.laser(), drivers::LaserDeviceOf(*machine));
  host::PollLoop loop(host.bus());
  loop.Attach(bridge.batches());
  loop.Attach(bridge.stops());
  loop.Attach(bridge.manual().commands());
  loop.Attach(bridge.manual().cell_moves());
  loop.Attach(bridge.manual().interlocks());
  while (!host.stopping()) {
    bridge.Turn(Now());
    if (bridge.state().taken_over) return host::EndTakenOver(host, "motion bridge");
    if (laser) laser->Turn();
    ReportHealth(host, bridge, laser);
    host.KeepAlive();
    const auto [host_fd, listener_fd] = laser ? laser->descriptors() : std::array{-1, -1};
    loop.Wait(std::array{bridge.fd(), host_fd, listener_fd},
              laser ? drivers::MotionDriver::kRestingWait : bridge.wait());
  }
  if (laser) CloseLaser(bridge, *laser, loop);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const host::ServiceDescription description{
      intaglio_ROLE_MOTION_BRIDGE, "motion-bridge",
      "sends motion to one machine's controller and publishes its position",
      [&options](command_line::Command app) {
        app.AddOption("--machine", options.machine_file, "machine profile (.textproto)")
            .Require();
        app.AddOption("--device", options.device,
                      "device instead of the profile's motion_line.device");
      }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Serve(host, options);
  });
}
