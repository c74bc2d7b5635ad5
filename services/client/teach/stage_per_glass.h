#pragma once

#include <string>

#include "services/client/teach/test_job.h"
#include "services/job/teach/stage_per_glass.h"

namespace intaglio::client {

/// StagePerGlassRatio by this material base, which is opened at each call.
inline StagePerGlass StagePerGlassOf(const std::string& database) {
  return [database](const MachineSpec& machine, const MachineLens& lens,
                    const std::string& glass) {
    return StagePerGlassRatio(database, machine, lens, glass);
  };
}

}  // namespace intaglio::client
