#include "services/job_service/job_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "services/job/verdict/warnings.h"
#include "services/job_service/store_guard.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::job_service {
namespace {

// More revisions than can have been published without being kept: progress ten times a
// second for a month. Readers only check whether a revision is newer.
constexpr std::uint64_t kRevisionLeap = 1u << 25;

void KeepStages(sql::Connection& database, const JobRecord& job) {
  const auto insert = database.Prepare(
      "INSERT INTO stages (job_uid, stage, worker, done, done_count, total_count, "
      "elapsed_s) "
      "VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT (job_uid, stage) DO UPDATE SET "
      "worker = excluded.worker, done = excluded.done, "
      "done_count = excluded.done_count, total_count = excluded.total_count, "
      "elapsed_s = excluded.elapsed_s");
  for (const intaglio_Stage stage : kStages) {
    const StageRecord& record = job.stage(stage);
    insert->Bind(1, job.uid);
    insert->Bind(2, static_cast<int>(stage));
    insert->Bind(3, record.worker);
    insert->Bind(4, record.done ? 1 : 0);
    insert->Bind(5, Signed(record.done_count));
    insert->Bind(6, Signed(record.total_count));
    insert->Bind(7, record.elapsed_s);
    insert->Execute();
    insert->Reset();
  }
}

void LoadStages(sql::Connection& database, JobRecord& job) {
  const auto select = database.Prepare(
      "SELECT stage, worker, done, done_count, total_count, elapsed_s "
      "FROM stages WHERE job_uid = ?");
  select->Bind(1, job.uid);
  while (select->Step()) {
    StageRecord& record = job.stages.at(static_cast<std::size_t>(select->Integer(0)));
    record.worker = select->Text(1);
    record.done = select->Integer(2) != 0;
    record.done_count = static_cast<std::uint64_t>(select->Integer(3));
    record.total_count = static_cast<std::uint64_t>(select->Integer(4));
    record.elapsed_s = select->Real(5);
  }
}

void LoadParts(sql::Connection& database, JobRecord& job) {
  const auto select = database.Prepare(
      "SELECT part, part_attempt, worker FROM tasks WHERE job_uid = ? AND attempt = ? "
      "AND stage = ? AND part_attempt < ? AND ended_utc IS NULL AND revoked_utc IS NULL");
  select->Bind(1, job.uid);
  select->Bind(2, job.attempt);
  select->Bind(3, static_cast<int>(intaglio_STAGE_DISCRETIZE));
  select->Bind(4, host::kMaxPartAttempts);  // comparisons end with their job service
  while (select->Step()) {
    const auto part = static_cast<std::uint32_t>(select->Integer(0));
    job.parts.Restore(part, static_cast<std::uint32_t>(select->Integer(1)),
                      select->Text(2));
  }
}

// An open job has all of them; an ended one is loaded without its frozen job.
constexpr const char* kColumns =
    "number, uid, submission_uid, epoch, name, cell, material, priority, turn, "
    "rate_hz, "
    "result_directory, state, attempt, lost_attempts, message, estimate_ticks, "
    "first_estimate_ticks, revision, "
    "last_command, ever_granted, armed, operator_name, first_point, fire_uncertain, "
    "asks_before_resume, disarm_count, disarm_reason, last_command_id, pause_reason, "
    "warnings, breakage_accepted_by, makes, block_id";

JobRecord RecordOf(sql::Statement& row) {
  JobRecord job;
  const auto u64 = [&row](const char* column) {
    return static_cast<std::uint64_t>(row.Integer(column));
  };
  const auto u32 = [&row](const char* column) {
    return static_cast<std::uint32_t>(row.Integer(column));
  };
  const auto text = [&row](const char* column) { return row.Text(column); };
  job.number = u32("number");
  job.uid = text("uid");
  job.submission_uid = text("submission_uid");
  job.epoch = u64("epoch");
  job.name = text("name");
  job.cell = text("cell");
  job.material = text("material");
  job.makes = text("makes");
  job.priority = static_cast<int>(row.Integer("priority"));
  job.turn = row.Integer("turn");
  job.rate_hz = row.Real("rate_hz");
  job.result_directory = text("result_directory");
  job.state = static_cast<intaglio_JobState>(row.Integer("state"));
  job.attempt = u32("attempt");
  job.lost_attempts = u32("lost_attempts");
  job.message = text("message");
  job.estimate_ticks = u64("estimate_ticks");
  job.first_estimate_ticks = u64("first_estimate_ticks");
  job.revision = u64("revision") + kRevisionLeap;
  KeptArm arm;
  arm.armed = row.Integer("armed") != 0;
  arm.ever_granted = row.Integer("ever_granted") != 0;
  arm.asks_before_resume = row.Integer("asks_before_resume") != 0;
  arm.disarm_count = u64("disarm_count");
  arm.disarm_reason = text("disarm_reason");
  arm.operator_name = text("operator_name");
  arm.first_point = u32("first_point");
  arm.fire_uncertain = row.Integer("fire_uncertain") != 0;
  arm.last_command = u64("last_command");
  arm.last_command_id = text("last_command_id");
  arm.breakage_accepted_by = text("breakage_accepted_by");
  arm.block_id = text("block_id");
  job.arm = JobArm(std::move(arm));
  job.warnings = WarningsOfBytes(text("warnings"));
  job.pause_reason = static_cast<intaglio_PauseReason>(row.Integer("pause_reason"));
  return job;
}

void LoadOpen(sql::Connection& database, std::vector<JobRecord>& jobs) {
  const auto select =
      database.Prepare(fmt::format("SELECT {}, frozen_job FROM jobs WHERE ended = 0 "
                                   "ORDER BY number",
                                   kColumns));
  while (select->Step()) {
    JobRecord& job = jobs.emplace_back(RecordOf(*select));
    job.frozen_job = select->Text("frozen_job");
    LoadStages(database, job);
    if (job.active()) LoadParts(database, job);
  }
}

/// Rows that `select`, over kColumns, gives.
void LoadEndedOf(sql::Connection& database, sql::Statement& select,
                 std::vector<JobRecord>& jobs) {
  while (select.Step()) {
    jobs.push_back(RecordOf(select));
    LoadStages(database, jobs.back());
  }
}

}  // namespace

