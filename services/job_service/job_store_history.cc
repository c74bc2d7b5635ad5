// What JobStore keeps of a job that has ended, and of those that ended before it did.

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
std::optional<EngraveOutcome> OutcomeIn(sql::Connection& database,
                                        const std::string& job_uid) {
  const auto select = database.Prepare(
      "SELECT outcome FROM tasks WHERE job_uid = ? AND stage = ? "
      "ORDER BY attempt DESC LIMIT 1");
  select->Bind(1, job_uid);
  select->Bind(2, static_cast<int>(intaglio_STAGE_ENGRAVE));
  if (!select->Step() || select->IsNull(0)) return {};
  StageOutcome outcome;
  if (!outcome.ParseFromString(select->Text(0)) || !outcome.has_engrave()) {
    return {};
  }
  return outcome.engrave();
}

/// What an estimate is compared with: the ticks of a job that one synchronizer made
/// whole, in one run, at full speed; else 0.
std::uint64_t UndisturbedTicks(sql::Connection& database, const std::string& job_uid,
                               const EngraveOutcome& outcome) {
  const bool whole =
      outcome.planned_count() > 0 &&
      outcome.made_count() + outcome.missed_count() == outcome.planned_count();
  // Reports of earlier versions have no max_speed_percent: 100 was the greatest.
  const bool at_full_speed =
      outcome.min_speed_percent() == 100 && outcome.max_speed_percent() <= 100;
  if (!whole || outcome.run_count() != 1 || !at_full_speed) return 0;
  const auto given =
      database.Prepare("SELECT count(*) FROM tasks WHERE job_uid = ? AND stage = ?");
  given->Bind(1, job_uid);
  given->Bind(2, static_cast<int>(intaglio_STAGE_ENGRAVE));
  const bool by_one = given->Step() && given->Integer(0) == 1;
  return by_one ? outcome.used_ticks() : 0;
}

/// The warnings that a job was kept with.
Warnings WarningsIn(sql::Connection& database, const std::string& job_uid) {
  const auto select = database.Prepare("SELECT warnings FROM jobs WHERE uid = ?");
  select->Bind(1, job_uid);
  if (!select->Step()) return {};
  return WarningsOfBytes(select->Text(0));
}

}  // namespace

void JobStore::KeepVerdict(const std::string& job_uid, const std::string& report,
                           const std::string& recording, const LastKnown& last) {
  Guarded(*database_, [&] {
    const auto ended =
        database_->Prepare("SELECT state, makes FROM jobs WHERE uid = ? AND ended = 1");
    ended->Bind(1, job_uid);
    if (!ended->Step()) return;
    const bool done = ended->Integer(0) == static_cast<int>(intaglio_JOB_DONE);
    const auto outcome = OutcomeIn(*database_, job_uid);
    const intaglio_PointCounts counts = outcome ? CountsOf(*outcome)
                                        : last.counts.planned > 0
                                            ? AtEnd(last.counts)
                                            : ResultOf(job_uid).counts;
    std::string verdict;
    if (outcome || last.is_all) {
      verdict = VerdictName(
          VerdictOf(done, counts, WarningsIn(*database_, job_uid), ended->Text(1))
              .verdict);
    }
    const auto update = database_->Prepare(
        "UPDATE jobs SET verdict = ?2, planned_count = ?3, made_count = ?4, "
        "missed_count = ?5, skipped_count = ?6, uncertain_count = ?7, used_ticks = ?8, "
        "report = ?9, recording = ?10, undisturbed_ticks = ?11 WHERE uid = ?1");
    update->Bind(1, job_uid);
    update->Bind(2, verdict);
    int column = 3;
    const EngraveOutcome ticks = outcome.value_or(EngraveOutcome());
    for (const std::uint64_t count :
         {counts.planned, counts.made, counts.missed, counts.skipped, counts.uncertain,
          std::uint64_t{ticks.used_ticks()}}) {
      update->Bind(column++, static_cast<std::int64_t>(count));
    }
    update->Bind(9, report);
    update->Bind(10, recording);
    update->Bind(11,
                 static_cast<std::int64_t>(UndisturbedTicks(*database_, job_uid, ticks)));
    update->Execute();
  });
}

JobResult JobStore::ResultOf(const std::string& job_uid) {
  return Guarded(*database_, [&]() -> JobResult {
    const auto select = database_->Prepare(
        "SELECT verdict, planned_count, made_count, missed_count, skipped_count, "
        "uncertain_count FROM jobs WHERE uid = ?");
    select->Bind(1, job_uid);
    if (!select->Step()) return {};
    const auto count = [&select](int column) {
      return static_cast<std::uint64_t>(select->Integer(column));
    };
    return {select->Text(0), {count(1), count(2), count(3), count(4), count(5), 0, 0}};
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
  const auto select = database_->Prepare("SELECT uid, frozen_job FROM jobs");
  while (select->Step()) {
    FrozenJob frozen;
    if (!frozen.ParseFromString(select->Text(1))) continue;
    glasses.emplace_back(select->Text(0), frozen.job().glass());
  }
  for (const auto& [uid, glass] : glasses) {
    const auto update = database_->Prepare("UPDATE jobs SET material = ? WHERE uid = ?");
    update->Bind(1, glass);
    update->Bind(2, uid);
    update->Execute();
    KeepVerdict(uid, "", "");
  }
}

}  // namespace intaglio::job_service
