#include "services/console/plans_ahead.h"

namespace intaglio::console {
namespace {

bool HasMachine(const client::JobView& job) {
  return job.state == intaglio_JOB_WAITING_FOR_ARM ||
         job.state == intaglio_JOB_ENGRAVING || job.state == intaglio_JOB_PAUSED;
}

}  // namespace

void PlansAhead::Follow(const std::map<std::string, client::JobView>& jobs) {
  std::erase_if(asked_, [&](const std::string& uid) { return !jobs.contains(uid); });
  for (const auto& [uid, job] : jobs) {
    if (!HasMachine(job) || job.makes != "points" || asked_.contains(uid)) continue;
    // A page that asks gets the reason where it cannot be read.
    if (files_.AskForPlan(job.result_directory, [](const auto&) {})) asked_.insert(uid);
  }
}

}  // namespace intaglio::console
