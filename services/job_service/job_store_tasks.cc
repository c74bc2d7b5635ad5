// What JobStore keeps of the tasks: to whom they were given, what came of them, and to
// whom none is given any more.

#include <fmt/format.h>

#include <map>
#include <utility>

#include "proto/task.pb.h"
#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::job_service {
namespace {

// One task, by the parameters that BindTask fills.
constexpr const char* kWhereTask =
    "job_uid = ?1 AND attempt = ?2 AND stage = ?3 AND part = ?4 AND part_attempt = ?5";

/// In the table worker_events.
const char* EventOf(const LeftOut& worker) {
  if (!worker.why.empty()) return worker.for_good ? "wrong" : "suspected";
  return worker.admitted_by.empty() ? "cleared" : "admitted";
}

/// Empty: it is not left out.
std::string WhyLeftOut(sql::Connection& database, const std::string& worker) {
  const auto select = database.Prepare("SELECT why FROM left_out WHERE worker = ?");
  select->Bind(1, worker);
  return select->Step() ? select->Text(0) : "";
}

void BindTask(sql::Statement& statement, intaglio_Stage stage, const TaskId& task) {
  statement.Bind(1, task.job_uid);
  statement.Bind(2, task.attempt);
  statement.Bind(3, static_cast<int>(stage));
  statement.Bind(4, task.part);
  statement.Bind(5, task.part_attempt);
}

}  // namespace

void JobStore::KeepTask(const TaskOrder& order) {
  Guarded(*database_, [&] {
    const std::string text =
        order.revoked
            ? fmt::format("UPDATE tasks SET revoked_utc = ?7, worker = ?6 WHERE {}",
                          kWhereTask)
            : "INSERT INTO tasks "
              "(job_uid, attempt, stage, part, part_attempt, worker, given_utc) "
              "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7) "
              "ON CONFLICT (job_uid, attempt, stage, part, part_attempt) DO UPDATE SET "
              "worker = excluded.worker, given_utc = excluded.given_utc, "
              "revoked_utc = NULL, ended_utc = NULL, state = NULL, message = NULL, "
              "outcome = NULL";
    const auto statement = database_->Prepare(text);
    BindTask(*statement, order.stage, order.task);
    statement->Bind(6, order.worker);
    statement->Bind(7, NowUtc());
    statement->Execute();
  });
}

bool JobStore::KeepTaskEnd(const TaskView& task, const std::string& outcome) {
  return Guarded(*database_, [&] {
    const auto update = database_->Prepare(
        fmt::format("UPDATE tasks SET ended_utc = ?10, state = ?6, message = ?7, "
                    "outcome = ?8 WHERE {} AND worker = ?9 AND ended_utc IS NULL",
                    kWhereTask));
    BindTask(*update, task.stage, task.task);
    update->Bind(6, static_cast<int>(task.state));
    update->Bind(7, task.message);
    update->BindBytes(8, outcome);
    update->Bind(9, task.worker);
    update->Bind(10, NowUtc());
    return update->Execute() > 0;
  });
}

void JobStore::KeepLeftOut(const LeftOut& worker) {
  Guarded(*database_, [&] {
    sql::Transaction transaction(*database_);
    if (WhyLeftOut(*database_, worker.worker) == worker.why) return;
    if (worker.why.empty()) {
      const auto erase = database_->Prepare("DELETE FROM left_out WHERE worker = ?");
      erase->Bind(1, worker.worker);
      erase->Execute();
    } else {
      const auto insert = database_->Prepare(
          "INSERT INTO left_out (worker, why, for_good, since_utc) VALUES (?, ?, ?, ?) "
          "ON CONFLICT (worker) DO UPDATE SET why = excluded.why, "
          "for_good = excluded.for_good");
      insert->Bind(1, worker.worker);
      insert->Bind(2, worker.why);
      insert->Bind(3, worker.for_good ? 1 : 0);
      insert->Bind(4, NowUtc());
      insert->Execute();
    }
    const auto event = database_->Prepare(
        "INSERT INTO worker_events (number, worker, event, why, operator_name, at_utc) "
        "VALUES ((SELECT coalesce(max(number), 0) + 1 FROM worker_events), ?, ?, ?, ?, "
        "?)");
    event->Bind(1, worker.worker);
    event->Bind(2, EventOf(worker));
    event->Bind(3, worker.why);
    event->Bind(4, worker.admitted_by);
    event->Bind(5, NowUtc());
    event->Execute();
    transaction.Commit();
  });
}

std::vector<LeftOut> JobStore::LoadLeftOut() {
  return Guarded(*database_, [&] {
    const auto select =
        database_->Prepare("SELECT worker, why, for_good FROM left_out ORDER BY worker");
    std::vector<LeftOut> workers;
    while (select->Step())
      workers.push_back({select->Text(0), select->Text(1), select->Integer(2) != 0});
    return workers;
  });
}

AttemptOutcomes JobStore::OutcomesOf(const std::string& job_uid, std::uint32_t attempt) {
  return Guarded(*database_, [&] {
    const auto select = database_->Prepare(
        "SELECT stage, part, outcome FROM tasks WHERE job_uid = ? AND attempt = ? AND "
        "stage < ? AND state = ? AND part_attempt < ? AND outcome IS NOT NULL ORDER BY "
        "part, part_attempt");
    select->Bind(1, job_uid);
    select->Bind(2, attempt);
    select->Bind(3, static_cast<int>(intaglio_STAGE_ENGRAVE));
    select->Bind(4, static_cast<int>(intaglio_TASK_DONE));
    select->Bind(5, host::kMaxPartAttempts);  // without comparisons
    AttemptOutcomes outcomes;
    std::map<std::uint32_t, DiscretizeOutcome> parts;  // the newest attempt at each
    while (select->Step()) {
      StageOutcome outcome;
      if (!outcome.ParseFromString(select->Text(2))) continue;
      if (outcome.has_sort()) outcomes.sort = outcome.sort();
      if (outcome.has_discretize()) {
        parts[select->Integer(1)] = outcome.discretize();
      }
    }
    for (auto& [part, outcome] : parts) outcomes.parts.push_back(std::move(outcome));
    return outcomes;
  });
}

}  // namespace intaglio::job_service
