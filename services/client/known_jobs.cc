#include "services/client/known_jobs.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/platform/host/process/patience.h"

namespace intaglio::client {
namespace {

constexpr std::chrono::milliseconds kTurn{10};

bool IsServed(const JobClient& client) {
  const auto services = client.services();
  return std::ranges::any_of(services, [](const ServiceView& service) {
    return service.role == intaglio_ROLE_JOB_SERVICE;
  });
}

Error WhyNotKnown(const JobClient& client, double waited_s) {
  const auto counted = client.counted_jobs();
  if (!counted) {
    return {
        ErrorCode::kLinkLost,
        fmt::format("a job service is there, but has not read its queue within {:.0f} "
                    "s: check its log and its disk, and try again",
                    waited_s),
        ""};
  }
  return {ErrorCode::kLinkLost,
          fmt::format("the job service has {}, and {} of them {} come within {:.0f} "
                      "s: check the network and the load of the computer, and try again",
                      Counted(*counted, "job"), client.jobs().size(),
                      HasOrHave(client.jobs().size()), waited_s),
          ""};
}

}  // namespace

bool PollUntilServed(JobClient& client, std::chrono::milliseconds time) {
  for (host::Patience patience(time); !IsServed(client); client.Poll(kTurn)) {
    if (patience.IsUp()) return false;
  }
  return true;
}

namespace {

constexpr std::chrono::seconds kCountComesWithin{1};

/// Until `is_enough` holds or all jobs are known.
Status Await(JobClient& client, const std::function<bool()>& is_enough,
             std::chrono::milliseconds discovery_time,
             std::chrono::milliseconds jobs_within) {
  if (!PollUntilServed(client, discovery_time)) {
    return Fail(ErrorCode::kTimedOut, kNoJobService);
  }
  for (host::Patience patience(jobs_within); !is_enough() && !client.KnowsAllJobs();
       client.Poll(kTurn)) {
    // A queue that was given up stays on the bus; its count may come behind the fault.
    auto fault = client.JobServiceFault();
    if (fault && !client.counted_jobs() && patience.waited() >= kCountComesWithin)
      return tl::unexpected(std::move(*fault));
    if (patience.IsUp())
      return tl::unexpected(WhyNotKnown(client, patience.waited().count()));
  }
  return {};
}

}  // namespace

Status PollUntilJobsAreKnown(JobClient& client, std::chrono::milliseconds discovery_time,
                             std::chrono::milliseconds jobs_within) {
  return Await(
      client, [] { return false; }, discovery_time, jobs_within);
}

Result<JobView> AwaitJob(JobClient& client, const std::string& uid_or_number,
                         std::chrono::milliseconds discovery_time) {
  const auto has_come = [&] { return client.Find(uid_or_number).has_value(); };
  INTAGLIO_TRY(Await(client, has_come, discovery_time, kJobsWithin));
  return client.Find(uid_or_number);
}

}  // namespace intaglio::client
