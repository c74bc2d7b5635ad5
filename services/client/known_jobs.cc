#include "services/client/known_jobs.h"

#include <algorithm>

namespace intaglio::client {

bool PollUntilJobsAreKnown(JobClient& client, std::chrono::milliseconds quiet,
                           std::chrono::milliseconds timeout) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kTurn{10};
  const auto end = Clock::now() + timeout;
  std::size_t known_count = 0;
  auto since = Clock::now();
  for (auto now = since; now < end; client.Poll(kTurn), now = Clock::now()) {
    const auto services = client.services();
    const bool served = std::ranges::any_of(services, [](const ServiceView& service) {
      return service.role == intaglio_ROLE_JOB_SERVICE;
    });
    if (!served || client.jobs().size() != known_count) {
      known_count = client.jobs().size();
      since = now;
    } else if (now - since >= quiet) {
      return true;
    }
  }
  return false;
}

}  // namespace intaglio::client
