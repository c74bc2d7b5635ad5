#include "services/job_service/queue/job_book.h"

namespace intaglio::job_service {

JobRecord& JobBook::Add(JobRecord job) {
  in_turn_[{-job.priority, job.number}] = job.uid;
  const std::string uid = job.uid;
  return jobs_[uid] = std::move(job);
}

void JobBook::AddEnded(JobRecord job, Nanoseconds now) {
  const std::string uid = job.uid;
  const JobRecord& added = jobs_[uid] = std::move(job);
  ended_.Add(uid, now);
  actions_.Progressed(added);
}

const JobRecord* JobBook::Find(const std::string& job_uid) const {
  const auto found = jobs_.find(job_uid);
  return found == jobs_.end() ? nullptr : &found->second;
}

JobRecord* JobBook::Find(const std::string& job_uid) {
  const auto found = jobs_.find(job_uid);
  return found == jobs_.end() ? nullptr : &found->second;
}

JobRecord* JobBook::FindOpen(const std::string& job_uid) {
  JobRecord* job = Find(job_uid);
  return job == nullptr || job->ended() ? nullptr : job;
}

std::vector<JobRecord*> JobBook::InTurn() {
  std::vector<JobRecord*> jobs;
  for (const auto& [turn, uid] : in_turn_) jobs.push_back(&jobs_.at(uid));
  return jobs;
}

bool JobBook::CellIsTaken(const std::string& cell) const {
  for (const auto& [uid, job] : jobs_) {
    if (job.active() && job.cell == cell) return true;
  }
  return false;
}

void JobBook::Change(JobRecord& job, intaglio_JobState state,
                     const std::string& message) {
  job.state = state;
  if (state != intaglio_JOB_PAUSED) job.pause_reason = intaglio_PAUSE_NONE;
  job.message = message;
  if (state != intaglio_JOB_ENGRAVING && state != intaglio_JOB_PAUSED) job.alarm.clear();
  ++job.revision;
  actions_.Changed(job);
}

void JobBook::ChangeToPaused(JobRecord& job, intaglio_PauseReason reason,
                             const std::string& message) {
  job.pause_reason = reason;
  Change(job, intaglio_JOB_PAUSED, message);
}

void JobBook::Publish(JobRecord& job, intaglio_JobState state,
                      const std::string& message) {
  if (state != job.state) return Change(job, state, message);
  job.message = message;
  ++job.revision;
  actions_.Progressed(job);
}

void JobBook::End(JobRecord& job, intaglio_JobState state, const std::string& message,
                  Nanoseconds now) {
  Change(job, state, message);
  ended_.Add(job.uid, now);
}

void JobBook::Forget(Nanoseconds now) {
  std::erase_if(in_turn_,
                [this](const auto& entry) { return jobs_.at(entry.second).ended(); });
  while (const auto uid = ended_.TakeOldest(now)) {
    const auto job = jobs_.find(*uid);
    actions_.Forgotten(job->second);
    jobs_.erase(job);
  }
}

}  // namespace intaglio::job_service
