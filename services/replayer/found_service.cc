#include "services/replayer/found_service.h"

#include <chrono>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::replayer {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kStart = 30s;
constexpr auto kSearchTurn = 5ms;

}  // namespace

Result<FoundService> AwaitService(bus::Reader<intaglio_ServiceHealth>& health,
                                  bus::WaitSet& wait, intaglio_ServiceRole role,
                                  const KeepOn& keep_on) {
  const auto end = Clock::now() + kStart;
  FoundService found;
  while (found.instance.empty()) {
    INTAGLIO_TRY(keep_on());
    if (Clock::now() > end)
      return Fail(ErrorCode::kTimedOut, "the service does not become ready");
    health.Take([&](const intaglio_ServiceHealth& sample) {
      if (sample.role != role || sample.state != intaglio_HEALTH_READY) return;
      found = {std::string(bus::View(sample.instance)),
               std::string(bus::View(sample.version))};
    });
    (void)wait.Wait(kSearchTurn);
  }
  return found;
}

}  // namespace intaglio::replayer
