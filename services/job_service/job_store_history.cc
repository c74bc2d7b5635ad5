// What JobStore keeps of a job that has ended, and of those that ended before it did.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include <optional>
#include <utility>

#include "proto/task.pb.h"
#include "services/history/job_history.h"
#include "services/job/verdict/outcome_counts.h"
#include "services/job/verdict/verdict.h"
#include "services/job/verdict/warnings.h"
#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"
#include "services/platform/host/stage/counts_at_end.h"

namespace intaglio::job_service {
namespace {

/// Loads that of the job's newest engraving, once it has reported one.
std::optional<EngraveOutcome> OutcomeIn(SQLite::Database& database,
                                        const std::string& job_uid) {
  SQLite::Statement select(database,
                           "SELECT outcome FROM tasks WHERE job_uid = ? AND stage = ? "
                           "ORDER BY attempt DESC LIMIT 1");
  select.bind(1, job_uid);
  select.bind(2, static_cast<int>(intaglio_STAGE_ENGRAVE));
  if (!select.executeStep() || select.getColumn(0).isNull()) return {};
  StageOutcome outcome;
  if (!outcome.ParseFromString(select.getColumn(0).getString()) ||
      !outcome.has_engrave()) {
    return {};
  }
  return outcome.engrave();
}

/// What an estimate is compared with: the ticks of a job that one synchronizer made
/// whole, in one run, at full speed; else 0.
std::uint64_t UndisturbedTicks(SQLite::Database& database, const std::string& job_uid,
                               const EngraveOutcome& outcome) {
  const bool whole =
      outcome.planned_count() > 0 &&
      outcome.made_count() + outcome.missed_count() == outcome.planned_count();
  // Reports of earlier versions have no max_speed_percent: 100 was the greatest.
  const bool at_full_speed =
      outcome.min_speed_percent() == 100 && outcome.max_speed_percent() <= 100;
  if (!whole || outcome.run_count() != 1 || !at_full_speed) return 0;
  SQLite::Statement given(database,
                          "SELECT count(*) FROM tasks WHERE job_uid = ? AND stage = ?");
  given.bind(1, job_uid);
  given.bind(2, static_cast<int>(intaglio_STAGE_ENGRAVE));
  const bool by_one = given.executeStep() && given.getColumn(0).getInt() == 1;
  return by_one ? outcome.used_ticks() : 0;
}

/// The warnings that a job was kept with.
Warnings WarningsIn(SQLite::Database& database, const std::string& job_uid) {
  SQLite::Statement select(database, "SELECT warnings FROM jobs WHERE uid = ?");
  select.bind(1, job_uid);
  if (!select.executeStep()) return {};
  return WarningsOfBytes(select.getColumn(0).getString());
}

}  // namespace

void JobStore::KeepVerdict(const std::string& job_uid, const std::string& report,
                           const std::string& recording, const LastKnown& last) {
  Guarded(*database_, [&] {
    SQLite::Statement ended(*database_,
                            "SELECT state, makes FROM jobs WHERE uid = ? AND ended = 1");
    ended.bind(1, job_uid);
    if (!ended.executeStep()) return;
    const bool done = ended.getColumn(0).getInt() == static_cast<int>(intaglio_JOB_DONE);
    const auto outcome = OutcomeIn(*database_, job_uid);
    const intaglio_PointCounts counts = outcome ? CountsOf(*outcome)
                                        : last.counts.planned > 0
                                            ? AtEnd(last.counts)
                                            : ResultOf(job_uid).counts;
    std::string verdict;
    if (outcome || last.is_all) {
      verdict = VerdictName(VerdictOf(done, counts, WarningsIn(*database_, job_uid),
                                      ended.getColumn(1).getString())
                                .verdict);
    }
    SQLite::Statement update(
        *database_,
        "UPDATE jobs SET verdict = ?2, planned_count = ?3, made_count = ?4, "
        "missed_count = ?5, skipped_count = ?6, uncertain_count = ?7, used_ticks = ?8, "
        "report = ?9, recording = ?10, undisturbed_ticks = ?11 WHERE uid = ?1");
    update.bind(1, job_uid);
    update.bind(2, verdict);
    int column = 3;
    const EngraveOutcome ticks = outcome.value_or(EngraveOutcome());
    for (const std::uint64_t count :
         {counts.planned, counts.made, counts.missed, counts.skipped, counts.uncertain,
          std::uint64_t{ticks.used_ticks()}}) {
      update.bind(column++, static_cast<std::int64_t>(count));
    }
    update.bind(9, report);
    update.bind(10, recording);
    update.bind(11,
                static_cast<std::int64_t>(UndisturbedTicks(*database_, job_uid, ticks)));
    update.exec();
  });
}

JobResult JobStore::ResultOf(const std::string& job_uid) {
  return Guarded(*database_, [&]() -> JobResult {
    SQLite::Statement select(
        *database_,
        "SELECT verdict, planned_count, made_count, missed_count, skipped_count, "
        "uncertain_count FROM jobs WHERE uid = ?");
    select.bind(1, job_uid);
    if (!select.executeStep()) return {};
    const auto count = [&select](int column) {
      return static_cast<std::uint64_t>(select.getColumn(column).getInt64());
    };
    return {select.getColumn(0).getString(),
            {count(1), count(2), count(3), count(4), count(5), 0, 0}};
  });
}

JobStatistics JobStore::StatisticsOf(const JobRecord& job,
                                     std::chrono::system_clock::time_point now) {
  return Guarded(*database_, [&] {
    history::Filter filter;
    filter.job = job.number;
    JobStatistics statistics = history::SelectJobs(*database_, filter, now).at(0);
    // Progress is published and not kept.
    const StageRecord& engraving = job.stage(intaglio_STAGE_ENGRAVE);
    history::AddProgress(statistics, engraving.done_count, engraving.total_count,
                         engraving.elapsed_s, now);
    return statistics;
  });
}

void JobStore::FillInHistory() {
  std::vector<std::pair<std::string, std::string>> glasses;
  SQLite::Statement select(*database_, "SELECT uid, frozen_job FROM jobs");
  while (select.executeStep()) {
    FrozenJob frozen;
    if (!frozen.ParseFromString(select.getColumn(1).getString())) continue;
    glasses.emplace_back(select.getColumn(0).getString(), frozen.job().glass());
  }
  for (const auto& [uid, glass] : glasses) {
    SQLite::Statement update(*database_, "UPDATE jobs SET material = ? WHERE uid = ?");
    update.bind(1, glass);
    update.bind(2, uid);
    update.exec();
    KeepVerdict(uid, "", "");
  }
}

}  // namespace intaglio::job_service
