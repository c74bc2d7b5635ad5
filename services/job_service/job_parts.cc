#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "services/job_service/job_queue.h"
#include "services/platform/host/task_part.h"

// The part of the queue that has to do with the parts of a job's discretizing, which
// several discretizers work on at the same time. A part is made again from the beginning
// when its worker is lost; the others go on, and so do the stages behind, which get the
// same points whoever makes them.
//
// Who is at work gets its next part ahead, so that it does not wait while its points are
// sent, and while what has ended and what is given is kept on the disk. Not towards the
// end: a part that waits at one discretizer while another is idle would cost what it
// saves. Two of a worker's tasks are never on their way to it at the same time, because
// only the newest is retained: it gets one ahead when it has accepted what it has.

namespace intaglio::job_service {
namespace {

constexpr std::uint32_t kPartsPerDiscretizer = 8;

// Units in which the progress of a part is told: parts count their work each in its own.
constexpr std::uint64_t kPartUnits = 1000;

std::uint64_t UnitsDone(const PartRecord& part) {
  if (part.done) return kPartUnits;
  if (part.total_count == 0) return 0;
  return std::min(kPartUnits, kPartUnits * part.done_count / part.total_count);
}

/// For another attempt at it.
void Reopen(PartRecord& part) {
  PartRecord open;
  open.attempt = part.attempt + 1;
  open.losses = part.losses;
  part = open;
}

std::string NameOf(const JobRecord& job, std::uint32_t part) {
  return fmt::format("part {} of {}", part + 1, job.parts.size());
}

bool AllDone(const JobRecord& job) {
  return std::all_of(job.parts.begin(), job.parts.end(),
                     [](const PartRecord& part) { return part.done; });
}

void CountProgress(JobRecord& job, Nanoseconds now) {
  StageRecord& stage = job.stage(intaglio_STAGE_DISCRETIZE);
  stage.elapsed_s = std::chrono::duration<double>(now - job.discretizing_since).count();
  stage.done_count = stage.total_count = 0;
  if (AllDone(job)) {
    for (const PartRecord& part : job.parts) stage.done_count += part.total_count;
    stage.total_count = stage.done_count;
    return;
  }
  for (const PartRecord& part : job.parts) stage.done_count += UnitsDone(part);
  stage.total_count = kPartUnits * job.parts.size();
  stage.done_count = std::min(stage.done_count, stage.total_count - 1);
}

}  // namespace

std::uint32_t PartCountFor(std::size_t discretizers) {
  if (discretizers <= 1) return 1;
  return static_cast<std::uint32_t>(
      std::min<std::size_t>(host::kMaxParts, kPartsPerDiscretizer * discretizers));
}

void JobQueue::CutIntoParts(JobRecord& job, const std::vector<std::string>& discretizers,
                            Nanoseconds now) {
  job.parts.assign(PartCountFor(discretizers.size()), {});
  for (std::size_t i = 0; i < std::min(discretizers.size(), job.parts.size()); ++i) {
    job.parts[i].worker = discretizers[i];
  }
  job.part_loss.clear();
  job.discretizing_since = now;
}

void JobQueue::GivePart(JobRecord& job, std::uint32_t part) {
  actions_.Give({job.parts[part].worker, intaglio_STAGE_DISCRETIZE,
                 job.TaskOf(intaglio_STAGE_DISCRETIZE, part),
                 job.stage(intaglio_STAGE_SORT).worker, false},
                job);
}

void JobQueue::GiveOpenParts(JobRecord& job, Nanoseconds now) {
  if (!job.active() || job.stage(intaglio_STAGE_DISCRETIZE).done) return;
  auto free = workers_.Free(intaglio_ROLE_DISCRETIZER, job.cell);
  std::reverse(free.begin(), free.end());
  for (std::uint32_t i = 0; i < job.parts.size() && !free.empty(); ++i) {
    PartRecord& part = job.parts[i];
    if (part.done || !part.worker.empty() || now < part.not_before) continue;
    part.worker = free.back();
    free.pop_back();
    workers_.Assign(part.worker, job.TaskOf(intaglio_STAGE_DISCRETIZE, i), now);
    GivePart(job, i);
  }
  GivePartsAhead(job, now);
  TellDiscretizing(job);
}

// A part that was lost before is not given ahead: kMaxPartAttempts counts on it. Each
// that is at work finds one more open that it can take when it has ended both.
void JobQueue::GivePartsAhead(JobRecord& job, Nanoseconds now) {
  const auto is_open = [](const PartRecord& part) {
    return !part.done && part.worker.empty();
  };
  std::set<std::string> at_work;
  for (const PartRecord& part : job.parts) {
    if (!part.done && !part.worker.empty()) at_work.insert(part.worker);
  }
  auto open_count = std::count_if(job.parts.begin(), job.parts.end(), is_open);
  auto part = job.parts.begin();
  for (const std::string& worker :
       workers_.WithoutNext(intaglio_ROLE_DISCRETIZER, job.uid, job.attempt)) {
    if (open_count <= static_cast<std::ptrdiff_t>(at_work.size())) return;
    part = std::find_if(part, job.parts.end(), [&](const PartRecord& candidate) {
      return is_open(candidate) && candidate.attempt == 0;
    });
    if (part == job.parts.end()) return;
    const auto index = static_cast<std::uint32_t>(part - job.parts.begin());
    part->worker = worker;
    workers_.AssignNext(worker, job.TaskOf(intaglio_STAGE_DISCRETIZE, index), now);
    GivePart(job, index);
    --open_count;
  }
}

void JobQueue::TellDiscretizing(JobRecord& job) {
  if (job.state != intaglio_JOB_DISCRETIZING) return;
  std::vector<std::string> said;
  if (!job.arm_loss.empty()) said.push_back(job.arm_loss);
  if (!job.last_loss.empty()) {
    said.push_back(fmt::format("attempt {}: {}", job.attempt, job.last_loss));
  }
  if (!job.part_loss.empty()) said.push_back(job.part_loss);
  const bool at_work = std::any_of(
      job.parts.begin(), job.parts.end(),
      [](const PartRecord& part) { return !part.done && !part.worker.empty(); });
  if (!at_work && workers_.Free(intaglio_ROLE_DISCRETIZER, job.cell).empty()) {
    said.push_back("waits for " + workers_.WhyNone(intaglio_ROLE_DISCRETIZER, job.cell));
  }
  const std::string message = fmt::format("{}", fmt::join(said, "; "));
  if (message != job.message) Tell(job, job.state, message);
}

void JobQueue::TakePart(JobRecord& job, const TaskView& task, Nanoseconds now) {
  if (task.task.part >= job.parts.size()) return;
  PartRecord& part = job.parts[task.task.part];
  if (part.worker != task.worker || part.attempt != task.task.part_attempt || part.done) {
    return;
  }
  part.done_count = task.done_count;
  part.total_count = task.total_count;
  if (task.state == intaglio_TASK_FAILED) return StageFailed(job, task, now);
  part.done = task.state == intaglio_TASK_DONE;
  CountProgress(job, now);
  if (AllDone(job)) return StageDone(job, task, now);
  Tell(job, job.state, job.message);
}

void JobQueue::LosePart(JobRecord& job, std::uint32_t index, const std::string& why,
                        Nanoseconds pause, Nanoseconds now) {
  PartRecord& part = job.parts.at(index);
  if (part.done || !job.active()) return;
  const GivenTask given{part.worker, intaglio_STAGE_DISCRETIZE,
                        job.TaskOf(intaglio_STAGE_DISCRETIZE, index), false};
  if (workers_.IsAssigned(given.worker, given.task)) Revoke(job, given, now);
  const std::uint32_t losses = part.losses + 1;
  if (losses >= host::kMaxPartLosses) {
    return EndJob(job, intaglio_JOB_FAILED,
                  fmt::format("{} is given up after {} attempts; {}", NameOf(job, index),
                              losses, why),
                  now);
  }
  Reopen(part);
  part.losses = losses;
  part.not_before = now + pause;
  CountProgress(job, now);
  job.part_loss = fmt::format("{} begins again: {}", NameOf(job, index), why);
  TellDiscretizing(job);
}

// It may yet be begun by a worker that only seems to be gone, so its number is used up.
// That the worker is lost its own part tells.
void JobQueue::LoseNextPart(const std::string& instance, const TaskId& task) {
  JobRecord* job = FindOpen(task.job_uid);
  if (job == nullptr || job->attempt != task.attempt || !job->active()) return;
  PartRecord& part = job->parts.at(task.part);
  if (part.worker != instance || part.attempt != task.part_attempt || part.done) return;
  actions_.Give({instance, intaglio_STAGE_DISCRETIZE, task, {}, true}, *job);
  Reopen(part);
}

// Whoever still makes a part again makes it for nobody.
void JobQueue::FinishParts(JobRecord& job, Nanoseconds now) {
  StageRecord& stage = job.stage(intaglio_STAGE_DISCRETIZE);
  if (stage.done) return;
  std::vector<GivenTask> parts = job.GivenTasks();
  std::erase_if(parts, [](const GivenTask& given) {
    return given.stage != intaglio_STAGE_DISCRETIZE || given.done;
  });
  RevokeStanding(job, parts, now);
  stage.done = true;
  actions_.StopFeed(job.uid);
}

}  // namespace intaglio::job_service
