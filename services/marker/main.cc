#include <iostream>
#include <string>

#include "services/drivers/mark_drivers.h"
#include "services/job/files/job_file.h"
#include "services/marker/marker.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/cell_loop.h"

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
  if (!options.device.empty()) machine->mutable_mark_line()->set_device(options.device);
  auto driver = drivers::MakeMarkDriver(*machine);
  if (!driver) {
    std::cerr << options.machine_file << ": " << driver.error().message << "\n";
    return 2;
  }
  host::OnlyInstance only(host, intaglio_ROLE_SYNCHRONIZER);
  if (only.AwaitTurn()) return only.EndAsSecond("marker");
  marker::Marker cell(host, *machine, options.machine_file, std::move(*driver));
  return host::RunCellService(host, "marker", cell);
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
