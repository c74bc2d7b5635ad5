#include <iostream>

#include "services/job/job_file.h"
#include "services/motion_bridge/bridge.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/only_instance.h"
#include "services/platform/host/process/poll_loop.h"

namespace {

using namespace intaglio;

struct Options {
  std::string machine_file;
  std::string device;
};

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
  host::OnlyInstance only(host, intaglio_ROLE_MOTION_BRIDGE);
  if (only.AwaitTurn()) return only.EndAsSecond("motion bridge");
  motion_bridge::Bridge bridge(host, machine->name(), machine->position_tolerance_um(),
                               std::move(*driver));
  host::PollLoop loop(host.bus());
  loop.Attach(bridge.batches());
  loop.Attach(bridge.stops());
  while (!host.stopping()) {
    bridge.Turn(std::chrono::steady_clock::now().time_since_epoch());
    if (bridge.state().taken_over) return host::EndTakenOver(host, "motion bridge");
    host.SetHealth(bridge.state().link_up ? intaglio_HEALTH_READY : intaglio_HEALTH_FAULT,
                   {}, bridge.message());
    host.KeepAlive();
    loop.Wait(std::array{bridge.fd()}, std::chrono::milliseconds(10));
  }
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
