#pragma once

// Discretizing by several discretizers: hands the parts of the jobs under way
// (job_parts.h) to the free discretizers, and follows the results.
//
// 1. A part is made again from the beginning when its worker is lost; the others go on,
//    and so do the stages behind, which get the same points from any worker.
// 2. A worker gets its next part ahead, so that it does not wait while its points are
//    sent, and while what has ended and what is given is kept on the disk. Two of a
//    worker's tasks are never on their way to it at the same time, because only the
//    newest is retained: it gets one ahead when it has accepted what it has.
// 3. A part that is lost kMaxPartLosses times gives the job up.
// 4. Nothing is granted before every part is reported: its report has the warnings about
//    its points. A part whose points have reached the machine, and whose worker is lost
//    before it reports, is made once more for that report alone, without a consumer.
// 5. Discretizers are compared with each other: what they make (comparing.h), and how
//    fast (worker_pace.h).
// Used from one thread.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/job_service/queue/comparing.h"
#include "services/job_service/queue/job_book.h"
#include "services/job_service/queue/task_handout.h"
#include "services/job_service/queue/worker_pace.h"

namespace intaglio::job_service {

class Discretizing {
 public:
  Discretizing(JobBook& book, TaskHandout& tasks)
      : book_(book), tasks_(tasks), comparing_(book, tasks) {}

  /// Another attempt of the job: its parts, of which these discretizers have the first,
  /// but are not given them yet.
  static void Cut(JobRecord& job, const std::vector<std::string>& discretizers,
                  Nanoseconds now);
  /// The parts that discretizers have.
  void GiveFirst(const JobRecord& job, Nanoseconds now);
  /// To the free discretizers, and ahead, a comparison first. Nothing for a job that is
  /// not under way.
  void GiveOpen(JobRecord& job, Nanoseconds now);

  enum class Outcome {
    kIgnored,   ///< about an old attempt, or from another worker
    kProgress,  ///< published
    kFailed,    ///< the caller decides what follows
    kAllDone,   ///< so was every other part
  };
  Outcome Receive(JobRecord& job, const TaskView& task, Nanoseconds now);

  /// A part is lost and open again after `pause`; why the job has to be given up over it,
  /// else nothing.
  std::optional<std::string> Lose(JobRecord& job, std::uint32_t part,
                                  const std::string& why, Nanoseconds pause,
                                  Nanoseconds now);
  /// One that this worker was given ahead. That the worker is lost is reported by the
  /// loss of the part it was at.
  void LoseAhead(const std::string& worker, const TaskId& task);
  Comparing& comparing() { return comparing_; }

 private:
  void NotePace(const TaskView& task, Nanoseconds now);
  void GiveAhead(JobRecord& job, Nanoseconds now);
  void PublishMessage(JobRecord& job);
  static void SetProgress(JobRecord& job, Nanoseconds now);

  JobBook& book_;
  TaskHandout& tasks_;
  Comparing comparing_;
  WorkerPace pace_;
};

}  // namespace intaglio::job_service
