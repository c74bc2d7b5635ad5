#include <chrono>
#include <iostream>
#include <string>

#include "services/job/job_file.h"
#include "services/marker/marker.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/only_instance.h"
#include "services/platform/host/process/poll_loop.h"

namespace {

using namespace intaglio;
using namespace std::chrono_literals;

struct Options {
  std::string machine_file;
  std::string device;
};

// A job that is armed before the controller answers has to be armed again, because key
// and door were not watched. So the first jobs wait a moment for it.
constexpr auto kLineTime = 2s;

std::chrono::nanoseconds Now() {
  return std::chrono::steady_clock::now().time_since_epoch();
}

int Serve(host::ServiceHost& host, const Options& options) {
  auto machine = ReadMachineFile(options.machine_file);
  if (!machine) {
    std::cerr << machine.error().message << "\n";
    return 2;
  }
  if (!options.device.empty()) machine->mutable_mark_line()->set_device(options.device);
  auto driver = drivers::MakeMarkDriver(*machine);
  if (!driver) {
    std::cerr << options.machine_file << ": " << driver.error().message << "\n";
    return 2;
  }
  host::OnlyInstance only(host, intaglio_ROLE_SYNCHRONIZER);
  if (only.AwaitTurn()) return only.EndAsSecond("marker");
  marker::Marker cell(host, *machine, std::move(*driver));
  host::PollLoop loop(host.bus());
  cell.AttachTo(loop);
  const auto ready_at = Now() + kLineTime;
  bool ready = false;
  const auto turn = [&] {
    cell.Turn(Now());
    if (!ready && (cell.watches() || Now() >= ready_at)) {
      ready = true;
      host.SetHealth(intaglio_HEALTH_READY);
    }
    host.KeepAlive();
    loop.Wait(std::array{cell.line_fd(), cell.journal_fd()}, 5ms);
  };
  while (!host.stopping() && !cell.taken_over()) turn();
  if (cell.taken_over()) return host::EndTakenOver(host, "marker");
  cell.Stop();
  for (const auto end = Now() + 3s; !cell.stopped() && !cell.taken_over() && Now() < end;)
    turn();
  for (int i = 0; i < 2; ++i) turn();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const host::ServiceDescription description{
      intaglio_ROLE_SYNCHRONIZER, "marker",
      "makes the marks of jobs on one machine that marks or cuts",
      [&options](command_line::Command app) {
        app.AddOption("--machine", options.machine_file, "machine profile (.textproto)")
            .Require();
        app.AddOption("--device", options.device,
                      "device instead of the profile's mark_line.device");
      }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Serve(host, options);
  });
}
