#include "services/job_service/job_store.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "services/history/job_database.h"
#include "services/history/job_history.h"
#include "services/job/verdict/warnings.h"
#include "services/job_service/job_migrations.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {
namespace {

// More revisions than can have been published without being kept: progress ten times a
// second for a month. Readers only check whether a revision is newer.
constexpr std::uint64_t kRevisionLeap = 1u << 25;

static_assert(kMigrations.size() == history::kJobDatabaseVersion);

std::unique_ptr<SQLite::Database> Open(const std::filesystem::path& path) {
  if (const auto intact = history::CheckQueue(path); !intact) {
    throw StoreError(intact.error().message, intact.error().code == ErrorCode::kIo);
  }
  std::error_code ignored;
  std::filesystem::create_directories(path.parent_path(), ignored);
  try {
    auto database = std::make_unique<SQLite::Database>(
        path.string(), SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE, 2000);
    database->exec("PRAGMA journal_mode = WAL");
    database->exec("PRAGMA synchronous = FULL");
    database->exec("PRAGMA foreign_keys = ON");
    return database;
  } catch (const SQLite::Exception& error) {
    throw ErrorOf(path.string(), error);
  }
}

void KeepStages(SQLite::Database& database, const JobRecord& job) {
  SQLite::Statement insert(database,
                           "INSERT OR REPLACE INTO stages VALUES (?, ?, ?, ?, ?, ?, ?)");
  for (const intaglio_Stage stage : kStages) {
    const StageRecord& record = job.stage(stage);
    insert.bind(1, job.uid);
    insert.bind(2, static_cast<int>(stage));
    insert.bind(3, record.worker);
    insert.bind(4, record.done ? 1 : 0);
    insert.bind(5, Signed(record.done_count));
    insert.bind(6, Signed(record.total_count));
    insert.bind(7, record.elapsed_s);
    insert.exec();
    insert.reset();
  }
}

void LoadStages(SQLite::Database& database, JobRecord& job) {
  SQLite::Statement select(
      database,
      "SELECT stage, worker, done, done_count, total_count, elapsed_s "
      "FROM stages WHERE job_uid = ?");
  select.bind(1, job.uid);
  while (select.executeStep()) {
    StageRecord& record =
        job.stages.at(static_cast<std::size_t>(select.getColumn(0).getInt()));
    record.worker = select.getColumn(1).getString();
    record.done = select.getColumn(2).getInt() != 0;
    record.done_count = static_cast<std::uint64_t>(select.getColumn(3).getInt64());
    record.total_count = static_cast<std::uint64_t>(select.getColumn(4).getInt64());
    record.elapsed_s = select.getColumn(5).getDouble();
  }
}

void LoadParts(SQLite::Database& database, JobRecord& job) {
  SQLite::Statement select(
      database,
      "SELECT part, part_attempt, worker FROM tasks WHERE job_uid = ? AND attempt = ? "
      "AND stage = ? AND ended_utc IS NULL AND revoked_utc IS NULL");
  select.bind(1, job.uid);
  select.bind(2, job.attempt);
  select.bind(3, static_cast<int>(intaglio_STAGE_DISCRETIZE));
  while (select.executeStep()) {
    const std::uint32_t part = select.getColumn(0).getUInt();
    job.parts.Restore(part, select.getColumn(1).getUInt(),
                      select.getColumn(2).getString());
  }
}

// An open job has all of them; an ended one is loaded without its frozen job.
constexpr const char* kColumns =
    "number, uid, submission_uid, epoch, name, cell, material, priority, rate_hz, "
    "result_directory, state, attempt, lost_attempts, message, estimate_ticks, "
    "first_estimate_ticks, revision, "
    "last_command, ever_granted, armed, operator_name, first_point, fire_uncertain, "
    "asks_before_resume, disarm_count, disarm_reason, last_command_id, pause_reason, "
    "warnings, breakage_accepted_by, makes, block_id";

JobRecord RecordOf(SQLite::Statement& row) {
  JobRecord job;
  const auto u64 = [&row](const char* column) {
    return static_cast<std::uint64_t>(row.getColumn(column).getInt64());
  };
  const auto u32 = [&row](const char* column) { return row.getColumn(column).getUInt(); };
  const auto text = [&row](const char* column) {
    return row.getColumn(column).getString();
  };
  job.number = u32("number");
  job.uid = text("uid");
  job.submission_uid = text("submission_uid");
  job.epoch = u64("epoch");
  job.name = text("name");
  job.cell = text("cell");
  job.material = text("material");
  job.makes = text("makes");
  job.priority = row.getColumn("priority").getInt();
  job.rate_hz = row.getColumn("rate_hz").getDouble();
  job.result_directory = text("result_directory");
  job.state = static_cast<intaglio_JobState>(row.getColumn("state").getInt());
  job.attempt = u32("attempt");
  job.lost_attempts = u32("lost_attempts");
  job.message = text("message");
  job.estimate_ticks = u64("estimate_ticks");
  job.first_estimate_ticks = u64("first_estimate_ticks");
  job.revision = u64("revision") + kRevisionLeap;
  KeptArm arm;
  arm.armed = row.getColumn("armed").getInt() != 0;
  arm.ever_granted = row.getColumn("ever_granted").getInt() != 0;
  arm.asks_before_resume = row.getColumn("asks_before_resume").getInt() != 0;
  arm.disarm_count = u64("disarm_count");
  arm.disarm_reason = text("disarm_reason");
  arm.operator_name = text("operator_name");
  arm.first_point = u32("first_point");
  arm.fire_uncertain = row.getColumn("fire_uncertain").getInt() != 0;
  arm.last_command = u64("last_command");
  arm.last_command_id = text("last_command_id");
  arm.breakage_accepted_by = text("breakage_accepted_by");
  arm.block_id = text("block_id");
  job.arm = JobArm(std::move(arm));
  job.warnings = WarningsOfBytes(text("warnings"));
  job.pause_reason =
      static_cast<intaglio_PauseReason>(row.getColumn("pause_reason").getInt());
  return job;
}

void LoadOpen(SQLite::Database& database, std::vector<JobRecord>& jobs) {
  SQLite::Statement select(database,
                           fmt::format("SELECT {}, frozen_job FROM jobs WHERE ended = 0 "
                                       "ORDER BY number",
                                       kColumns));
  while (select.executeStep()) {
    JobRecord& job = jobs.emplace_back(RecordOf(select));
    job.frozen_job = select.getColumn("frozen_job").getString();
    LoadStages(database, job);
    if (job.active()) LoadParts(database, job);
  }
}

/// Rows that `select`, over kColumns, gives.
void LoadEndedOf(SQLite::Database& database, SQLite::Statement& select,
                 std::vector<JobRecord>& jobs) {
  while (select.executeStep()) {
    jobs.push_back(RecordOf(select));
    LoadStages(database, jobs.back());
  }
}

}  // namespace

