#pragma once

// A batch under way: submits what may begin, arms it once when the person who typed it
// asked for that, follows it, and reports at the end what became of every job. A job that
// is paused, stopped or disarmed afterwards waits for a person.

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proto/shop.pb.h"
#include "services/cli/batch/batch_jobs.h"
#include "services/cli/batch/batch_plan.h"
#include "services/cli/progress/progress_bar.h"
#include "services/client/arm_once.h"
#include "services/client/event_lines.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

struct BatchRunOptions {
  std::string file;
  std::size_t parallel = 0;  ///< 0: one a machine
  bool keep_going = false;   ///< after a job that is not good
  bool arm = false;          ///< each job, once its machine was opened after the last
  bool same_block = false;   ///< a person's statement: all go into the block that is in
  bool accept_breakage = false;  ///< the person who arms accepts that glass may break
  double pause_limit_s = 0;  ///< a job that waits for a person for longer is cancelled;
                             ///< 0: never
};

/// How a job of a batch counts in the sums.
enum class JobResult {
  kNotMade,  ///< skipped, not submitted, or left as it is
  kGood,
  kGoodWithWarnings,
  kNotGood,
  kFailed,  ///< also refused
  kCancelled,
};

class BatchRun {
 public:
  /// `events`: null for none.
  BatchRun(client::JobClient& client, std::vector<BatchJob> jobs, BatchRunOptions options,
           client::EventLines* events);

  /// Until every job has ended, or Ctrl-C: then what waits in the shop's queue or has not
  /// begun to be engraved is cancelled, and what is engraved goes on.
  BatchResults Run();
  bool interrupted() const { return interrupted_; }

 private:
  using Clock = std::chrono::steady_clock;
  /// A job that was submitted and has not ended.
  struct Out {
    std::string uid;
    Clock::time_point since;
    std::optional<client::ArmOnce> arm;
    Clock::time_point waits_since;  // for a person; zero: it does not
    std::string waits_for;          // why, and the command that ends it
    bool cancelled = false;
    Clock::time_point ended;  // seen so, not settled yet; zero: open
  };

  void Turn();
  void Submit(const BatchPlan::Start& start);
  void Follow(std::size_t job, Out& out);
  /// Why the job goes on only after a person has done something; empty when it does not.
  std::string WaitsFor(const client::JobView& view, const Out& out) const;
  void ReportWaiting(std::size_t job, const client::JobView& view, Out& out);
  void Cancel(const client::JobView& view, Out& out);
  void End(std::size_t job, const client::JobView& view);
  void Refuse(std::size_t job, const std::string& message);
  /// It is followed no further; its result keeps the state that it was in.
  void GiveUp(std::size_t job, const char* event_name, const std::string& message);
  void Settle(std::size_t job, bool good);
  /// Cancels what is out and not yet engraved.
  void CancelWaiting();
  void Leave();
  void Report(const std::string& line);
  void ShowProgress();
  void Count(BatchResults& results) const;
  BatchJobResult& result(std::size_t job) {
    return *results_.mutable_jobs(static_cast<int>(job));
  }

  client::JobClient& client_;
  std::vector<BatchJob> jobs_;
  BatchRunOptions options_;
  client::EventLines* events_;
  BatchPlan plan_;
  std::vector<JobResult> ends_;  // by job
  ProgressBar bar_;
  BatchResults results_;
  std::map<std::size_t, Out> out_;
  Clock::time_point began_ = Clock::now();
  Clock::time_point service_seen_ = Clock::now();
  bool interrupted_ = false;
};

/// The greatest of the exit codes of its jobs (docs/cli.md).
int ExitCodeOf(const BatchResults& results, bool interrupted);

/// For people: a row a job, and how many came to which end.
std::string TableOf(const BatchResults& results);

}  // namespace intaglio::cli
