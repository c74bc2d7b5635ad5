#pragma once

// For how long there was no job service: a short note beside the queue, written anew
// every second. Absences are added up over its lives, as host::AbsenceSum does it for
// each part: two short ones with a moment between them are a long one. Measured by the
// time since the machine was switched on, which cannot be set by hand and goes on while
// it sleeps; another boot is an absence of unknown length. A job service that stands by
// on another computer measures it by its own clock, by when it has seen the note change.
// Not synced: what matters over a power failure is that the boot is another.

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::job_service {

/// Where the note lies; an empty text: there is none.
struct NotePlace {
  std::function<std::string()> read;
  std::function<void(const std::string& text)> write;
};

/// What a job service that stands by has seen of the note of another.
struct SeenByStandby {
  std::string note;             ///< the newest
  std::chrono::nanoseconds at;  ///< it was not older then, since this computer's boot
};

class LastSeen {
 public:
  /// Reads what the previous job service has left. `standby`: what this process has seen
  /// of it meanwhile, if it stood by.
  explicit LastSeen(NotePlace place, const std::optional<SeenByStandby>& standby = {});

  /// All absences since there was one for host::kMaxAbsence without a gap, the one that
  /// ended just now among them. nullopt: never seen, or not since the machine was
  /// switched on.
  std::optional<std::chrono::nanoseconds> absence() const { return absence_; }
  /// Cheap when nothing is due. A longer time without a call is an absence, too. A disk
  /// that refuses makes the next absence unknown.
  void Note();

 private:
  NotePlace place_;
  std::string boot_;
  std::optional<std::chrono::nanoseconds> absence_;
  host::AbsenceSum sum_;
  std::chrono::nanoseconds noted_at_{-1};  ///< -1: not yet
};

}  // namespace intaglio::job_service
