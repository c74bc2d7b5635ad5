#include <fmt/format.h>

#include <algorithm>

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

/// Of a machine that waits: it was halted by a fault, not by a permission that ended.
bool SpendsTheArm(intaglio_PauseReason reason) {
  return reason != intaglio_PAUSE_NONE && reason != intaglio_PAUSE_NOT_ARMED;
}

std::string IdOf(const CommandView& command) {
  return fmt::format("{}/{}", command.sender, command.number);
}

}  // namespace

CommandAnswer JobQueue::Take(const CommandView& command, Nanoseconds now) {
  const auto found = jobs_.find(command.job_uid);
  if (found == jobs_.end()) {
    return {intaglio_ANSWER_UNKNOWN_JOB,
            fmt::format("there is no job {}: see intaglio list", command.job_uid)};
  }
  JobRecord& job = found->second;
  const std::string id = IdOf(command);
  if (id == job.last_command_id) return {};
  CommandAnswer answer = Check(job, command);
  if (!answer.taken()) return answer;
  job.last_command_id = id;
  if (command.kind == intaglio_COMMAND_SPEED) {
    job.speed_percent = command.speed_percent;
    Change(job, job.state, job.message);
    return answer;
  }
  ++job.last_command;
  // It belongs to the grant that it came with: the next command makes another one.
  job.fire_uncertain = false;
  switch (command.kind) {
    case intaglio_COMMAND_PAUSE:
      Pause(job, command, now);
      break;
    case intaglio_COMMAND_CANCEL:
      EndJob(job, intaglio_JOB_CANCELLED, "cancelled by " + command.operator_name, now);
      break;
    case intaglio_COMMAND_ARM:
    case intaglio_COMMAND_RESUME:
      Arm(job, command, now);
      break;
    case intaglio_COMMAND_SPEED:
      break;  // above
  }
  return answer;
}

CommandAnswer JobQueue::Check(const JobRecord& job, const CommandView& command) const {
  if (command.epoch != job.epoch) {
    return {intaglio_ANSWER_WRONG_EPOCH,
            fmt::format("the command is for job {} of another run of the job service: "
                        "see intaglio list",
                        job.number)};
  }
  if (job.ended()) {
    return {intaglio_ANSWER_ENDED_JOB,
            fmt::format("job {} has ended: {}", job.number, job.message)};
  }
  switch (command.kind) {
    case intaglio_COMMAND_ARM:
    case intaglio_COMMAND_RESUME:
      return CheckArm(job, command);
    case intaglio_COMMAND_SPEED:
      if (command.speed_percent >= kMinSpeedPercent && command.speed_percent <= 100) {
        return {};
      }
      return {intaglio_ANSWER_OUT_OF_RANGE,
              fmt::format("speed_percent {} of job {} is outside {}..100",
                          command.speed_percent, job.number, kMinSpeedPercent)};
    case intaglio_COMMAND_PAUSE:
    case intaglio_COMMAND_CANCEL:
      return {};
  }
  return {intaglio_ANSWER_OUT_OF_RANGE,
          fmt::format("kind {} of a command for job {} is unknown: use the version of "
                      "intaglio that the job service has",
                      static_cast<int>(command.kind), job.number)};
}

CommandAnswer JobQueue::CheckArm(const JobRecord& job, const CommandView& command) const {
  // The block in its machine is another job's, or was put there for another one.
  if (!job.active()) {
    return {
        intaglio_ANSWER_NOT_YET,
        fmt::format("job {} cannot be armed yet: {}; arm it (intaglio arm {}) when it "
                    "is discretizing, with its block in the machine",
                    job.number,
                    job.message.empty() ? "it waits for " + job.cell : job.message,
                    job.number)};
  }
  if (stopped_cells_.contains(job.cell)) {
    return {intaglio_ANSWER_STOP_PRESSED,
            fmt::format("the emergency stop of {0} is pressed: check the machine, reset "
                        "the stop (intaglio stop {0} --reset), then arm job {1} again",
                        job.cell, job.number)};
  }
  if (command.disarm_count != job.disarm_count) {
    return {intaglio_ANSWER_SUPERSEDED,
            fmt::format("job {} was disarmed meanwhile ({}): check the machine and arm "
                        "it again (intaglio arm {})",
                        job.number, job.disarm_reason, job.number)};
  }
  return {};
}

