#include "services/job_service/worker_book.h"

#include <fmt/format.h>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

// Health comes five times a second: ready for a second means that the revocation was
// there before, and nothing of the task is left.
constexpr Nanoseconds kReadyAgain = 1s;

const char* NameOf(intaglio_ServiceRole role) {
  switch (role) {
    case intaglio_ROLE_DISCRETIZER:
      return "a discretizer";
    case intaglio_ROLE_SORTER:
      return "a sorter";
    case intaglio_ROLE_SYNCHRONIZER:
      return "a synchronizer";
    default:
      return "a service";
  }
}

}  // namespace

void WorkerBook::Update(const WorkerView& view, Nanoseconds now) {
  Worker& worker = workers_[view.instance];
  worker.view = view;
  worker.alive = true;
  worker.heard = now;
  const Assignment& assignment = worker.assignment;
  if (assignment.revoked && view.state == intaglio_HEALTH_READY &&
      now - assignment.since >= kReadyAgain) {
    worker.assignment = {};
  }
}

WorkerBook::Assignment WorkerBook::Lose(const std::string& instance) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return {};
  // It may only have been slow: what it works on is kept, to be revoked for when it is
  // back.
  found->second.alive = false;
  return found->second.assignment;
}

bool WorkerBook::Serves(const Worker& worker, intaglio_ServiceRole role,
                        const std::string& cell) const {
  return worker.alive && worker.view.role == role &&
         (role != intaglio_ROLE_SYNCHRONIZER || worker.view.cell == cell);
}

std::vector<std::string> WorkerBook::Free(intaglio_ServiceRole role,
                                          const std::string& cell) const {
  std::vector<std::string> free;
  for (const auto& [instance, worker] : workers_) {
    if (Serves(worker, role, cell) && worker.view.state == intaglio_HEALTH_READY &&
        worker.assignment.task.job_uid.empty()) {
      free.push_back(instance);
    }
  }
  return free;
}

std::string WorkerBook::WhyNone(intaglio_ServiceRole role,
                                const std::string& cell) const {
  std::string text = NameOf(role);
  if (role == intaglio_ROLE_SYNCHRONIZER) text += " of " + cell;
  const Worker* seen = nullptr;
  for (const auto& [instance, worker] : workers_) {
    if (Serves(worker, role, cell)) seen = &worker;
  }
  if (seen == nullptr) return text + " (none runs)";
  if (seen->view.state == intaglio_HEALTH_FAULT) {
    return fmt::format("{} ({} has a fault: {})", text, seen->view.instance,
                       seen->view.message);
  }
  return text + " (all are busy)";
}

void WorkerBook::Assign(const std::string& instance, const TaskId& task,
                        Nanoseconds now) {
  Worker& worker = workers_[instance];
  worker.assignment = {task, now, false, false};
  if (!worker.alive) worker.heard = now;
}

void WorkerBook::Revoke(const std::string& instance, const TaskId& task,
                        Nanoseconds now) {
  workers_[instance].assignment = {task, now, true, true};
}

WorkerBook::Worker* WorkerBook::Find(const std::string& instance, const TaskId& task) {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return nullptr;
  return found->second.assignment.task == task ? &found->second : nullptr;
}

void WorkerBook::Answered(const std::string& instance, const TaskId& task) {
  if (Worker* worker = Find(instance, task)) worker->assignment.answered = true;
}

void WorkerBook::Release(const std::string& instance, const TaskId& task) {
  if (Worker* worker = Find(instance, task)) worker->assignment = {};
}

bool WorkerBook::IsAlive(const std::string& instance) const {
  const auto found = workers_.find(instance);
  return found != workers_.end() && found->second.alive;
}

bool WorkerBook::IsAssigned(const std::string& instance, const TaskId& task) const {
  const auto found = workers_.find(instance);
  if (found == workers_.end()) return false;
  const Assignment& assignment = found->second.assignment;
  return !assignment.revoked && assignment.task == task;
}

std::vector<std::pair<std::string, WorkerBook::Assignment>> WorkerBook::Silent(
    Nanoseconds now, Nanoseconds limit) const {
  std::vector<std::pair<std::string, Assignment>> silent;
  for (const auto& [instance, worker] : workers_) {
    const Assignment& assignment = worker.assignment;
    if (assignment.task.job_uid.empty() || assignment.revoked) continue;
    const bool unanswered = !assignment.answered && now - assignment.since >= limit;
    if (unanswered || now - worker.heard >= limit) {
      silent.emplace_back(instance, assignment);
    }
  }
  return silent;
}

}  // namespace intaglio::job_service
