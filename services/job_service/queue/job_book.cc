#include "services/job_service/queue/job_book.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

namespace intaglio::job_service {

JobRecord& JobBook::Add(JobRecord job) {
  const std::string uid = job.uid;
  JobRecord& added = jobs_[uid] = std::move(job);
  in_turn_[TurnOf(added)] = &added;
  ++waiting_revision_;
  if (added.active()) active_.insert(&added);
  return added;
}

JobRecord& JobBook::AddNew(JobRecord job) {
  const auto behind =
      in_turn_.upper_bound({-job.priority, std::numeric_limits<std::int64_t>::max(),
                            std::numeric_limits<std::uint32_t>::max()});
  const auto last = TurnAhead(behind, job.priority);
  job.turn = last ? *last + kTurnStep : 0;
  return Add(std::move(job));
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

std::vector<JobRecord*> JobBook::InTurn() const {
  std::vector<JobRecord*> jobs;
  for (const auto& [turn, job] : in_turn_) jobs.push_back(job);
  return jobs;
}

std::vector<JobRecord*> JobBook::ActiveInTurn() const {
  std::vector<JobRecord*> jobs(active_.begin(), active_.end());
  std::ranges::sort(jobs, {}, [](const JobRecord* job) { return TurnOf(*job); });
  return jobs;
}

bool JobBook::CellIsTaken(const std::string& cell) const {
  return std::ranges::any_of(active_,
                             [&](const JobRecord* job) { return job->cell == cell; });
}

// ---- The order of the turn ----------------------------------------------------------

std::string JobBook::WhyNotMoved(const JobRecord& job,
                                 const std::string& before_job_uid) const {
  if (!IsWaiting(job, job.cell)) {
    return fmt::format(
        "job {} has its machine already: only a job that is queued can be "
        "moved",
        job.number);
  }
  if (before_job_uid.empty()) return "";
  const JobRecord* before = Find(before_job_uid);
  if (before == nullptr) {
    return fmt::format("no job {} to move job {} before: see intaglio list",
                       before_job_uid, job.number);
  }
  if (before->uid == job.uid)
    return fmt::format("job {} cannot be moved before itself", job.number);
  if (IsWaiting(*before, job.cell)) return "";
  return fmt::format("job {} does not wait for {}: job {} cannot be moved before it",
                     before->number, job.cell, job.number);
}

const JobRecord* JobBook::LastWaiting(const JobRecord& job) const {
  for (auto entry = in_turn_.rbegin(); entry != in_turn_.rend(); ++entry) {
    const JobRecord& other = *entry->second;
    if (other.uid != job.uid && IsWaiting(other, job.cell)) return &other;
  }
  return nullptr;
}

void JobBook::SpreadTurns(std::int32_t priority) {
  std::vector<JobRecord*> equal;
  for (JobRecord* job : InTurn())
    if (job->priority == priority) equal.push_back(job);
  std::erase_if(in_turn_,
                [&](const auto& entry) { return std::get<0>(entry.first) == -priority; });
  std::int64_t turn = 0;
  for (JobRecord* job : equal) {
    job->turn = turn += kTurnStep;
    in_turn_[TurnOf(*job)] = job;
    if (!job->ended()) Change(*job, job->state, job->message);
  }
}

std::optional<std::int64_t> JobBook::TurnAhead(
    std::map<Turn, JobRecord*>::const_iterator entry, std::int32_t priority) const {
  if (entry == in_turn_.begin()) return std::nullopt;
  const Turn& ahead = std::prev(entry)->first;
  if (std::get<0>(ahead) != -priority) return std::nullopt;
  return std::get<1>(ahead);
}

std::int64_t JobBook::TurnBefore(const JobRecord& next) {
  const auto previous_turn = [&] {
    return TurnAhead(in_turn_.find(TurnOf(next)), next.priority)
        .value_or(next.turn - 2 * kTurnStep);
  };
  if (next.turn - previous_turn() < 2) SpreadTurns(next.priority);
  return previous_turn() + (next.turn - previous_turn()) / 2;
}

void JobBook::Move(JobRecord& job, const std::string& before_job_uid) {
  const JobRecord* before = Find(before_job_uid);
  const JobRecord* last = LastWaiting(job);
  if (before == nullptr && last == nullptr) return;
  in_turn_.erase(TurnOf(job));
  if (before != nullptr) {
    job.turn = TurnBefore(*before);
    job.priority = before->priority;
  } else {
    job.turn = last->turn + kTurnStep;
    job.priority = last->priority;
  }
  in_turn_[TurnOf(job)] = &job;
  ++waiting_revision_;
  Change(job, job.state, job.message);
}

void JobBook::Change(JobRecord& job, intaglio_JobState state,
                     const std::string& message) {
  NoteState(job, std::exchange(job.state, state));
  if (state != intaglio_JOB_PAUSED) job.pause_reason = intaglio_PAUSE_NONE;
  if (state != intaglio_JOB_QUEUED) job.queue_place = 0;
  job.message = message;
  if (state != intaglio_JOB_PAUSED) job.at_work.clear();
  if (state != intaglio_JOB_ENGRAVING && state != intaglio_JOB_PAUSED) job.alarm.clear();
  ++job.revision;
  actions_.Changed(job);
}

void JobBook::NoteState(JobRecord& job, intaglio_JobState before) {
  const bool waited = before == intaglio_JOB_QUEUED;
  if (waited != (job.state == intaglio_JOB_QUEUED)) ++waiting_revision_;
  has_ended_ = has_ended_ || job.ended();
  if (job.active()) {
    active_.insert(&job);
  } else {
    active_.erase(&job);
    job.awaits_block = false;
  }
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
  if (std::exchange(has_ended_, false))
    std::erase_if(in_turn_, [](const auto& entry) { return entry.second->ended(); });
  while (const auto uid = ended_.TakeOldest(now)) {
    const auto job = jobs_.find(*uid);
    actions_.Forgotten(job->second);
    jobs_.erase(job);
  }
}

}  // namespace intaglio::job_service
