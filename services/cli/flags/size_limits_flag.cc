#include "services/cli/flags/size_limits_flag.h"

#include <fmt/format.h>

#include <cstdlib>

#include "services/job/models/read_limits.h"

namespace intaglio::cli {

void AddSizeLimitsFlag(command_line::Command command, double& factor) {
  command
      .AddOption("--size-limits", factor,
                 "factor on the size limits of files, pictures, meshes and clouds "
                 "(docs/jobs.md), default 1")
      .FromEnvironment(kSizeLimitsVariable)
      .Within(kMinSizeLimits, kGreatestSizeLimits);
}

void HandOnSizeLimits(double factor) {
  setenv(kSizeLimitsVariable, fmt::format("{}", factor).c_str(), 1);
}

}  // namespace intaglio::cli
