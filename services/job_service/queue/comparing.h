#pragma once

// Compares discretizers: every kCompareEvery-th part is made by a second one as well,
// whose points go nowhere, and the checksums are compared (result_checksum.h).
//
// 1. A checksum that two discretizers have made is right; whoever has made another one is
//    wrong and is given nothing more.
// 2. While checksums differ, one that has not made the part yet decides. When there is
//    none, all that made it are suspected and given nothing more until one comes, which
//    may be one of them after its restart.
// 3. A job whose comparison is under way is not granted a permission. One that has a part
//    of a discretizer that is wrong or suspected is disarmed and cannot be armed.
// 4. One discretizer alone is not compared, and neither is it waited for a second one
//    that has gone.
// Used from one thread.

#include <string>
#include <vector>

#include "services/job_service/queue/job_book.h"
#include "services/job_service/queue/task_handout.h"

namespace intaglio::job_service {

/// 2 % more work; with two discretizers one job in three has a comparison.
inline constexpr std::uint32_t kCompareEvery = 50;

/// A discretizer whose part differs from those of two others, which are equal.
struct WrongWorker {
  std::string worker;
  std::string why;  ///< for people
};

class Comparing {
 public:
  Comparing(JobBook& book, TaskHandout& tasks) : book_(book), tasks_(tasks) {}

  /// A part is done by the worker that it was given.
  void NoteDone(JobRecord& job, std::uint32_t part, const std::string& checksum);
  /// Gives the comparison of this job to the next one that may make it. Before the open
  /// parts are given.
  void Give(JobRecord& job, Nanoseconds now);
  /// What becomes of the comparison of its job by this report.
  void Receive(JobRecord& job, const TaskView& task, Nanoseconds now);
  /// The worker that is at the comparison of this job is lost, or does not answer.
  void Lose(JobRecord& job, Nanoseconds now);
  /// The job ends, or begins another attempt.
  void Drop(JobRecord& job);
  /// Disarms and names what may not be engraved yet (rule 3).
  void Hold(JobRecord& job, Nanoseconds now);

  /// A comparison of what the worker has made is under way, and nobody has decided it:
  /// which, and what to do; empty: there is none.
  std::string WhyUndecided(const std::string& worker) const;

  /// Who was found wrong since the last call.
  std::vector<WrongWorker> TakeWrong() { return std::exchange(wrong_, {}); }

 private:
  std::vector<std::string> Candidates(const PartComparison& comparison) const;
  void ForgetWrong(JobRecord& job);
  /// The worker has made a part of it, and so have others, not one of them wrong.
  bool IsUndecided(const PartComparison& comparison, const std::string& worker) const;
  void TakeBack(const JobRecord& decided, const std::string& worker);
  void GiveTo(JobRecord& job, const std::string& worker, bool ahead, Nanoseconds now);
  void Reopen(JobRecord& job, Nanoseconds not_before);
  void Decide(JobRecord& job);
  void Suspect(JobRecord& job);
  void Settle(JobRecord& job);

  JobBook& book_;
  TaskHandout& tasks_;
  std::uint32_t done_count_ = 0;  // parts since the last comparison
  std::vector<WrongWorker> wrong_;
};

}  // namespace intaglio::job_service
