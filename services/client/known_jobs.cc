#include "services/client/known_jobs.h"

#include <algorithm>

namespace intaglio::client {

bool PollUntilJobsAreKnown(JobClient& client, std::chrono::milliseconds quiet,
                           std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  std::size_t known_count = 0;
  auto since = Clock::now();
  const auto are_known = [&] {
    const auto now = Clock::now();
    const auto services = client.services();
    const bool served = std::ranges::any_of(services, [](const ServiceView& service) {
      return service.role == intaglio_ROLE_JOB_SERVICE;
    });
    if (!served || client.jobs().size() != known_count) {
      known_count = client.jobs().size();
      since = now;
      return false;
    }
    return now - since >= quiet;
  };
  return client.PollUntil(are_known, timeout);
}

}  // namespace intaglio::client
