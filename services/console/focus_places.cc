#include "services/console/focus_places.h"

#include <utility>

#include "services/client/proof/evidence/proof_evidence.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::console {
namespace {

/// The machine is the job's; of a job that waits it may be another one's.
bool IsAtWork(const client::JobView& job) {
  return job.makes == "points" &&
         (job.state == intaglio_JOB_ENGRAVING || job.state == intaglio_JOB_PAUSED);
}

}  // namespace

void FocusPlaces::Add(const std::map<std::string, client::JobView>& jobs,
                      ConsoleState& state) {
  {
    const std::lock_guard lock(known_->mutex);
    std::erase_if(known_->axes, [&](const auto& known) {
      const auto job = jobs.find(known.first);
      return job == jobs.end() || job->second.ended();
    });
  }
  for (StagePosition& stage : *state.mutable_stages()) {
    for (const auto& [uid, job] : jobs) {
      if (!IsAtWork(job) || job.cell != stage.cell()) continue;
      stage.set_job(uid);
      const auto axes = AxesOf(uid, job.result_directory);
      if (!axes || !*axes) continue;
      const Vec3 focus_mm = (*axes)->ToGlass({stage.x_mm(), stage.y_mm(), stage.z_mm()});
      if (!focus_mm.allFinite()) continue;
      stage.mutable_focus_mm()->set_x(focus_mm.x());
      stage.mutable_focus_mm()->set_y(focus_mm.y());
      stage.mutable_focus_mm()->set_z(focus_mm.z());
    }
  }
}

std::shared_ptr<const FocusPlaces::Axes> FocusPlaces::AxesOf(
    const std::string& uid, const std::filesystem::path& folder) {
  {
    const std::lock_guard lock(known_->mutex);
    const auto [known, is_new] = known_->axes.try_emplace(uid, nullptr);
    if (!is_new) return known->second;
  }
  const bool asked = files_.Ask([known = known_, uid, folder] {
    const auto job = client::ReadFrozenJob(folder / "job.json");
    auto axes = std::make_shared<const Axes>(job ? AxesFromGlassOfAny(*job) : Axes());
    const std::lock_guard lock(known->mutex);
    // A job that has ended meanwhile is forgotten.
    if (const auto at = known->axes.find(uid); at != known->axes.end())
      at->second = std::move(axes);
  });
  if (!asked) {
    const std::lock_guard lock(known_->mutex);
    known_->axes.erase(uid);
  }
  return nullptr;
}

}  // namespace intaglio::console
