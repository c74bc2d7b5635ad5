#include "services/job_service/queue/worker_book.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

// Health comes five times a second: ready for a second means that the revocation was
// there before, and nothing of the task is left.
constexpr Nanoseconds kReadyAgain = 1s;

std::string NameOf(intaglio_ServiceRole role, std::string_view maker) {
  switch (role) {
    case intaglio_ROLE_DISCRETIZER:
      return "a discretizer";
    case intaglio_ROLE_SORTER:
      return "a sorter";
    case intaglio_ROLE_SYNCHRONIZER:
      return fmt::format("a {}", maker);
    default:
      return "a service";
  }
}

bool WorksOrWaits(const WorkerView& worker) {
  return worker.state == intaglio_HEALTH_READY || worker.state == intaglio_HEALTH_BUSY;
}

}  // namespace

void WorkerBook::Update(const WorkerView& view, Nanoseconds now) {
  Worker& worker = workers_[view.instance];
  worker.view = view;
  worker.alive = true;
  worker.reported_at = now;
  const Assignment& task = worker.has.task;
  if (task.revoked && view.state == intaglio_HEALTH_READY &&
      now - task.since >= kReadyAgain) {
    worker.has = {};
  }
}

WorkerBook::Assignments WorkerBook::Lose(const std::string& instance, Nanoseconds now) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return {};
  // It may only have been slow: what it works on is kept, to be revoked for when it is
  // back.
  if (found->second.alive) lost_.Add(instance, now);
  found->second.alive = false;
  return found->second.has;
}

// One that came back is not forgotten; lost once more, it is in the list again.
std::vector<std::string> WorkerBook::ForgetLost(Nanoseconds now) {
  std::vector<std::string> forgotten;
  while (auto instance = lost_.TakeOldest(now)) {
    const auto found = workers_.find(*instance);
    if (found == workers_.end() || found->second.alive ||
        now - found->second.reported_at < kLostStaysFor) {
      continue;
    }
    workers_.erase(found);
    forgotten.push_back(std::move(*instance));
  }
  return forgotten;
}

bool WorkerBook::Serves(const Worker& worker, intaglio_ServiceRole role,
                        const std::string& cell) const {
  return worker.alive && worker.view.role == role &&
         (role != intaglio_ROLE_SYNCHRONIZER || worker.view.cell == cell);
}

const WorkerView* WorkerBook::OfAnotherVersion(const WorkerView& worker) const {
  const std::string& ours = host::WireVersion();
  if (worker.version != ours) return &worker;
  if (worker.role != intaglio_ROLE_SYNCHRONIZER) return nullptr;
  for (const auto& [instance, other] : workers_) {
    const WorkerView& view = other.view;
    const bool of_machine = other.alive && view.cell == worker.cell &&
                            view.role == intaglio_ROLE_MOTION_BRIDGE;
    if (of_machine && view.version != ours) return &view;
  }
  return nullptr;
}

bool WorkerBook::HasFaster(intaglio_ServiceRole role) const {
  return std::ranges::any_of(workers_, [&](const auto& entry) {
    const Worker& other = entry.second;
    return other.alive && other.view.role == role && other.slow.empty() &&
           other.left_out.empty() && WorksOrWaits(other.view) &&
           OfAnotherVersion(other.view) == nullptr;
  });
}

bool WorkerBook::IsUsable(const Worker& worker) const {
  return worker.left_out.empty() && OfAnotherVersion(worker.view) == nullptr &&
         (worker.slow.empty() || !HasFaster(worker.view.role));
}

std::vector<std::string> WorkerBook::Serving(intaglio_ServiceRole role) const {
  std::vector<std::string> serving;
  for (const auto& [instance, worker] : workers_) {
    if (worker.alive && worker.view.role == role && WorksOrWaits(worker.view) &&
        IsUsable(worker)) {
      serving.push_back(instance);
    }
  }
  return serving;
}

void WorkerBook::LeaveOut(const std::string& instance, const std::string& why) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return;
  found->second.left_out = why;
  found->second.for_good = true;
}

void WorkerBook::Suspect(const std::string& instance, const std::string& why) {
  const auto found = workers_.find(instance);
  if (found != workers_.end() && !found->second.for_good) found->second.left_out = why;
}

void WorkerBook::TakeBack(const std::string& instance) {
  const auto found = workers_.find(instance);
  if (found != workers_.end() && !found->second.for_good) found->second.left_out.clear();
}

bool WorkerBook::Admit(const std::string& instance) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return false;
  Worker& worker = found->second;
  if (worker.left_out.empty() && worker.slow.empty()) return false;
  worker.left_out.clear();
  worker.slow.clear();
  worker.for_good = false;
  return true;
}

void WorkerBook::Restore(const LeftOut& left_out, Nanoseconds now) {
  Worker& worker = workers_[left_out.worker];
  worker.left_out = left_out.why;
  worker.for_good = left_out.for_good;
  worker.reported_at = now;
  lost_.Add(left_out.worker, now);
}

void WorkerBook::SetSlow(const std::string& instance, const std::string& why,
                         Nanoseconds until) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return;
  found->second.slow = why;
  found->second.slow_until = until;
}

void WorkerBook::EndSlow(Nanoseconds now) {
  for (auto& [instance, worker] : workers_) {
    if (now >= worker.slow_until) worker.slow.clear();
  }
}

bool WorkerBook::IsWrong(const std::string& instance) const {
  const auto found = workers_.find(instance);
  return found != workers_.end() && found->second.for_good;
}

std::string WorkerBook::WhyLeftOut(const std::string& instance) const {
  const auto found = workers_.find(instance);
  return found == workers_.end() ? std::string() : found->second.left_out;
}

