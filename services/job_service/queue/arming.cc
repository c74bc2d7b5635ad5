#include "services/job_service/queue/arming.h"

#include <fmt/format.h>

#include "services/job/verdict/warnings.h"

namespace intaglio::job_service {

CommandAnswer Arming::Check(const JobRecord& job, const CommandView& command) const {
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
      if (command.speed_percent >= kMinSpeedPercent &&
          command.speed_percent <= kMaxSpeedPercent) {
        return {};
      }
      return {intaglio_ANSWER_OUT_OF_RANGE,
              fmt::format("speed_percent {} of job {} is outside {}..{}",
                          command.speed_percent, job.number, kMinSpeedPercent,
                          kMaxSpeedPercent)};
    case intaglio_COMMAND_MOVE: {
      const std::string why = book_.WhyNotMoved(job, command.before_job_uid);
      return why.empty() ? CommandAnswer()
                         : CommandAnswer{intaglio_ANSWER_OUT_OF_RANGE, why};
    }
    case intaglio_COMMAND_PAUSE:
    case intaglio_COMMAND_CANCEL:
      return {};
    case intaglio_COMMAND_MOUNT:
    case intaglio_COMMAND_ADMIT:
      break;  // of a machine, of a worker
  }
  return {intaglio_ANSWER_OUT_OF_RANGE,
          fmt::format("kind {} of a command for job {} is unknown: use the same version "
                      "of intaglio as the job service",
                      static_cast<int>(command.kind), job.number)};
}

CommandAnswer Arming::CheckArm(const JobRecord& job, const CommandView& command) const {
  // The block in its machine is another job's, or was put there for another one.
  if (!job.active()) {
    return {
        intaglio_ANSWER_NOT_YET,
        fmt::format("job {} cannot be armed yet: {}; arm it (intaglio arm {}) when it "
                    "is discretizing, with its {} in the machine",
                    job.number,
                    job.message.empty() ? "it waits for " + job.cell : job.message,
                    job.number, job.workpiece())};
  }
  if (IsStopped(job.cell)) {
    return {intaglio_ANSWER_STOP_PRESSED,
            fmt::format("the emergency stop of {0} is pressed: check the machine, reset "
                        "the stop (intaglio stop {0} --reset), then arm job {1} again",
                        job.cell, job.number)};
  }
  if (command.disarm_count != job.arm.disarm_count()) {
    return {intaglio_ANSWER_SUPERSEDED,
            fmt::format("job {} was disarmed meanwhile ({}): check the machine and arm "
                        "it again (intaglio arm {})",
                        job.number, job.arm.disarm_reason(), job.number)};
  }
  if (!job.suspicion.empty()) {
    return {intaglio_ANSWER_NOT_YET,
            fmt::format("job {} cannot be armed yet: {}", job.number, job.suspicion)};
  }
  if (const Warning* warning = job.open_consent(); warning && !command.accept_breakage) {
    return {intaglio_ANSWER_NEEDS_CONSENT,
            fmt::format("job {} cannot be armed without a consent: {}", job.number,
                        ConsentMessage(job, *warning))};
  }
  if (const std::string misfit = mounts_.MisfitOf(job); !misfit.empty()) {
    return {intaglio_ANSWER_NOT_MOUNTED,
            fmt::format("job {} cannot be armed: {}", job.number, misfit)};
  }
  return pieces_.Check(job, command);
}

void Arming::SetMount(const MountRecord& mount, intaglio_ArmBasis basis,
                      Nanoseconds now) {
  const bool is_first = !mounts_.mounts().contains(mount.cell);
  mounts_.Set(mount);
  const std::string what = TextOf(mount.parts);
  EndArms(intaglio_PAUSE_MACHINE_CHANGED, now, [&](const JobRecord& job) {
    if (job.cell != mount.cell) return std::string();
    if (is_first && basis == intaglio_ARM_BY_PROGRAM) return mounts_.MisfitOf(job);
    return fmt::format("{} has reported what is mounted{}", mount.operator_name,
                       what.empty() ? "" : ", " + what);
  });
}

