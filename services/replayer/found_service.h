#pragma once

// The one service that a recording is held against.

#include <string>

#include "services/platform/bus/bus.h"
#include "services/replayer/rehearsal.h"

namespace intaglio::replayer {

struct FoundService {
  std::string instance, version;
};
/// Waits until it is ready. kTimedOut after 30 s; others as `keep_on` says.
Result<FoundService> AwaitService(bus::Reader<intaglio_ServiceHealth>& health,
                                  bus::WaitSet& wait, intaglio_ServiceRole role,
                                  const KeepOn& keep_on);

}  // namespace intaglio::replayer
