// What JobStore keeps of the tasks: to whom they were given, and what came of them.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include <map>
#include <utility>

#include "proto/task.pb.h"
#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {
namespace {

// One task, by the parameters that BindTask fills.
constexpr const char* kWhereTask =
    "job_uid = ?1 AND attempt = ?2 AND stage = ?3 AND part = ?4 AND part_attempt = ?5";

void BindTask(SQLite::Statement& statement, intaglio_Stage stage, const TaskId& task) {
  statement.bind(1, task.job_uid);
  statement.bind(2, task.attempt);
  statement.bind(3, static_cast<int>(stage));
  statement.bind(4, task.part);
  statement.bind(5, task.part_attempt);
}

}  // namespace

void JobStore::KeepTask(const TaskOrder& order) {
  Guarded(*database_, [&] {
    const std::string text =
        order.revoked
            ? fmt::format("UPDATE tasks SET revoked_utc = {}, worker = ?6 WHERE {}", kNow,
                          kWhereTask)
            : fmt::format(
                  "INSERT OR REPLACE INTO tasks "
                  "(job_uid, attempt, stage, part, part_attempt, worker, given_utc) "
                  "VALUES (?1, ?2, ?3, ?4, ?5, ?6, {})",
                  kNow);
    SQLite::Statement statement(*database_, text);
    BindTask(statement, order.stage, order.task);
    statement.bind(6, order.worker);
    statement.exec();
  });
}

bool JobStore::KeepTaskEnd(const TaskView& task, const std::string& outcome) {
  return Guarded(*database_, [&] {
    SQLite::Statement update(
        *database_,
        fmt::format("UPDATE tasks SET ended_utc = {}, state = ?6, message = ?7, "
                    "outcome = ?8 WHERE {} AND worker = ?9 AND ended_utc IS NULL",
                    kNow, kWhereTask));
    BindTask(update, task.stage, task.task);
    update.bind(6, static_cast<int>(task.state));
    update.bind(7, task.message);
    update.bind(8, outcome.data(), static_cast<int>(outcome.size()));
    update.bind(9, task.worker);
    return update.exec() > 0;
  });
}

AttemptOutcomes JobStore::OutcomesOf(const std::string& job_uid, std::uint32_t attempt) {
  return Guarded(*database_, [&] {
    SQLite::Statement select(
        *database_,
        "SELECT stage, part, outcome FROM tasks WHERE job_uid = ? AND attempt = ? AND "
        "stage < ? AND state = ? AND outcome IS NOT NULL ORDER BY part, part_attempt");
    select.bind(1, job_uid);
    select.bind(2, attempt);
    select.bind(3, static_cast<int>(intaglio_STAGE_ENGRAVE));
    select.bind(4, static_cast<int>(intaglio_TASK_DONE));
    AttemptOutcomes outcomes;
    std::map<std::uint32_t, DiscretizeOutcome> parts;  // the newest attempt at each
    while (select.executeStep()) {
      StageOutcome outcome;
      if (!outcome.ParseFromString(select.getColumn(2).getString())) continue;
      if (outcome.has_sort()) outcomes.sort = outcome.sort();
      if (outcome.has_discretize()) {
        parts[select.getColumn(1).getUInt()] = outcome.discretize();
      }
    }
    for (auto& [part, outcome] : parts) outcomes.parts.push_back(std::move(outcome));
    return outcomes;
  });
}

}  // namespace intaglio::job_service
