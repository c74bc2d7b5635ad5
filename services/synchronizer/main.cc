#include <iostream>

#include "engrave/core/try.h"
#include "services/drivers/laser_drivers.h"
#include "services/job/files/job_file.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/cell_loop.h"
#include "services/synchronizer/synchronizer.h"

namespace {

using namespace intaglio;

struct Options {
  std::string machine_file;
  std::string device;
  std::vector<double> block_mm;
  std::string lens;
  double refractive_index = 0;
};

Result<MountedParts> MountedOf(const Options& options, const MachineSpec& machine) {
  MountedParts mounted;
  if (!options.block_mm.empty())
    mounted.block_mm = Eigen::Map<const Vec3>(options.block_mm.data());
  if (options.refractive_index > 0) mounted.refractive_index = options.refractive_index;
  auto lens = INTAGLIO_TRY(MountedLens(options.lens, machine));
  mounted.lens = lens;
  return mounted;
}

int Serve(host::ServiceHost& host, const Options& options) {
  auto machine = ReadMachineFile(options.machine_file);
  if (!machine) {
    std::cerr << machine.error().message << "\n";
    return 2;
  }
  if (!options.device.empty()) machine->mutable_laser_line()->set_device(options.device);
  const auto mounted = MountedOf(options, *machine);
  if (!mounted) {
    std::cerr << "--lens: " << mounted.error().message << "\n";
    return 2;
  }
  auto laser = drivers::MakeLaserDriver(*machine);
  if (!laser) {
    std::cerr << options.machine_file << ": " << laser.error().message << "\n";
    return 2;
  }
  host::OnlyInstance only(host, intaglio_ROLE_SYNCHRONIZER);
  if (only.AwaitTurn()) return only.EndAsSecond("synchronizer");
  synchronizer::Synchronizer cell(host, *machine, options.machine_file, *mounted,
                                  std::move(*laser));
  return host::RunCellService(host, "synchronizer", cell);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const host::ServiceDescription description{
      intaglio_ROLE_SYNCHRONIZER, "synchronizer",
      "fires the laser of one machine at the ticks at which the stage is in place",
      [&options](command_line::Command app) {
        app.AddOption("--machine", options.machine_file, "machine profile (.textproto)")
            .Require();
        app.AddOption("--device", options.device,
                      "device instead of the profile's laser_line.device");
        app.AddOption("--block", options.block_mm,
                      "size of the block in the machine, x,y,z in mm: a job for another "
                      "one is not fired; default: not known, not compared")
            .SplitAt(',')
            .TakeValues(3)
            .Positive();
        app.AddOption("--lens", options.lens,
                      "the mounted lens, by its name in the profile, or as "
                      "FOCAL_LENGTH,NA: a job for another one is not fired; default: the "
                      "profile's, if it has just one, else not known, not compared");
        app.AddOption("--block-index", options.refractive_index,
                      "refractive index of the block in the machine at the laser's "
                      "wavelength: a job for another glass is not fired; default: not "
                      "known, not compared")
            .Within(1.0, 4.0);
      }};
  return host::RunService(description, argc, argv, [&options](host::ServiceHost& host) {
    return Serve(host, options);
  });
}
