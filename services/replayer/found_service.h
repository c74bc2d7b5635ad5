#pragma once

// The one service that a recording is compared with.

#include <string>

#include "services/platform/bus/bus.h"
#include "services/replayer/rehearsal.h"

namespace intaglio::replayer {

/// Under which a replay acts on the bus.
inline constexpr char kOwnName[] = "intaglio-replay";

struct FoundService {
  std::string instance, version;
};
/// Waits until it is ready. kTimedOut after 30 s; other errors are those of `keep_on`.
Result<FoundService> AwaitService(bus::Reader<intaglio_ServiceHealth>& health,
                                  bus::WaitSet& wait, intaglio_ServiceRole role,
                                  const KeepOn& keep_on);

}  // namespace intaglio::replayer