JobStore::JobStore(const std::filesystem::path& path) : database_(Open(path)) {
  Migrate();
}

JobStore::~JobStore() = default;

void JobStore::Migrate() {
  Guarded(*database_, [this] {
    const int version = database_->execAndGet("PRAGMA user_version").getInt();
    const int newest = static_cast<int>(kMigrations.size());
    for (int next = version; next < newest; ++next) {
      SQLite::Transaction transaction(*database_);
      database_->exec(kMigrations.at(static_cast<std::size_t>(next)));
      database_->exec(fmt::format("PRAGMA user_version = {}", next + 1));
      transaction.commit();
    }
    if (version > 0 && version < history::kHistoryVersion) FillInHistory();
  });
}

std::uint64_t JobStore::BeginRun() {
  return Guarded(*database_, [this] {
    using std::chrono::seconds;
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    // Seconds and 16 random bits: two databases started in one second differ as well.
    const std::int64_t fresh = std::chrono::duration_cast<seconds>(now).count() << 16 |
                               (std::random_device()() & 0xffff);
    SQLite::Transaction transaction(*database_);
    const std::int64_t last =
        database_->execAndGet("SELECT coalesce(max(epoch), 0) FROM runs").getInt64();
    const std::int64_t epoch = std::max(fresh, last + 1);
    SQLite::Statement insert(*database_,
                             fmt::format("INSERT INTO runs VALUES (?, {})", kNow));
    insert.bind(1, epoch);
    insert.exec();
    transaction.commit();
    return static_cast<std::uint64_t>(epoch);
  });
}

