// What JobStore keeps of the commands: each with its answer.

#include <fmt/format.h>

#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {

void JobStore::KeepAnswer(const CommandView& command, const CommandAnswer& answer) {
  Guarded(*database_, [&] {
    const auto insert = database_->Prepare(
        "INSERT INTO commands (sender, number, job_uid, kind, "
        "operator_name, code, message, basis, taken_utc) "
        "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING");
    insert->Bind(1, command.sender);
    insert->Bind(2, Signed(command.number));
    insert->Bind(3, command.job_uid);
    insert->Bind(4, static_cast<int>(command.kind));
    insert->Bind(5, command.operator_name);
    insert->Bind(6, static_cast<int>(answer.code));
    insert->Bind(7, answer.message);
    insert->Bind(8, static_cast<int>(command.basis));
    insert->Bind(9, NowUtc());
    insert->Execute();
    if (!answer.taken()) NoteRefusal("commands", "code <> 0", refused_commands_);
  });
}

void JobStore::NoteRefusal(const char* table, const char* refused, int& since_drop) {
  if (++since_drop < refusals_.drop_every) return;
  since_drop = 0;
  const auto drop = database_->Prepare(fmt::format(
      "DELETE FROM {0} WHERE {1} AND taken_utc < ? AND taken_utc < (SELECT taken_utc "
      "FROM {0} WHERE {1} ORDER BY taken_utc DESC LIMIT 1 OFFSET ?)",
      table, refused));
  drop->Bind(1, host::UtcText(std::chrono::system_clock::now() - refusals_.stays));
  drop->Bind(2, refusals_.max_count - 1);
  drop->Execute();
}

std::optional<CommandAnswer> JobStore::AnswerTo(const std::string& sender,
                                                std::uint64_t number) {
  return Guarded(*database_, [&]() -> std::optional<CommandAnswer> {
    const auto select = database_->Prepare(
        "SELECT code, message FROM commands WHERE sender = ? AND number = ?");
    select->Bind(1, sender);
    select->Bind(2, Signed(number));
    if (!select->Step()) return {};
    return CommandAnswer{static_cast<intaglio_CommandAnswerCode>(select->Integer(0)),
                         select->Text(1)};
  });
}

}  // namespace intaglio::job_service
