#include "services/cli/status/command_effect.h"

#include <fmt/format.h>

#include <iostream>

#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/job_need.h"
#include "services/client/shop/controller_wait.h"
#include "services/history/job_names.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kMachineTime = 2s;
// A machine refuses a run, as without a known place, when it is at work already.
constexpr auto kRefusesWithin = 500ms;

/// Where a command leads when nothing is in its way.
bool Reached(const client::JobView& job, intaglio_JobCommandKind kind) {
  switch (kind) {
    case intaglio_COMMAND_PAUSE:
      return !job.armed && job.state != intaglio_JOB_ENGRAVING;
    case intaglio_COMMAND_CANCEL:
      return job.ended();
    case intaglio_COMMAND_ARM:
    case intaglio_COMMAND_RESUME:
      return job.ended() || (job.armed && job.state != intaglio_JOB_PAUSED &&
                             job.state != intaglio_JOB_WAITING_FOR_ARM);
    case intaglio_COMMAND_SPEED:
    case intaglio_COMMAND_MOUNT:
    case intaglio_COMMAND_MOVE:
    case intaglio_COMMAND_ADMIT:
      break;
  }
  return true;
}

}  // namespace

void WaitForController(bus::Bus& bus, client::JobClient& client,
                       const std::string& cell) {
  client::AwaitController(bus, client, cell, [&cell] {
    std::cerr << fmt::format(
        "{}: the laser controller does not answer, so that key and door are not known; "
        "it is waited for up to {} s\n",
        cell, client::kControllerAnswersWithin.count());
  });
}

int AwaitEffect(client::JobClient& client, const client::JobView& job,
                intaglio_JobCommandKind kind, std::ostream& out) {
  const bool arms = kind == intaglio_COMMAND_ARM || kind == intaglio_COMMAND_RESUME;
  const auto lost = [&] {
    const client::JobView& now = client.jobs().at(job.uid);
    return arms && !now.ended() && !now.armed && now.disarm_count > job.disarm_count;
  };
  client.PollUntil([&] { return lost() || Reached(client.jobs().at(job.uid), kind); },
                   kMachineTime);
  if (arms) client.PollUntil(lost, kRefusesWithin);
  const client::JobView& now = client.jobs().at(job.uid);
  if (!lost()) {
    out << client::StateAndNextOf(now) << "\n";
    return client::kExitGood;
  }
  const char* reason = history::PauseReasonName(now.pause_reason);
  return Complain(
      {ErrorCode::kRefused,
       fmt::format("job {} was armed and is disarmed again{}{}: {}", now.number,
                   *reason == '\0' ? "" : ", ", reason, now.disarm_reason),
       reason},
      client::kExitMachine);
}

}  // namespace intaglio::cli