std::map<std::string, std::string> WorkerBook::LeftOutNow() const {
  std::map<std::string, std::string> left_out;
  for (const auto& [instance, worker] : workers_) {
    const std::string& why = worker.left_out.empty() ? worker.slow : worker.left_out;
    if (worker.alive && !why.empty()) left_out[instance] = why;
  }
  return left_out;
}

// A reason that several are suspected for is reported once.
std::vector<std::string> WorkerBook::Remarks() const {
  std::vector<std::string> remarks;
  for (const auto& [instance, why] : LeftOutNow()) {
    if (std::ranges::find(remarks, why) == remarks.end()) remarks.push_back(why);
  }
  return remarks;
}

std::vector<std::string> WorkerBook::Free(intaglio_ServiceRole role,
                                          const std::string& cell) const {
  std::vector<std::string> free;
  for (const auto& [instance, worker] : workers_) {
    if (Serves(worker, role, cell) && worker.view.state == intaglio_HEALTH_READY &&
        worker.has.task.empty() && IsUsable(worker)) {
      free.push_back(instance);
    }
  }
  return free;
}

std::vector<std::string> WorkerBook::WithoutNext(intaglio_ServiceRole role,
                                                 const std::string& job_uid,
                                                 std::uint32_t attempt) const {
  std::vector<std::string> without;
  for (const auto& [instance, worker] : workers_) {
    const Assignment& at = worker.has.task;
    const bool works = worker.alive && worker.view.role == role && at.answered &&
                       !at.revoked && IsUsable(worker);
    if (works && at.task.job_uid == job_uid && at.task.attempt == attempt &&
        worker.has.next.empty()) {
      without.push_back(instance);
    }
  }
  return without;
}

std::string WorkerBook::WhyNone(intaglio_ServiceRole role, const std::string& cell,
                                std::string_view maker, bool all_reported) const {
  std::string text = NameOf(role, maker);
  if (role == intaglio_ROLE_SYNCHRONIZER) text += " of " + cell;
  const Worker* seen = nullptr;
  for (const auto& [instance, worker] : workers_) {
    if (!Serves(worker, role, cell)) continue;
    const bool is_better = seen == nullptr || OfAnotherVersion(seen->view) != nullptr ||
                           !seen->left_out.empty();
    if (is_better) seen = &worker;
  }
  if (seen == nullptr)
    return text + (all_reported ? " (none runs)" : " (one that runs reports within 2 s)");
  if (seen->view.state == intaglio_HEALTH_FAULT) {
    return fmt::format("{} ({} has a fault: {})", text, seen->view.instance,
                       seen->view.message);
  }
  if (const WorkerView* other = OfAnotherVersion(seen->view)) {
    return fmt::format(
        "{} ({} has version {}, the job service {}: restart the older one when no job is "
        "engraved)",
        text, other->instance, other->version, host::WireVersion());
  }
  if (!seen->left_out.empty()) return fmt::format("{} ({})", text, seen->left_out);
  return text + " (all are busy)";
}

void WorkerBook::Assign(const std::string& instance, const TaskId& task,
                        Nanoseconds now) {
  Worker& worker = workers_[instance];
  worker.has = {{task, now, false, false}, {}};
  if (!worker.alive) worker.reported_at = now;
}

void WorkerBook::AssignNext(const std::string& instance, const TaskId& task,
                            Nanoseconds now) {
  workers_[instance].has.next = {task, now, false, false};
}

// A revocation takes all that a worker has of the job, whichever part it names.
void WorkerBook::Revoke(const std::string& instance, const TaskId& task,
                        Nanoseconds now) {
  workers_[instance].has = {{task, now, true, true}, {}};
}

WorkerBook::Assignment* WorkerBook::Find(const std::string& instance,
                                         const TaskId& task) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return nullptr;
  Assignments& has = found->second.has;
  if (has.task.task == task) return &has.task;
  return has.next.task == task ? &has.next : nullptr;
}

void WorkerBook::Answered(const std::string& instance, const TaskId& task) {
  if (Assignment* found = Find(instance, task)) found->answered = true;
}

void WorkerBook::Release(const std::string& instance, const TaskId& task,
                         Nanoseconds now) {
  Assignment* found = Find(instance, task);
  if (found == nullptr) return;
  Assignments& has = workers_.at(instance).has;
  if (found == &has.task) {
    has.task = has.next;
    has.task.since = now;
  }
  has.next = {};
}

bool WorkerBook::IsAlive(const std::string& instance) const {
  const auto found = workers_.find(instance);
  return found != workers_.end() && found->second.alive;
}

bool WorkerBook::HasOrHad(const std::string& instance, const TaskId& task) const {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return false;
  const TaskId& has = found->second.has.task.task;
  return has.job_uid == task.job_uid && has.attempt == task.attempt;
}

bool WorkerBook::IsAssigned(const std::string& instance, const TaskId& task) const {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return false;
  const Assignments& has = found->second.has;
  return !has.task.revoked && (has.task.task == task || has.next.task == task);
}

std::vector<std::pair<std::string, WorkerBook::Assignments>> WorkerBook::Silent(
    Nanoseconds now, Nanoseconds limit) const {
  std::vector<std::pair<std::string, Assignments>> silent;
  for (const auto& [instance, worker] : workers_) {
    const Assignment& task = worker.has.task;
    if (task.empty() || task.revoked) continue;
    const bool unanswered = !task.answered && now - task.since >= limit;
    if (unanswered || now - worker.reported_at >= limit) {
      silent.emplace_back(instance, worker.has);
    }
  }
  return silent;
}

}  // namespace intaglio::job_service
