#include "services/cli/status/watched_shop.h"

#include "services/cli/terminal/interrupt.h"
#include "services/platform/host/process/patience.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Samples that are written once a second: of disks and of interlocks.
constexpr auto kCompleteTime = 2s;

}  // namespace

std::unique_ptr<WatchedShop> WatchShop(const bus::BusOptions& options) {
  auto watched = std::make_unique<WatchedShop>(options);
  const auto discovery = watched->bus.discovery_time();
  const auto give_up = Clock::now() + discovery;
  for (host::Patience patience(discovery + kCompleteTime);
       Interrupts() == 0 && !watched->shop.IsComplete() && !patience.IsUp();) {
    // A job service that is there has been discovered by then.
    if (!options.meets_cells && Clock::now() > give_up && !watched->shop.IsServed())
      break;
    watched->shop.Poll(kShopPollPeriod);
  }
  return watched;
}

}  // namespace intaglio::cli
