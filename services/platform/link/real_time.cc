#include "services/platform/link/real_time.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace intaglio::link {
namespace {
// Above everything of the usual class, below what drives the hardware.
constexpr int kPriority = 10;
}  // namespace

std::string AskForRealTime() {
  std::string refused;
  const sched_param priority{kPriority};
  if (sched_setscheduler(0, SCHED_RR, &priority) != 0) {
    refused = "real-time scheduling (grant CAP_SYS_NICE or an rtprio limit)";
  }
  // With a limit, a locked process would run out of memory instead of being late.
  rlimit limit{};
  const bool unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 &&
                                            limit.rlim_cur == RLIM_INFINITY);
  if (!unlimited || mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) != 0) {
    refused += std::string(refused.empty() ? "" : ", ") +
               "locked memory (set the memlock limit to unlimited)";
  }
  return refused;
}

}  // namespace intaglio::link
