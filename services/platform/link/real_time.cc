#include "services/platform/link/real_time.h"

#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

namespace intaglio::link {
namespace {

// Above everything of the usual class, below what drives the hardware.
constexpr int kPriority = 10;
// Of the usual class: some ten times the weight of a process that asks for nothing.
constexpr int kNice = -10;

void Add(std::string& list, const std::string& what) {
  list += (list.empty() ? "" : ", ") + what;
}

// With a limit, a locked process would run out of memory instead of being late.
bool LockMemory() {
  rlimit limit{};
  const bool unlimited = geteuid() == 0 || (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 &&
                                            limit.rlim_cur == RLIM_INFINITY);
  return unlimited && mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
}

}  // namespace

RealTimeGrant RaisePriority() {
  RealTimeGrant grant;
  const sched_param priority{kPriority};
  if (sched_setscheduler(0, SCHED_RR, &priority) == 0) {
    Add(grant.granted, "real-time scheduling, priority " + std::to_string(kPriority));
    return grant;
  }
  Add(grant.refused, "real-time scheduling (grant CAP_SYS_NICE or an rtprio limit)");
  if (setpriority(PRIO_PROCESS, 0, kNice) == 0)
    Add(grant.granted, "nice " + std::to_string(kNice));
  return grant;
}

RealTimeGrant AskForRealTime() {
  RealTimeGrant grant = RaisePriority();
  if (LockMemory()) {
    Add(grant.granted, "locked memory");
  } else {
    Add(grant.refused, "locked memory (set the memlock limit to unlimited)");
  }
  return grant;
}

}  // namespace intaglio::link