const std::string& Arming::MountMisfitOf(JobRecord& job) const {
  if (job.mount_revision != mounts_.revision()) {
    job.mount_revision = mounts_.revision();
    job.mount_misfit = mounts_.MisfitOf(job);
  }
  return job.mount_misfit;
}

void Arming::TurnPieces() {
  pieces_.Turn([this](const std::string& uid) { return book_.FindOpen(uid) != nullptr; });
  for (JobRecord* job : book_.ActiveInTurn()) {
    const bool awaits = !job->arm.ever_granted() && pieces_.Awaits(*job);
    if (awaits == job->awaits_block) continue;
    job->awaits_block = awaits;
    book_.PublishProgress(*job);
  }
}

std::string Arming::ConsentMessage(const JobRecord& job, const Warning& warning) {
  return fmt::format("{}; to engrave it all the same: intaglio arm {} {}", warning.text,
                     job.number, AcceptOption(warning));
}

void Arming::TakeWarnings(JobRecord& job, const Warnings& warnings, Nanoseconds now) {
  job.warnings = warnings;
  const Warning* warning = job.open_consent();
  if (warning == nullptr) return;
  if (job.arm.armed()) job.arm.Disarm(warning->text, now);
  book_.Change(job, job.state, ConsentMessage(job, *warning));
}

void Arming::Arm(JobRecord& job, const CommandView& command, Nanoseconds now) {
  const bool had_consent = job.open_consent() == nullptr;
  pieces_.NoteArmed(job, command);
  job.arm.Arm(command, now);
  job.arm_loss.clear();
  if (job.state != intaglio_JOB_PAUSED) {
    return book_.Change(job, job.state, had_consent ? job.message : "");
  }
  book_.Change(
      job, job.state,
      fmt::format("resumed by {}{}; waits for the machine", command.operator_name,
                  job.arm.kept().fire_uncertain ? ", uncertain points are fired" : ""));
}

void Arming::Pause(JobRecord& job, const CommandView& command, Nanoseconds now) {
  job.arm.Disarm("paused by " + command.operator_name, now);
  if (job.state != intaglio_JOB_ENGRAVING && job.state != intaglio_JOB_PAUSED) {
    return book_.Change(job, job.state, job.message);
  }
  if (job.makes == "marks" && job.counts.armed > 0) {
    job.at_work =
        "the machine makes the mark in hand to its end: keep away until it rests";
  }
  book_.ChangeToPaused(
      job, intaglio_PAUSE_OPERATOR,
      fmt::format("paused by {}; resume it to continue", command.operator_name));
}

void Arming::SetStop(const std::string& cell, bool pressed, Nanoseconds now) {
  const std::string reason = "the emergency stop of " + cell + " was pressed";
  if (!pressed) {
    if (stopped_cells_.erase(cell) > 0) NoteReset(cell, reason);
    return;
  }
  if (!stopped_cells_.insert(cell).second) return;
  for (JobRecord* job : book_.ActiveInTurn()) {
    if (job->cell != cell) continue;
    const bool was_armed = job->arm.armed();
    job->arm.Disarm(reason, now);
    job->arm.ForbidUncertain();
    if (was_armed && job->state == intaglio_JOB_PAUSED) {
      job->pause_reason = intaglio_PAUSE_EMERGENCY_STOP;
    }
    book_.Change(*job, job->state, was_armed ? reason : job->message);
  }
}

// What was disarmed by the stop still waits for a person.
void Arming::NoteReset(const std::string& cell, const std::string& reason) {
  for (JobRecord* job : book_.ActiveInTurn()) {
    const bool stopped = job->cell == cell && !job->arm.armed() && job->message == reason;
    if (!stopped) continue;
    book_.Change(
        *job, job->state,
        fmt::format("{} and is reset: check the machine, then {} the job", reason,
                    job->state == intaglio_JOB_PAUSED ? "resume" : "arm"));
  }
}