std::uint32_t JobStore::NextNumber() {
  return Guarded(*database_, [this] {
    return static_cast<std::uint32_t>(
        sql::IntegerOf(*database_, "SELECT coalesce(max(number), 0) + 1 FROM jobs"));
  });
}

std::optional<std::string> JobStore::OutcomeOf(const std::string& submission_uid) {
  return Guarded(*database_, [&]() -> std::optional<std::string> {
    const auto select =
        database_->Prepare("SELECT refusal FROM submissions WHERE submission_uid = ?");
    select->Bind(1, submission_uid);
    if (!select->Step()) return {};
    return select->Text(0);
  });
}

std::optional<std::string> JobStore::JobOf(const std::string& submission_uid) {
  return Guarded(*database_, [&]() -> std::optional<std::string> {
    const auto select =
        database_->Prepare("SELECT uid FROM jobs WHERE submission_uid = ?");
    select->Bind(1, submission_uid);
    if (!select->Step()) return {};
    return select->Text(0);
  });
}

// The index of the primary key is searched: a text that begins so is at or after the
// prefix, and before the prefix with a last byte behind all texts.
std::optional<std::uint32_t> JobStore::TakenUnder(const std::string& uid_prefix) {
  return Guarded(*database_, [&]() -> std::optional<std::uint32_t> {
    const auto select = database_->Prepare(
        "SELECT j.number FROM submissions AS s JOIN jobs AS j "
        "ON j.submission_uid = s.submission_uid "
        "WHERE s.submission_uid >= ?1 AND s.submission_uid < ?2 LIMIT 1");
    select->Bind(1, uid_prefix);
    select->Bind(2, uid_prefix + '\x7f');
    if (!select->Step()) return {};
    return static_cast<std::uint32_t>(select->Integer(0));
  });
}

void JobStore::KeepRefusal(const std::string& submission_uid,
                           const std::string& reasons) {
  Guarded(*database_, [&] {
    const auto insert = database_->Prepare(
        "INSERT INTO submissions VALUES (?, ?, ?) ON CONFLICT DO NOTHING");
    insert->Bind(1, submission_uid);
    insert->Bind(2, reasons);
    insert->Bind(3, NowUtc());
    insert->Execute();
    if (reasons.empty()) return;  // it was taken
    NoteRefusal("submissions", "refusal <> ''", refused_submissions_);
  });
}