std::uint32_t JobStore::NextNumber() {
  return Guarded(*database_, [this] {
    return database_->execAndGet("SELECT coalesce(max(number), 0) + 1 FROM jobs")
        .getUInt();
  });
}

std::optional<std::string> JobStore::OutcomeOf(const std::string& submission_uid) {
  return Guarded(*database_, [&]() -> std::optional<std::string> {
    SQLite::Statement select(*database_,
                             "SELECT refusal FROM submissions WHERE submission_uid = ?");
    select.bind(1, submission_uid);
    if (!select.executeStep()) return {};
    return select.getColumn(0).getString();
  });
}

std::optional<std::string> JobStore::JobOf(const std::string& submission_uid) {
  return Guarded(*database_, [&]() -> std::optional<std::string> {
    SQLite::Statement select(*database_, "SELECT uid FROM jobs WHERE submission_uid = ?");
    select.bind(1, submission_uid);
    if (!select.executeStep()) return {};
    return select.getColumn(0).getString();
  });
}

// The index of the primary key is searched: a text that begins so is at or after the
// prefix, and before the prefix with a last byte behind all texts.
std::optional<std::uint32_t> JobStore::TakenUnder(const std::string& uid_prefix) {
  return Guarded(*database_, [&]() -> std::optional<std::uint32_t> {
    SQLite::Statement select(
        *database_,
        "SELECT j.number FROM submissions AS s JOIN jobs AS j "
        "ON j.submission_uid = s.submission_uid "
        "WHERE s.submission_uid >= ?1 AND s.submission_uid < ?1 || x'7f' LIMIT 1");
    select.bind(1, uid_prefix);
    if (!select.executeStep()) return {};
    return select.getColumn(0).getUInt();
  });
}

void JobStore::KeepRefusal(const std::string& submission_uid,
                           const std::string& reasons) {
  Guarded(*database_, [&] {
    SQLite::Statement insert(
        *database_,
        fmt::format("INSERT OR IGNORE INTO submissions VALUES (?, ?, {})", kNow));
    insert.bind(1, submission_uid);
    insert.bind(2, reasons);
    insert.exec();
  });
}