void Arming::Renew(JobRecord& job, Nanoseconds now) {
  if (IsStopped(job.cell)) return;
  job.arm.Renew(job.stage(intaglio_STAGE_ENGRAVE).done_count, job.revision + 1, now);
}

void Arming::TakePaused(JobRecord& job, const TaskView& task, Nanoseconds now) {
  const bool has_path = task.total_count > 0;
  if (!has_path) return SpendBeforePath(job, task, now);
  const bool fault = SpendsTheGrant(task.pause_reason);
  if (fault && job.arm.IsOutdated(now)) return book_.PublishProgress(job);
  if (fault && job.arm.armed()) {
    job.arm.Disarm(task.message, now);
    if (task.pause_reason == intaglio_PAUSE_LINE_LOST) Renew(job, now);
    // Kept, so that a restart knows of it.
    return book_.ChangeToPaused(job, task.pause_reason, task.message);
  }
  // A job that is paused by an operator or a fault keeps that reason.
  const bool paused = job.state == intaglio_JOB_PAUSED;
  const bool keep = !fault && !job.arm.armed() && paused;
  if (fault || !paused) job.pause_reason = task.pause_reason;
  book_.Publish(job, intaglio_JOB_PAUSED, keep ? job.message : task.message);
}

void Arming::SpendBeforePath(JobRecord& job, const TaskView& task, Nanoseconds now) {
  if (!job.arm.armed() || job.arm.IsOutdated(now) || !SpendsTheGrant(task.pause_reason)) {
    return;
  }
  job.arm.Disarm(task.message, now);
  job.arm_loss = task.message;
  // Paused: it was taken up, and its path is being read.
  if (job.state == intaglio_JOB_PAUSED) {
    return book_.ChangeToPaused(job, task.pause_reason, task.message);
  }
  book_.Change(job, job.state, task.message);
}

void Arming::EndArms(intaglio_PauseReason reason, Nanoseconds now, const WhyItEnds& why) {
  for (JobRecord* job : book_.ActiveInTurn()) {
    if (!job->arm.armed()) continue;
    const std::string text = why(*job);
    if (!text.empty()) EndArm(*job, reason, text, now);
  }
}

void Arming::EndArm(JobRecord& job, intaglio_PauseReason reason, const std::string& why,
                    Nanoseconds now) {
  job.arm.Disarm(why, now);
  const std::string message =
      fmt::format("{}: check that the right {} is in the machine, then {} the job", why,
                  job.workpiece(), job.arm.ever_granted() ? "resume" : "arm");
  const bool pauses =
      job.state == intaglio_JOB_ENGRAVING || job.state == intaglio_JOB_PAUSED;
  if (pauses) return book_.ChangeToPaused(job, reason, message);
  book_.Change(job, job.state, message);
}

std::vector<PermissionView> Arming::Permissions(Nanoseconds now) {
  std::vector<PermissionView> permissions;
  for (JobRecord* active : book_.ActiveInTurn()) {
    JobRecord& job = *active;
    const std::string& synchronizer = job.stage(intaglio_STAGE_ENGRAVE).worker;
    const bool granted =
        job.may_be_granted() && job.arm.MayFire(now) && !IsStopped(job.cell) &&
        workers_.IsAssigned(synchronizer, job.TaskOf(intaglio_STAGE_ENGRAVE));
    if (granted && !job.arm.ever_granted()) {
      pieces_.NoteGranted(job);
      job.arm.NoteGranted();
      book_.Change(job, job.state, job.message);
    }
    const KeptArm& arm = job.arm.kept();
    permissions.push_back({job.cell, job.uid, job.epoch, granted, arm.operator_name,
                           job.speed_percent, job.arm.grant(), job.arm.renewal(),
                           arm.first_point, arm.fire_uncertain});
  }
  return permissions;
}

}  // namespace intaglio::job_service
