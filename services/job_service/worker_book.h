#pragma once

// Who could work, and who works on what, as health, tasks and their answers tell.
//
//   free --Assign--> assigned --Release (task ended)--> free
//                       |--Revoke--> revoked --Release, or ready again for a second-->
//                       free
//
// A worker is given a task only when it says that it is ready and nothing of ours is on
// it: a task to a worker that still drops an older one could be lost. Used from one
// thread.

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "idl/service.h"
#include "services/job_service/task_id.h"

namespace intaglio::job_service {

using Nanoseconds = std::chrono::nanoseconds;

/// ServiceHealth, the fields that count here.
struct WorkerView {
  std::string instance;
  intaglio_ServiceRole role = intaglio_ROLE_DISCRETIZER;
  intaglio_HealthState state = intaglio_HEALTH_STARTING;
  std::string cell;
  std::string message;
};

class WorkerBook {
 public:
  struct Assignment {
    TaskId task;  ///< without a job: none
    Nanoseconds since{0};
    bool answered = false;  ///< a TaskStatus came
    bool revoked = false;
  };

  void Update(const WorkerView& worker, Nanoseconds now);
  /// The worker is gone, or so slow that it seems to be; returns what it worked on.
  Assignment Lose(const std::string& instance);

  /// The free workers of that role, for a synchronizer of that cell; by name, so that the
  /// choice can be foretold.
  std::vector<std::string> Free(intaglio_ServiceRole role, const std::string& cell) const;
  /// Why there is none, e.g. "a sorter (all are busy)".
  std::string WhyNone(intaglio_ServiceRole role, const std::string& cell) const;

  void Assign(const std::string& instance, const TaskId& task, Nanoseconds now);
  /// Also for a worker that was not heard of yet (after our own restart).
  void Revoke(const std::string& instance, const TaskId& task, Nanoseconds now);
  void Answered(const std::string& instance, const TaskId& task);
  void Release(const std::string& instance, const TaskId& task);

  bool IsAlive(const std::string& instance) const;
  bool IsAssigned(const std::string& instance, const TaskId& task) const;
  /// Workers with a task that have said nothing about it, or have not told their health,
  /// for so long: health tells that a worker's loop runs, not only that its process is.
  std::vector<std::pair<std::string, Assignment>> Silent(Nanoseconds now,
                                                         Nanoseconds limit) const;

 private:
  struct Worker {
    WorkerView view;
    bool alive = false;
    Nanoseconds heard{0};  ///< newest health; of one not heard of yet: its assignment
    Assignment assignment;
  };
  bool Serves(const Worker& worker, intaglio_ServiceRole role,
              const std::string& cell) const;
  Worker* Find(const std::string& instance, const TaskId& task);

  std::map<std::string, Worker> workers_;
};

}  // namespace intaglio::job_service
