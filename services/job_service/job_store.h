#pragma once

// The queue, stored: in a file of SQLite, or on a server of PostgreSQL that several
// computers reach, with the same statements and migrations (services/sql). When Keep and
// the other writing functions return, the change is durable: an accepted job survives the
// death of the process and of the machine.
//
// Tables: runs (epochs of the job service), jobs, submissions (what became of each, also
// refused ones), commands (what was asked, and what was answered: a command that is
// delivered again is answered again) and tasks (what was handed out: after a restart it
// is taken back from the worker that has it); pieces, loaded_blocks and mounts (what is
// known of the machines, records/cell_records.h: each mount stays, with who and when).
// The table of jobs is the shop's history as well (services/history). Used from one
// thread. A database that cannot be opened or written throws StoreError.

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "proto/shop.pb.h"
#include "services/job_service/job_warnings.h"
#include "services/job_service/queue/job_queue.h"
#include "services/job_service/records/cell_records.h"
#include "services/job_service/records/job_record.h"
#include "services/job_service/records/job_result.h"

namespace intaglio::sql {
class Connection;
}

namespace intaglio::job_service {

class StoreError : public std::runtime_error {
 public:
  /// `passes`: waiting may cure it (a full disk, a folder that is not mounted yet); false
  /// for a file that is not a database, or is one of a newer program.
  StoreError(const std::string& what, bool passes)
      : std::runtime_error(what), passes_(passes) {}
  bool passes() const { return passes_; }

 private:
  bool passes_;
};

/// Opens a file, which is made with its folder when there is none, or connects to a
/// server (sql::IsServerAddress). It is not owned yet (sql::Connection::TryOwn).
std::unique_ptr<sql::Connection> OpenStore(const std::string& address);

/// Commands and submissions that were refused, of a client or of a process that floods:
/// so many of each stay, and each for so long at least. A command is delivered again only
/// while its client waits for the answer, 90 s at most.
struct RefusalLimits {
  int max_count = 20'000;
  std::chrono::seconds stays{120};
  int drop_every = 1000;  ///< refusals
};

class JobStore {
 public:
  /// `owned`: TryOwn has given it to this process.
  explicit JobStore(std::unique_ptr<sql::Connection> owned);
  /// Opens and owns it; throws when another job service keeps it for some seconds.
  explicit JobStore(const std::string& address);
  JobStore(JobStore&&) noexcept;
  ~JobStore();

  /// Begins a run of the job service: its epoch is greater than every one before; as it
  /// contains the time, it is also greater than those of a database that was lost.
  std::uint64_t BeginRun();

  /// Number for the next job, from 1.
  std::uint32_t NextNumber();

  /// What became of a submission; nullopt when it is new. An empty text: it was taken.
  std::optional<std::string> OutcomeOf(const std::string& submission_uid);
  /// The job that was taken for this submission; nullopt: there is none.
  std::optional<std::string> JobOf(const std::string& submission_uid);
  /// The number of a job that was taken under a uid that begins so; nullopt: none was.
  std::optional<std::uint32_t> TakenUnder(const std::string& uid_prefix);
  void KeepRefusal(const std::string& submission_uid, const std::string& reasons);

  /// New or changed. A job's first Keep also notes its submission.
  void Keep(const JobRecord& job);
  /// The newest refused ones stay (RefusalLimits).
  void KeepAnswer(const CommandView& command, const CommandAnswer& answer);
  /// What was answered to this command of this sender; nullopt when it is new.
  std::optional<CommandAnswer> AnswerTo(const std::string& sender, std::uint64_t number);
  void KeepTask(const TaskOrder& order);
  /// The end of a task with its outcome (StageOutcome, serialized). False: it was kept
  /// before, or the task was never given to this worker.
  bool KeepTaskEnd(const TaskView& task, const std::string& outcome);
  /// What the discretizers and the sorter have reported of this attempt, by part.
  AttemptOutcomes OutcomesOf(const std::string& job_uid, std::uint32_t attempt);

  /// What was known of a job when it ended, before the outcome of its engraving.
  struct LastKnown {
    intaglio_PointCounts
        counts{};        ///< of its newest status; all 0: none, or as kept before
    bool is_all = true;  ///< nothing more is expected
  };
  /// Counts and verdict of a job that has ended, by the outcome of its engraving, which
  /// may come after the end; before it counts by `last`, and a verdict only if that is
  /// all. Nothing of a job that is open. `report`, `recording`: as in JobStatistics.
  void KeepVerdict(const std::string& job_uid, const std::string& report,
                   const std::string& recording, const LastKnown& last);
  void KeepVerdict(const std::string& job_uid, const std::string& report,
                   const std::string& recording) {
    KeepVerdict(job_uid, report, recording, LastKnown());
  }
  /// What KeepVerdict has kept; nothing for a job that is not there.
  JobResult ResultOf(const std::string& job_uid);
  /// The statistics of a job that was kept, as it is now.
  JobStatistics StatisticsOf(const JobRecord& job,
                             std::chrono::system_clock::time_point now);

  /// What machines have: a piece replaces that of its machine, a block stays with the job
  /// that it was loaded for first, and every mount is kept.
  void KeepPiece(const PieceRecord& piece);
  std::vector<PieceRecord> LoadPieces();
  void KeepLoadedBlock(const LoadedBlock& block);
  std::vector<LoadedBlock> LoadLoadedBlocks();
  void KeepMount(const MountRecord& mount);
  /// The newest of each machine.
  std::vector<MountRecord> LoadMounts();

  /// Without a reason the worker is removed. What has changed is kept for the history.
  void KeepLeftOut(const LeftOut& worker);
  std::vector<LeftOut> LoadLeftOut();

  /// All open jobs, with the parts that are handed out, and the newest `ended_count`
  /// ended ones, without their frozen jobs, by number. Reads these rows alone, however
  /// many have ended.
  std::vector<JobRecord> Load(std::size_t ended_count);
  /// As Load, one that has ended; nullopt when it has not.
  std::optional<JobRecord> LoadEnded(const std::string& job_uid);

  void Limit(const RefusalLimits& refusals) { refusals_ = refusals; }

  /// A line beside the queue that is not durable, of a job service that runs
  /// (last_seen.h).
  std::string Note();
  void KeepNote(const std::string& text);

 private:
  void Migrate();
  void FillInHistory();
  /// `refused`: the condition of a row of `table`.
  void NoteRefusal(const char* table, const char* refused, int& since_drop);
  std::unique_ptr<sql::Connection> database_;
  RefusalLimits refusals_;
  int refused_commands_ = 0, refused_submissions_ = 0;  // since the last were dropped
};

}  // namespace intaglio::job_service
