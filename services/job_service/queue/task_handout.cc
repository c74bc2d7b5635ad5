#include "services/job_service/queue/task_handout.h"

namespace intaglio::job_service {

void TaskHandout::Give(const JobRecord& job, intaglio_Stage stage,
                       const std::string& worker, const std::string& consumer,
                       Nanoseconds now) {
  workers_.Assign(worker, job.TaskOf(stage), now);
  actions_.Give({worker, stage, job.TaskOf(stage), consumer, false}, job);
}

void TaskHandout::GiveTakeUp(const JobRecord& job, Nanoseconds now) {
  const std::string& worker = job.stage(intaglio_STAGE_ENGRAVE).worker;
  const TaskId task = job.TaskOf(intaglio_STAGE_ENGRAVE);
  workers_.Assign(worker, task, now);
  actions_.Give({.worker = worker,
                 .stage = intaglio_STAGE_ENGRAVE,
                 .task = task,
                 .consumer = {},
                 .take_up = true},
                job);
}

void TaskHandout::GivePart(const JobRecord& job, std::uint32_t part, Nanoseconds now) {
  workers_.Assign(job.parts[part].worker, job.TaskOf(intaglio_STAGE_DISCRETIZE, part),
                  now);
  SendPart(job, part);
}

void TaskHandout::GivePartAhead(const JobRecord& job, std::uint32_t part,
                                Nanoseconds now) {
  workers_.AssignNext(job.parts[part].worker, job.TaskOf(intaglio_STAGE_DISCRETIZE, part),
                      now);
  SendPart(job, part);
}

void TaskHandout::GiveComparison(const JobRecord& job, bool ahead, Nanoseconds now) {
  const std::string& worker = job.comparison->worker;
  const TaskId task = job.ComparisonTask();
  if (ahead) {
    workers_.AssignNext(worker, task, now);
  } else {
    workers_.Assign(worker, task, now);
  }
  actions_.Give({worker, intaglio_STAGE_DISCRETIZE, task, {}, false}, job);
}

void TaskHandout::SendPart(const JobRecord& job, std::uint32_t part) {
  const std::string consumer =
      job.has_path() ? "" : job.stage(intaglio_STAGE_SORT).worker;
  actions_.Give({job.parts[part].worker, intaglio_STAGE_DISCRETIZE,
                 job.TaskOf(intaglio_STAGE_DISCRETIZE, part), consumer, false},
                job);
}

void TaskHandout::Revoke(const JobRecord& job, const GivenTask& given, Nanoseconds now) {
  workers_.Revoke(given.worker, given.task, now);
  const bool goes_on =
      given.stage == intaglio_STAGE_ENGRAVE && job.arm.ever_granted() && !job.ended();
  actions_.Give({given.worker, given.stage, given.task, {}, true, goes_on}, job);
}

// The list is made first, because one revocation removes the other tasks of its worker
// from the book.
void TaskHandout::RevokeHeld(const JobRecord& job, std::vector<GivenTask> tasks,
                             Nanoseconds now) {
  std::erase_if(tasks, [this](const GivenTask& given) {
    return !workers_.IsAssigned(given.worker, given.task);
  });
  for (const GivenTask& given : tasks) Revoke(job, given, now);
}

void TaskHandout::RevokeAndStopFeed(const JobRecord& job,
                                    const std::vector<GivenTask>& tasks,
                                    Nanoseconds now) {
  StopFeed(job);
  RevokeHeld(job, tasks, now);
}

void TaskHandout::RevokePartAhead(const JobRecord& job, const std::string& worker,
                                  const TaskId& task) {
  actions_.Give({worker, intaglio_STAGE_DISCRETIZE, task, {}, true}, job);
}

void TaskHandout::LeaveOut(const std::string& worker, const std::string& why) {
  workers_.LeaveOut(worker, why);
  actions_.LeftOutChanged({worker, why, true});
}

void TaskHandout::Suspect(const std::string& worker, const std::string& why,
                          const std::string& kept) {
  if (workers_.IsWrong(worker)) return;
  workers_.Suspect(worker, why);
  actions_.LeftOutChanged({worker, kept, false});
}

void TaskHandout::TakeBack(const std::string& worker) {
  if (workers_.IsWrong(worker) || workers_.WhyLeftOut(worker).empty()) return;
  workers_.TakeBack(worker);
  actions_.LeftOutChanged({worker, "", false});
}

bool TaskHandout::Admit(const std::string& worker, const std::string& operator_name) {
  const bool was_left_out = !workers_.WhyLeftOut(worker).empty();
  if (!workers_.Admit(worker)) return false;
  if (was_left_out) actions_.LeftOutChanged({worker, "", false, operator_name});
  return true;
}

void TaskHandout::ForgetLost(Nanoseconds now) {
  for (const std::string& instance : workers_.ForgetLost(now)) {
    actions_.WorkerForgotten(instance);
  }
}

}  // namespace intaglio::job_service