void JobStore::Keep(const JobRecord& job) {
  Guarded(*database_, [&] {
    SQLite::Transaction transaction(*database_);
    KeepRefusal(job.submission_uid, "");
    SQLite::Statement insert(
        *database_,
        fmt::format(
            "INSERT INTO jobs (number, uid, submission_uid, epoch, name, cell, rate_hz, "
            "result_directory, frozen_job, state, ended, attempt, lost_attempts, "
            "message, "
            "estimate_ticks, revision, last_command, ever_granted, priority, material, "
            "armed, operator_name, asks_before_resume, first_point, "
            "fire_uncertain, disarm_count, disarm_reason, last_command_id, pause_reason, "
            "warnings, breakage_accepted_by, first_estimate_ticks, makes, block_id, "
            "changed_utc, "
            "ended_utc) "
            "VALUES "
            "(?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, "
            "?11, ?12, ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23, ?24, "
            "?25, ?26, ?27, ?28, ?29, ?30, ?31, ?32, ?33, ?34, "
            "{0}, "
            "CASE ?11 WHEN 1 THEN {0} ELSE '' END) "
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
            "changed_utc = excluded.changed_utc, "
            // The first time stays.
            "started_utc = CASE WHEN started_utc = '' AND excluded.attempt > 0 THEN "
            "excluded.changed_utc ELSE started_utc END, "
            "engraving_utc = CASE WHEN engraving_utc = '' AND excluded.ever_granted = 1 "
            "THEN "
            "excluded.changed_utc ELSE engraving_utc END, "
            "ended_utc = CASE WHEN ended_utc = '' THEN excluded.ended_utc ELSE ended_utc "
            "END",
            kNow));
    const KeptArm arm = job.arm.ToKeep();
    insert.bind(1, job.number);
    insert.bind(2, job.uid);
    insert.bind(3, job.submission_uid);
    insert.bind(4, Signed(job.epoch));
    insert.bind(5, job.name);
    insert.bind(6, job.cell);
    insert.bind(7, job.rate_hz);
    insert.bind(8, job.result_directory);
    insert.bind(9, job.frozen_job.data(), static_cast<int>(job.frozen_job.size()));
    insert.bind(10, static_cast<int>(job.state));
    insert.bind(11, job.ended() ? 1 : 0);
    insert.bind(12, job.attempt);
    insert.bind(13, job.lost_attempts);
    insert.bind(14, job.message);
    insert.bind(15, Signed(job.estimate_ticks));
    insert.bind(16, Signed(job.revision));
    insert.bind(17, Signed(arm.last_command));
    insert.bind(18, arm.ever_granted ? 1 : 0);
    insert.bind(19, job.priority);
    insert.bind(20, job.material);
    insert.bind(21, arm.armed ? 1 : 0);
    insert.bind(22, arm.operator_name);
    insert.bind(23, arm.asks_before_resume ? 1 : 0);
    insert.bind(24, arm.first_point);
    insert.bind(25, arm.fire_uncertain ? 1 : 0);
    insert.bind(26, Signed(arm.disarm_count));
    insert.bind(27, arm.disarm_reason);
    insert.bind(28, arm.last_command_id);
    insert.bind(29, static_cast<int>(job.pause_reason));
    const std::string warnings = BytesOf(job.warnings);
    insert.bind(30, warnings.data(), static_cast<int>(warnings.size()));
    insert.bind(31, arm.breakage_accepted_by);
    insert.bind(32, Signed(job.first_estimate_ticks));
    insert.bind(33, job.makes);
    insert.bind(34, arm.block_id);
    insert.exec();
    KeepStages(*database_, job);
    transaction.commit();
  });
}

// Two searches of the index jobs_ended: one for both would read the whole table.
std::vector<JobRecord> JobStore::Load(std::size_t ended_count) {
  return Guarded(*database_, [&] {
    std::vector<JobRecord> jobs;
    LoadOpen(*database_, jobs);
    SQLite::Statement select(*database_,
                             fmt::format("SELECT {} FROM jobs WHERE ended = 1 "
                                         "ORDER BY number DESC LIMIT ?",
                                         kColumns));
    select.bind(1, Signed(ended_count));
    LoadEndedOf(*database_, select, jobs);
    std::sort(jobs.begin(), jobs.end(),
              [](const JobRecord& a, const JobRecord& b) { return a.number < b.number; });
    return jobs;
  });
}

std::optional<JobRecord> JobStore::LoadEnded(const std::string& job_uid) {
  return Guarded(*database_, [&]() -> std::optional<JobRecord> {
    SQLite::Statement select(
        *database_,
        fmt::format("SELECT {} FROM jobs WHERE uid = ? AND ended = 1", kColumns));
    select.bind(1, job_uid);
    std::vector<JobRecord> jobs;
    LoadEndedOf(*database_, select, jobs);
    if (jobs.empty()) return {};
    return std::move(jobs.front());
  });
}

}  // namespace intaglio::job_service
