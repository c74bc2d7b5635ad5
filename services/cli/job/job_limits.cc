#include "services/cli/job/job_limits.h"

#include <utility>

#include "services/job/models/program_limits.h"

namespace intaglio::cli {

ReadLimits LimitsOf(const JobFlags& flags) {
  ReadLimits limits = mesh_reader::LimitsOfProgram(flags.size_limits);
  if (flags.kept_meshes != nullptr)
    limits.read_mesh = flags.kept_meshes->Around(std::move(limits.read_mesh));
  return limits;
}

}  // namespace intaglio::cli