void JobQueue::Arm(JobRecord& job, const CommandView& command, Nanoseconds now) {
  const bool paused = job.state == intaglio_JOB_PAUSED;
  job.operator_name = command.operator_name;
  job.first_point = std::max(job.first_point, command.from_point);
  job.fire_uncertain = command.fire_uncertain && command.kind == intaglio_COMMAND_RESUME;
  job.losses = 0;
  job.armed = true;
  job.arm_loss.clear();
  if (job.absent_since) job.absent_since = now;
  job.armed_at = std::max(now, job.withdrawn_at + kHold);
  Change(job, job.state,
         paused ? fmt::format("resumed by {}{}; waits for the machine",
                              command.operator_name,
                              job.fire_uncertain ? ", uncertain points are fired" : "")
                : job.message);
}

void JobQueue::ChangeToPaused(JobRecord& job, intaglio_PauseReason reason,
                              const std::string& message) {
  job.pause_reason = reason;
  Change(job, intaglio_JOB_PAUSED, message);
}

void JobQueue::Pause(JobRecord& job, const CommandView& command, Nanoseconds now) {
  Disarm(job, "paused by " + command.operator_name, now);
  if (job.state != intaglio_JOB_ENGRAVING && job.state != intaglio_JOB_PAUSED) {
    return Change(job, job.state, job.message);
  }
  ChangeToPaused(job, intaglio_PAUSE_OPERATOR,
                 fmt::format("paused by {}; resume it to go on", command.operator_name));
}

// Also of jobs that are not armed: an ARM may be on its way.
void JobQueue::SetStop(const std::string& cell, bool pressed, Nanoseconds now) {
  if (!pressed) {
    stopped_cells_.erase(cell);
    return;
  }
  if (!stopped_cells_.insert(cell).second) return;
  const std::string reason = "the emergency stop of " + cell + " was pressed";
  for (auto& [uid, job] : jobs_) {
    if (!job.active() || job.cell != cell) continue;
    const bool was_armed = job.armed;
    Disarm(job, reason, now);
    job.fire_uncertain = false;
    if (was_armed && job.state == intaglio_JOB_PAUSED) {
      job.pause_reason = intaglio_PAUSE_EMERGENCY_STOP;
    }
    Change(job, job.state, was_armed ? reason : job.message);
  }
}

void JobQueue::Disarm(JobRecord& job, const std::string& reason, Nanoseconds now) {
  ++job.disarm_count;
  job.disarm_reason = reason;
  if (!job.armed) return;
  job.armed = false;
  job.withdrawn_at = now;
}

void JobQueue::EngravePaused(JobRecord& job, const TaskView& task, Nanoseconds now) {
  const bool fault = SpendsTheArm(task.pause_reason);
  const bool outdated = fault && job.armed && now < job.armed_at + kHold;
  if (outdated) return Tell(job, job.state, job.message);
  if (fault && job.armed) {
    Disarm(job, task.message, now);
    if (task.pause_reason == intaglio_PAUSE_LINE_LOST) GoOn(job, now);
    // Kept, so that a restart knows of it.
    return ChangeToPaused(job, task.pause_reason, task.message);
  }
  // Who is paused by an operator or a fault keeps that reason.
  const bool paused = job.state == intaglio_JOB_PAUSED;
  const bool keep = !fault && !job.armed && paused;
  if (fault || !paused) job.pause_reason = task.pause_reason;
  Tell(job, intaglio_JOB_PAUSED, keep ? job.message : task.message);
}

void JobQueue::SpentBeforehand(JobRecord& job, const TaskView& task, Nanoseconds now) {
  if (!job.armed || !SpendsTheArm(task.pause_reason) || now < job.armed_at + kHold) {
    return;
  }
  Disarm(job, task.message, now);
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
    // Every arm is a command, and commands are counted and kept over a restart. A speed
    // is none of them: it must not bring back a grant that the synchronizer has spent.
    permissions.push_back({job.cell, uid, job.epoch, granted, job.operator_name,
                           job.speed_percent, job.last_command + 1, job.renewal,
                           job.first_point, job.fire_uncertain});
  }
  return permissions;
}

}  // namespace intaglio::job_service
