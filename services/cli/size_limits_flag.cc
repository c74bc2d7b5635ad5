#include "services/cli/size_limits_flag.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <cstdlib>

#include "proto/read_limits.h"

namespace intaglio::cli {

void AddSizeLimitsFlag(CLI::App& command, double& factor) {
  command
      .add_option(
          "--size-limits", factor,
          "factor on the largest files, pictures, meshes and clouds that are read "
          "(docs/jobs.md), default 1")
      ->envname(kSizeLimitsVariable)
      ->check(CLI::Range(kLeastSizeLimits, kGreatestSizeLimits));
}

void HandOnSizeLimits(double factor) {
  setenv(kSizeLimitsVariable, fmt::format("{}", factor).c_str(), 1);
}

}  // namespace intaglio::cli
