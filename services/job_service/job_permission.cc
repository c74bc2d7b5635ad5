#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/result.h"
#include "services/job_service/job_queue.h"

// The part of the queue that has to do with the operator: arm, pause, resume, cancel, and
// the permission that follows from them.
//
// After a fault the synchronizer counts a newer grant only; they are numbered. A
// withdrawal stands for kHold at least, longer than the permission's lease, and what the
// synchronizer says of a fault within kHold after a new grant was still about the old
// one.

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kHold = 300ms;

}  // namespace

bool JobQueue::Take(const CommandView& command, Nanoseconds now) {
  JobRecord* job = FindOpen(command.job_uid);
  if (job == nullptr || command.epoch != job->epoch ||
      command.number <= job->last_command) {
    return false;
  }
  job->last_command = command.number;
  // A word of the grant that it came with: the next command is another one.
  job->fire_uncertain = false;
  switch (command.kind) {
    case intaglio_COMMAND_ARM:
    case intaglio_COMMAND_RESUME:
      Arm(*job, command, now);
      break;
    case intaglio_COMMAND_PAUSE:
      Pause(*job, command, now);
      break;
    case intaglio_COMMAND_CANCEL:
      EndJob(*job, intaglio_JOB_CANCELLED, "cancelled by " + command.operator_name, now);
      break;
  }
  return true;
}

bool JobQueue::Take(const SpeedView& speed) {
  JobRecord* job = FindOpen(speed.job_uid);
  if (job == nullptr || speed.epoch != job->epoch || speed.number <= job->last_speed ||
      speed.speed_percent < kLeastSpeedPercent || speed.speed_percent > 100) {
    return false;
  }
  job->last_speed = speed.number;
  job->speed_percent = speed.speed_percent;
  Tell(*job, job->state, job->message);
  return true;
}

void JobQueue::Arm(JobRecord& job, const CommandView& command, Nanoseconds now) {
  const bool paused = job.state == intaglio_JOB_PAUSED;
  // Its block is not in the machine: another job's is, or will be. Armed now, it would be
  // fired into that one as soon as that one is finished.
  if (IsBehindAnother(job)) return Change(job, job.state, job.message);
  if (stopped_cells_.contains(job.cell)) {
    return Change(job, job.state,
                  fmt::format("the emergency stop of {0} is pressed: see to the machine, "
                              "reset it (intaglio stop {0} --reset), then resume",
                              job.cell));
  }
  job.operator_name = command.operator_name;
  job.first_point = std::max(job.first_point, command.from_point);
  job.fire_uncertain = command.fire_uncertain && command.kind == intaglio_COMMAND_RESUME;
  job.losses = 0;
  job.armed = true;
  job.arm_loss.clear();
  job.armed_at = std::max(now, job.withdrawn_at + kHold);
  Change(job, job.state,
         paused ? fmt::format("resumed by {}{}; waits for the machine",
                              command.operator_name,
                              job.fire_uncertain ? ", uncertain points are fired" : "")
                : job.message);
}

void JobQueue::Pause(JobRecord& job, const CommandView& command, Nanoseconds now) {
  Disarm(job, now);
  const bool engraving = job.state == intaglio_JOB_ENGRAVING;
  const bool active = engraving || job.state == intaglio_JOB_PAUSED;
  Change(job, engraving ? intaglio_JOB_PAUSED : job.state,
         active ? fmt::format("paused by {}; resume it to go on", command.operator_name)
                : job.message);
}

void JobQueue::SetStop(const std::string& cell, bool pressed, Nanoseconds now) {
  if (!pressed) {
    stopped_cells_.erase(cell);
    return;
  }
  if (!stopped_cells_.insert(cell).second) return;
  for (auto& [uid, job] : jobs_) {
    if (job.ended() || job.cell != cell || !job.armed) continue;
    Disarm(job, now);
    Change(job, job.state, "the emergency stop of " + cell + " was pressed");
  }
}

void JobQueue::Disarm(JobRecord& job, Nanoseconds now) {
  if (!job.armed) return;
  job.armed = false;
  job.withdrawn_at = now;
}

void JobQueue::EngravePaused(JobRecord& job, const TaskView& task, Nanoseconds now) {
  const bool fault = !task.error_code.empty();
  const bool outdated = fault && job.armed && now < job.armed_at + kHold;
  if (outdated) return Tell(job, job.state, job.message);
  if (fault && job.armed) {
    Disarm(job, now);
    if (task.error_code == ErrorCodeName(ErrorCode::kLinkLost)) GoOn(job, now);
    return Change(job, intaglio_JOB_PAUSED, task.message);  // a restart knows of it
  }
  // Who is paused by an operator or a fault keeps that reason.
  const bool keep = !fault && !job.armed && job.state == intaglio_JOB_PAUSED;
  Tell(job, intaglio_JOB_PAUSED, keep ? job.message : task.message);
}

void JobQueue::SpentBeforehand(JobRecord& job, const TaskView& task, Nanoseconds now) {
  if (!job.armed || task.error_code.empty() || now < job.armed_at + kHold) return;
  Disarm(job, now);
  job.arm_loss = task.message;
  Change(job, job.state, task.message);
}

std::vector<PermissionView> JobQueue::Permissions(Nanoseconds now) {
  std::vector<PermissionView> permissions;
  for (auto& [uid, job] : jobs_) {
    if (!job.active()) continue;
    const std::string& synchronizer = job.stage(intaglio_STAGE_ENGRAVE).worker;
    const bool ready = job.state == intaglio_JOB_WAITING_FOR_ARM ||
                       job.state == intaglio_JOB_ENGRAVING ||
                       job.state == intaglio_JOB_PAUSED;
    const bool granted =
        ready && job.armed && now >= job.armed_at && !stopped_cells_.contains(job.cell) &&
        workers_.IsAssigned(synchronizer, job.TaskOf(intaglio_STAGE_ENGRAVE));
    if (granted && !job.ever_granted) {
      job.ever_granted = true;
      Change(job, job.state, job.message);
    }
    // Every arm is a command, and commands are numbered and kept over a restart; the arm
    // of a submission comes before them.
    permissions.push_back({job.cell, uid, job.epoch, granted, job.operator_name,
                           job.speed_percent, job.last_command + 1, job.renewal,
                           job.first_point, job.fire_uncertain});
  }
  return permissions;
}

}  // namespace intaglio::job_service