void JobStore::Keep(const JobRecord& job) {
  Guarded(*database_, [&] {
    sql::Transaction transaction(*database_);
    KeepRefusal(job.submission_uid, "");
    const auto insert = database_->Prepare(
        "INSERT INTO jobs (number, uid, submission_uid, epoch, name, cell, rate_hz, "
        "result_directory, frozen_job, state, ended, attempt, lost_attempts, "
        "message, "
        "estimate_ticks, revision, last_command, ever_granted, priority, material, "
        "armed, operator_name, asks_before_resume, first_point, "
        "fire_uncertain, disarm_count, disarm_reason, last_command_id, pause_reason, "
        "warnings, breakage_accepted_by, first_estimate_ticks, makes, block_id, "
        "changed_utc, "
        "ended_utc, turn) "
        "VALUES "
        "(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, "
        "?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23, ?24, "
        "?25, ?26, ?27, ?28, ?29, ?30, ?31, ?32, ?33, ?34, "
        "?35, "
        "CASE ?11 WHEN 1 THEN ?35 ELSE '' END, ?36) "
        "ON CONFLICT (number) DO UPDATE SET state = excluded.state, "
        "ended = excluded.ended, attempt = excluded.attempt, "
        "lost_attempts = excluded.lost_attempts, message = excluded.message, "
        "estimate_ticks = excluded.estimate_ticks, revision = excluded.revision, "
        "last_command = excluded.last_command, "
        "ever_granted = excluded.ever_granted, armed = excluded.armed, "
        "operator_name = excluded.operator_name, first_point = excluded.first_point, "
        "fire_uncertain = excluded.fire_uncertain, "
        "disarm_count = excluded.disarm_count, "
        "disarm_reason = excluded.disarm_reason, "
        "last_command_id = excluded.last_command_id, "
        "pause_reason = excluded.pause_reason, "
        "warnings = excluded.warnings, "
        "breakage_accepted_by = excluded.breakage_accepted_by, "
        "first_estimate_ticks = excluded.first_estimate_ticks, "
        "block_id = excluded.block_id, "
        "priority = excluded.priority, turn = excluded.turn, "
        "changed_utc = excluded.changed_utc, "
        // The first time stays.
        "started_utc = CASE WHEN jobs.started_utc = '' AND excluded.attempt > 0 THEN "
        "excluded.changed_utc ELSE jobs.started_utc END, "
        "engraving_utc = CASE WHEN jobs.engraving_utc = '' AND excluded.ever_granted = 1 "
        "THEN "
        "excluded.changed_utc ELSE jobs.engraving_utc END, "
        "ended_utc = CASE WHEN jobs.ended_utc = '' THEN excluded.ended_utc ELSE "
        "jobs.ended_utc "
        "END");
    const KeptArm arm = job.arm.ToKeep();
    insert->Bind(1, job.number);
    insert->Bind(2, job.uid);
    insert->Bind(3, job.submission_uid);
    insert->Bind(4, Signed(job.epoch));
    insert->Bind(5, job.name);
    insert->Bind(6, job.cell);
    insert->Bind(7, job.rate_hz);
    insert->Bind(8, job.result_directory);
    insert->BindBytes(9, job.frozen_job);
    insert->Bind(10, static_cast<int>(job.state));
    insert->Bind(11, job.ended() ? 1 : 0);
    insert->Bind(12, job.attempt);
    insert->Bind(13, job.lost_attempts);
    insert->Bind(14, job.message);
    insert->Bind(15, Signed(job.estimate_ticks));
    insert->Bind(16, Signed(job.revision));
    insert->Bind(17, Signed(arm.last_command));
    insert->Bind(18, arm.ever_granted ? 1 : 0);
    insert->Bind(19, job.priority);
    insert->Bind(20, job.material);
    insert->Bind(21, arm.armed ? 1 : 0);
    insert->Bind(22, arm.operator_name);
    insert->Bind(23, arm.asks_before_resume ? 1 : 0);
    insert->Bind(24, arm.first_point);
    insert->Bind(25, arm.fire_uncertain ? 1 : 0);
    insert->Bind(26, Signed(arm.disarm_count));
    insert->Bind(27, arm.disarm_reason);
    insert->Bind(28, arm.last_command_id);
    insert->Bind(29, static_cast<int>(job.pause_reason));
    const std::string warnings = BytesOf(job.warnings);
    insert->BindBytes(30, warnings);
    insert->Bind(31, arm.breakage_accepted_by);
    insert->Bind(32, Signed(job.first_estimate_ticks));
    insert->Bind(33, job.makes);
    insert->Bind(34, arm.block_id);
    insert->Bind(35, NowUtc());
    insert->Bind(36, job.turn);
    insert->Execute();
    KeepStages(*database_, job);
    transaction.Commit();
  });
}

// Two searches of the index jobs_ended: one for both would read the whole table.
std::vector<JobRecord> JobStore::Load(std::size_t ended_count) {
  return Guarded(*database_, [&] {
    std::vector<JobRecord> jobs;
    LoadOpen(*database_, jobs);
    const auto select =
        database_->Prepare(fmt::format("SELECT {} FROM jobs WHERE ended = 1 "
                                       "ORDER BY number DESC LIMIT ?",
                                       kColumns));
    select->Bind(1, Signed(ended_count));
    LoadEndedOf(*database_, *select, jobs);
    std::sort(jobs.begin(), jobs.end(),
              [](const JobRecord& a, const JobRecord& b) { return a.number < b.number; });
    return jobs;
  });
}

std::optional<JobRecord> JobStore::LoadEnded(const std::string& job_uid) {
  return Guarded(*database_, [&]() -> std::optional<JobRecord> {
    const auto select = database_->Prepare(
        fmt::format("SELECT {} FROM jobs WHERE uid = ? AND ended = 1", kColumns));
    select->Bind(1, job_uid);
    std::vector<JobRecord> jobs;
    LoadEndedOf(*database_, *select, jobs);
    if (jobs.empty()) return {};
    return std::move(jobs.front());
  });
}

}  // namespace intaglio::job_service
