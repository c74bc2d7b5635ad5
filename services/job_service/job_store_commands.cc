// What JobStore keeps of the commands: each with its answer.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>

#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {

void JobStore::KeepAnswer(const CommandView& command, const CommandAnswer& answer) {
  Guarded(*database_, [&] {
    SQLite::Statement insert(
        *database_,
        fmt::format("INSERT OR IGNORE INTO commands (sender, number, job_uid, kind, "
                    "operator_name, code, message, basis, taken_utc) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?, ?, {})",
                    kNow));
    insert.bind(1, command.sender);
    insert.bind(2, Signed(command.number));
    insert.bind(3, command.job_uid);
    insert.bind(4, static_cast<int>(command.kind));
    insert.bind(5, command.operator_name);
    insert.bind(6, static_cast<int>(answer.code));
    insert.bind(7, answer.message);
    insert.bind(8, static_cast<int>(command.basis));
    insert.exec();
  });
}

std::optional<CommandAnswer> JobStore::AnswerTo(const std::string& sender,
                                                std::uint64_t number) {
  return Guarded(*database_, [&]() -> std::optional<CommandAnswer> {
    SQLite::Statement select(
        *database_, "SELECT code, message FROM commands WHERE sender = ? AND number = ?");
    select.bind(1, sender);
    select.bind(2, Signed(number));
    if (!select.executeStep()) return {};
    return CommandAnswer{
        static_cast<intaglio_CommandAnswerCode>(select.getColumn(0).getInt()),
        select.getColumn(1).getString()};
  });
}

}  // namespace intaglio::job_service
