#pragma once

// The job service on the bus: takes submissions and commands, hands out tasks, follows
// the workers, publishes what becomes of every job. Its decisions are in
// queue/job_queue.h, its storage is in job_store.h. Used from one thread; a turn never
// waits for another process.

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "services/job_service/cells/interlock_watch.h"
#include "services/job_service/command_inbox.h"
#include "services/job_service/job_store.h"
#include "services/job_service/last_seen.h"
#include "services/job_service/model_feed.h"
#include "services/job_service/permission_keeper.h"
#include "services/job_service/published/status_board.h"
#include "services/job_service/queue/job_queue.h"
#include "services/job_service/statistics_writer.h"
#include "services/job_service/submission_reader.h"
#include "services/job_service/unsettled_ends.h"
#include "services/job_service/worker_reports.h"
#include "services/platform/bus/bus.h"
#include "services/platform/host/process/service_host.h"

namespace intaglio::job_service {

struct JobServiceOptions {
  std::string database;  ///< the queue: a file, made when it is not there, or a server
  bool standby = false;  ///< waits while another job service has the queue of a server
  std::filesystem::path materials;  ///< the material base
  std::filesystem::path results;    ///< a job's results go to results/<job_uid>/
  /// Where every topic is recorded: what the history names for a job that has no
  /// recording of its own. Empty: nowhere.
  std::filesystem::path recording;
};

class JobService : private JobActions {
 public:
  /// Throws StoreError when the store refuses. `board` outlives this. `standby`: what
  /// this process has seen of the one before it, if it stood by.
  JobService(host::ServiceHost& host, const JobServiceOptions& options, JobStore store,
             const std::optional<SeenByStandby>& standby, StatusBoard& board,
             Nanoseconds now);
  ~JobService() override;

  /// `now`: time since the machine was switched on, in which it may have slept.
  void Turn(Nanoseconds now);
  /// A person ends this process, and with it every arm.
  void Close(Nanoseconds now);
  /// Living workers that are left out or slow, and why.
  std::map<std::string, std::string> LeftOutNow() const { return queue_.LeftOutNow(); }
  /// For clients that watch the jobs: the last samples before the queue is read again.
  void PublishFault(const std::string& why);

  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(submissions_);
    loop.Attach(manual_commands_);
    commands_.AttachTo(loop);
    reports_.AttachTo(loop);
  }

 private:
  void Changed(const JobRecord& job) override;
  void Progressed(const JobRecord& job) override;
  void Give(const TaskOrder& order, const JobRecord& job) override;
  void StopFeed(const std::string& job_uid) override;
  void Forgotten(const JobRecord& job) override;
  void WorkerForgotten(const std::string& instance) override;
  void PieceChanged(const PieceRecord& piece) override;
  void BlockLoaded(const LoadedBlock& block) override;
  void LeftOutChanged(const LeftOut& worker) override;

  void StartFeed(const TaskOrder& order, const JobRecord& job);
  /// The topics of a job's machine.
  void OpenCell(const std::string& cell);
  void TakeTasks(Nanoseconds now);
  /// The job's warnings, if the end of this task of its running attempt has changed them.
  std::optional<Warnings> WarningsAfter(const TaskView& view, const JobRecord& job);
  void TakeHealth(Nanoseconds now);
  void TakeSubmissions(Nanoseconds now);
  /// A machine that a person moves by hand needs a permission, though it has no job.
  void TakeManualCommands();
  CommandAnswer TakeCommand(const CommandView& command, Nanoseconds now);
  /// Kept with who and when before it has an effect.
  CommandAnswer Mount(const CommandView& command, Nanoseconds now);
  void Submit(const intaglio_JobSubmission& submission, const std::string& process,
              Nanoseconds now);
  /// Another job was taken under the key of this submission; nullopt: none was.
  std::optional<std::string> WhyKeyIsTaken(const std::string& uid);
  /// Publishes the job of a submission that was taken before, so that its client sees it.
  void Recall(const std::string& submission_uid, Nanoseconds now);
  void Accept(const SubmissionReader::Answer& submission, FrozenJob frozen);
  void Refuse(const std::string& submission_uid, const std::string& reasons,
              Nanoseconds now);
  void Publish(const JobRecord& job);
  /// Keeps and publishes the end of a job.
  void Settle(const JobRecord& job, bool more_is_expected);
  std::set<std::string> CellsInUse() const;
  void ReportRemarks();

  host::ServiceHost& host_;
  JobServiceOptions options_;
  JobStore store_;
  SubmissionReader reader_;
  StatisticsWriter statistics_;
  std::uint64_t epoch_;

  bus::Reader<intaglio_JobSubmission> submissions_;
  bus::Reader<intaglio_ManualCommand> manual_commands_;
  CommandInbox commands_;
  WorkerReports reports_;
  StatusBoard& board_;
  bus::Writer<intaglio_StageTask> discretize_tasks_;
  bus::Writer<intaglio_StageTask> sort_tasks_;
  bus::Writer<intaglio_StageTask> engrave_tasks_;
  PermissionKeeper permissions_;
  InterlockWatch interlocks_;
  LastSeen seen_;
  ModelFeed feed_;
  JobQueue queue_;
  UnsettledEnds unsettled_;
  Nanoseconds now_;                        // of this turn
  std::vector<std::string> remarks_;       ///< in the health of this process
  Nanoseconds next_drop_log_{0};           ///< of submissions
  EndedList refusals_{0, kRememberedFor};  ///< answers to submissions
  EndedList recalls_{0, kRememberedFor};  ///< jobs that are on the bus for such an answer
  std::map<std::string, std::string> recalled_;  ///< the same with their submissions
};

}  // namespace intaglio::job_service
