#include "tests/services/job_service/past_jobs.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include "services/job_service/job_store.h"

namespace intaglio::job_service {
namespace {

// {0} count, {1} bytes of a frozen job, {2} STAGE_ENGRAVE, {3} JOB_DONE, {4} TASK_DONE.
constexpr char kPast[] = R"sql(
CREATE TEMP TABLE past AS WITH RECURSIVE n(i) AS
  (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {0}) SELECT i, i || '-abc' AS uid,
  strftime('%Y-%m-%dT%H:%M:%fZ', '2020-01-01', '+' || i || ' minutes') AS utc FROM n;
INSERT INTO jobs (number, uid, submission_uid, epoch, name, cell, rate_hz,
  result_directory, frozen_job, state, ended, attempt, lost_attempts, message,
  estimate_ticks, revision, last_command, ever_granted, changed_utc, material,
  started_utc, engraving_utc, ended_utc, verdict, planned_count, made_count, used_ticks,
  report, recording)
  SELECT i, uid, 's' || i, 1, 'piece ' || i, 'els-03', 200, '/var/lib/jobs/' || uid,
  randomblob({1}), {3}, 1, 1, 0, '', 60000, 40, 2, 1, utc, 'N-BK7', utc, utc, utc, 'good',
  30000, 30000, 60000, '/var/lib/jobs/' || uid || '/report.json', '' FROM past;
INSERT INTO submissions SELECT 's' || i, '', utc FROM past;
INSERT INTO stages SELECT uid, stage, 'worker-host-1234-abcdef', 1, 30000, 30000, 10.5
  FROM past, (SELECT 0 AS stage UNION ALL SELECT 1 UNION ALL SELECT {2});
INSERT INTO tasks (job_uid, attempt, stage, part, part_attempt, worker, given_utc,
  ended_utc, state, message, outcome)
  SELECT uid, 1, stage, 0, 0, 'worker-host-1234-abcdef', utc, utc, {4}, '',
  randomblob(100)
  FROM past, (SELECT 0 AS stage UNION ALL SELECT 1 UNION ALL SELECT {2});
INSERT INTO commands (sender, number, job_uid, kind, operator_name, code, message,
  taken_utc) SELECT 'client-' || i, 1, uid, 0, 'ann@shop', 0, '', utc FROM past;
DROP TABLE past;
)sql";

}  // namespace

void AddPastJobs(const std::filesystem::path& database, std::uint32_t count,
                 std::uint32_t frozen_bytes) {
  { JobStore made(database); }
  SQLite::Database past(database.string(), SQLite::OPEN_READWRITE);
  // A log beside it would take as much again, and a test has no power failure.
  past.exec("PRAGMA journal_mode = OFF");
  past.exec("PRAGMA synchronous = OFF");
  SQLite::Transaction transaction(past);
  past.exec(fmt::format(
      kPast, count, frozen_bytes, static_cast<int>(intaglio_STAGE_ENGRAVE),
      static_cast<int>(intaglio_JOB_DONE), static_cast<int>(intaglio_TASK_DONE)));
  transaction.commit();
}

}  // namespace intaglio::job_service
