// What JobStore keeps of the commands: each with its answer.

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
  });
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
