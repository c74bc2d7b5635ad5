#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "services/host/task_part.h"
#include "services/job_service/job_queue.h"

// The part of the queue that has to do with the parts of a job's discretizing, which
// several discretizers work on at the same time. A part is made again from the beginning
// when its worker is lost; the others go on, and so do the stages behind, which get the
// same points whoever makes them.

namespace intaglio::job_service {
namespace {

constexpr std::uint32_t kPartsPerDiscretizer = 4;

// Units in which the progress of a part is told: parts count their work each in its own.
constexpr std::uint64_t kPartUnits = 1000;

std::uint64_t UnitsDone(const PartRecord& part) {
  if (part.done) return kPartUnits;
  if (part.total_count == 0) return 0;
  return std::min(kPartUnits, kPartUnits * part.done_count / part.total_count);
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

void JobQueue::GivePart(JobRecord& job, std::uint32_t part, Nanoseconds now) {
  const std::string& worker = job.parts[part].worker;
  const TaskId task = job.TaskOf(intaglio_STAGE_DISCRETIZE, part);
  workers_.Assign(worker, task, now);
  actions_.Give({worker, intaglio_STAGE_DISCRETIZE, task,
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
    GivePart(job, i, now);
  }
  TellDiscretizing(job);
}

void JobQueue::TellDiscretizing(JobRecord& job) {
  if (job.state != intaglio_JOB_DISCRETIZING) return;
  std::vector<std::string> said;
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
  const std::uint32_t tries = part.attempt + 1;
  if (tries >= host::kMaxPartAttempts) {
    return EndJob(job, intaglio_JOB_FAILED,
                  fmt::format("{} is given up after {} attempts; {}", NameOf(job, index),
                              tries, why),
                  now);
  }
  part = {};
  part.attempt = tries;
  part.not_before = now + pause;
  CountProgress(job, now);
  job.part_loss = fmt::format("{} begins again: {}", NameOf(job, index), why);
  TellDiscretizing(job);
}

// Whoever still makes a part again makes it for nobody.
void JobQueue::FinishParts(JobRecord& job, Nanoseconds now) {
  StageRecord& stage = job.stage(intaglio_STAGE_DISCRETIZE);
  if (stage.done) return;
  for (const GivenTask& given : job.GivenTasks()) {
    if (given.stage == intaglio_STAGE_DISCRETIZE && !given.done &&
        workers_.IsAssigned(given.worker, given.task)) {
      Revoke(job, given, now);
    }
  }
  stage.done = true;
  actions_.StopFeed(job.uid);
}

}  // namespace intaglio::job_service
