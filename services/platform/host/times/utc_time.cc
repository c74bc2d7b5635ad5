#include "services/platform/host/times/utc_time.h"

#include <fmt/chrono.h>

namespace intaglio::host {

std::string UtcText(std::chrono::system_clock::time_point time) {
  using std::chrono::milliseconds;
  const auto whole_s = std::chrono::floor<std::chrono::seconds>(time);
  const auto rest = std::chrono::duration_cast<milliseconds>(time - whole_s);
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(whole_s)),
                     rest.count());
}

}  // namespace intaglio::host
