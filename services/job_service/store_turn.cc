#include "services/job_service/store_turn.h"

#include <utility>

#include "services/job_service/boot_clock.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {

// The note was written after the last look that did not have it.
void StoreTurn::Watch() {
  const auto now = SinceBoot();
  const std::string note = connection_->Note();
  if (last_read_ == kNeverRead) {
    seen_.reset();
  } else if (note != last_note_) {
    seen_ = SeenByStandby{note, last_read_};
  }
  last_note_ = note;
  last_read_ = now;
}

std::optional<JobStore> StoreTurn::Try() {
  if (!standby_) return JobStore(address_);
  try {
    if (!connection_) connection_ = OpenStore(address_);
    Watch();
    if (!connection_->TryOwn()) return std::nullopt;
    Watch();
  } catch (const sql::SqlError& error) {
    connection_.reset();
    throw ErrorOf(address_, error);
  }
  // From now on the notes are its own; it looks for others' when it has lost the store.
  last_read_ = kNeverRead;
  return JobStore(std::exchange(connection_, nullptr));
}

}  // namespace intaglio::job_service
