#pragma once

// The workers and their tasks, known from their health, the tasks given and the answers
// to them.
//
//   free --Assign--> assigned --Release (task ended)--> free
//                       |--Revoke--> revoked --Release, or ready again for a second-->
//                       free
//
// A worker is given a task only when it reports that it is ready and has nothing of ours:
// a task to a worker that still drops an older one could be lost. One that has reported
// to be at work on a part may be given its next one ahead, which it then begins by
// itself.
//
// Nothing new is given to a worker of another version than this job service, and no
// engraving to a machine of which a service has another: a field that one of them does
// not know would be left out without a word. What it has already it makes to its end.
//
// A lost worker is forgotten after kLostStaysFor, when kLostKept were lost after it:
// until then it may come back, from a cut network. Used from one thread.

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "idl/service.h"
#include "services/job_service/queue/ended_list.h"
#include "services/job_service/records/left_out.h"
#include "services/job_service/records/task_id.h"
#include "services/platform/host/version/wire_version.h"

namespace intaglio::job_service {

/// ServiceHealth, the fields that count here.
struct WorkerView {
  std::string instance;
  intaglio_ServiceRole role = intaglio_ROLE_DISCRETIZER;
  intaglio_HealthState state = intaglio_HEALTH_STARTING;
  std::string cell;
  std::string message;
  std::string version = host::WireVersion();
};

class WorkerBook {
 public:
  struct Assignment {
    TaskId task;  ///< without a job: none
    Nanoseconds since{0};
    bool answered = false;  ///< a TaskStatus came
    bool revoked = false;

    bool empty() const { return task.job_uid.empty(); }
  };

  void Update(const WorkerView& worker, Nanoseconds now);
  /// What a worker has of us, in the order of its work.
  struct Assignments {
    Assignment task;
    Assignment next;
  };

  static constexpr std::size_t kLostKept = 64;
  static constexpr std::chrono::hours kLostStaysFor{1};

  /// The worker is gone, or so slow that it seems to be; returns what it had.
  Assignments Lose(const std::string& instance, Nanoseconds now);
  /// Those that are forgotten now, each once.
  std::vector<std::string> ForgetLost(Nanoseconds now);
  std::size_t count() const { return workers_.size(); }

  /// The free workers of that role, for a synchronizer of that cell; by name, so that the
  /// choice can be predicted.
  std::vector<std::string> Free(intaglio_ServiceRole role, const std::string& cell) const;
  /// The workers of that role that are known to work on this chain of a job and have no
  /// next task.
  std::vector<std::string> WithoutNext(intaglio_ServiceRole role,
                                       const std::string& job_uid,
                                       std::uint32_t attempt) const;
  /// Alive and usable, at work or not, by name.
  std::vector<std::string> Serving(intaglio_ServiceRole role) const;
  /// Why there is none, e.g. "a sorter (all are busy)"; that of a machine is called as
  /// `maker` says. Unless `all_reported`, one that has not reported may run.
  std::string WhyNone(intaglio_ServiceRole role, const std::string& cell,
                      std::string_view maker, bool all_reported) const;

  void Assign(const std::string& instance, const TaskId& task, Nanoseconds now);
  /// To be begun when what it works on has ended.
  void AssignNext(const std::string& instance, const TaskId& task, Nanoseconds now);
  /// Also of a worker without health so far (after our own restart).
  void Revoke(const std::string& instance, const TaskId& task, Nanoseconds now);
  void Answered(const std::string& instance, const TaskId& task);
  /// It has ended; the next one, if there is one, is worked on from now on.
  void Release(const std::string& instance, const TaskId& task, Nanoseconds now);

  /// Nothing is given to it any more, until Admit or the end of its process.
  void LeaveOut(const std::string& instance, const std::string& why);
  /// The same until TakeBack.
  void Suspect(const std::string& instance, const std::string& why);
  void TakeBack(const std::string& instance);
  /// A person has mended it: neither left out nor slow. False: it was neither.
  bool Admit(const std::string& instance);
  /// As an earlier run of the job service has left it out; it may have gone.
  void Restore(const LeftOut& worker, Nanoseconds now);
  /// Nothing is given to it until then, while there are others of its role.
  void SetSlow(const std::string& instance, const std::string& why, Nanoseconds until);
  void EndSlow(Nanoseconds now);
  /// LeaveOut was called for it.
  bool IsWrong(const std::string& instance) const;
  /// Empty: it is not, or it is unknown. Of a slow one empty, too.
  std::string WhyLeftOut(const std::string& instance) const;
  /// Living workers that are left out or slow, and why.
  std::map<std::string, std::string> LeftOutNow() const;
  /// The same, each sentence once.
  std::vector<std::string> Remarks() const;

  bool IsAlive(const std::string& instance) const;
  /// What it has is of this attempt of a job, revoked or not.
  bool HasOrHad(const std::string& instance, const TaskId& task) const;
  /// Either to be worked on or as the next one, and not revoked.
  bool IsAssigned(const std::string& instance, const TaskId& task) const;
  /// Workers with a task that have not answered it, or have not reported their health,
  /// for so long: health shows that a worker's loop runs, not only that its process is
  /// there.
  std::vector<std::pair<std::string, Assignments>> Silent(Nanoseconds now,
                                                          Nanoseconds limit) const;

 private:
  struct Worker {
    WorkerView view;
    bool alive = false;
    Nanoseconds reported_at{0};  ///< its newest health; before the first: its assignment
    Assignments has;
    std::string left_out;   ///< why; empty: it is not
    bool for_good = false;  ///< that
    std::string slow;       ///< why; empty: it is not
    Nanoseconds slow_until{0};
  };
  /// It may be given something, if it is free.
  bool IsUsable(const Worker& worker) const;
  bool HasFaster(intaglio_ServiceRole role) const;
  bool Serves(const Worker& worker, intaglio_ServiceRole role,
              const std::string& cell) const;
  /// A service whose version keeps this worker from a task; nullptr: there is none.
  const WorkerView* OfAnotherVersion(const WorkerView& worker) const;
  Assignment* Find(const std::string& instance, const TaskId& task);

  std::map<std::string, Worker> workers_;
  EndedList lost_{kLostKept, kLostStaysFor};
};

}  // namespace intaglio::job_service
