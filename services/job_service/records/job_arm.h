#pragma once

// The arm of one job: a person's consent that its machine fires for it, with the block
// that is in the machine now. Values only: no bus, no clock.
//
//              Arm                    MayFire, kHold after a withdrawal at the earliest
//   disarmed -------> armed ----------------------------------> grants a permission
//      ^  ^------------ |  Disarm
//      |                v
//      +-- Disarm -- renewed (Renew): armed as before, without a person, a while later
//
// 1. Each arm by a person is a grant with a greater number than those before, over
//    restarts, too; nothing else makes one. After a fault the synchronizer accepts a
//    newer grant only.
// 2. A withdrawal lasts for kHold at least, longer than the permission's lease; a report
//    of a fault within kHold after a new grant was still about the old one (IsOutdated).
// 3. disarm_count grows with every Disarm, also of a job that is not armed: an ARM that
//    was sent before it has no effect, in whatever order they arrive.
// 4. Without a point made between them, kMaxRenewals renewals are the end: then a person
//    is needed.

#include <cstdint>
#include <string>

#include "services/job_service/records/job_views.h"
#include "services/platform/host/safety/absence_limit.h"

namespace intaglio::job_service {

/// What a restart of the job service keeps.
struct KeptArm {
  bool armed = false;
  /// A permission was, or may have been, given: pulses may exist in the glass.
  bool ever_granted = false;
  /// After a loss it waits for the operator (JobSpec.ask_before_resume).
  bool asks_before_resume = false;
  std::uint64_t disarm_count = 0;
  std::string disarm_reason = {};  ///< of the last Disarm, for people
  std::string operator_name = {};
  /// Who has accepted that the glass may break; empty: nobody. It belongs to the job:
  /// what disarms it does not take this back.
  std::string breakage_accepted_by = {};
  std::uint32_t first_point = 0;   ///< as in Permission: for good
  bool fire_uncertain = false;     ///< as in Permission: of the newest command alone
  std::uint64_t last_command = 0;  ///< count of those taken; a speed is not counted
  /// Sender and number of the command that changed the job last: after a power failure it
  /// may be delivered once more without being in the table of answers.
  std::string last_command_id = {};
  std::string block_id = {};  ///< of the loader that armed it; empty: none did
};

/// A machine that is paused for this reason was halted by a fault, not by a permission
/// that ended: it has spent the grant.
bool SpendsTheGrant(intaglio_PauseReason reason);

class JobArm {
 public:
  static constexpr Nanoseconds kHold = std::chrono::milliseconds(300);
  /// With the longest wait between them, 3 s, these take a minute.
  static constexpr std::uint32_t kMaxRenewals = 20;

  JobArm() = default;
  explicit JobArm(KeptArm kept) : kept_(std::move(kept)) {}
  /// As it is to be kept: without the arm while the synchronizer is absent, because after
  /// a restart it is not known how long the absence has lasted.
  KeptArm ToKeep() const;
  /// As it is now.
  const KeptArm& kept() const { return kept_; }

  bool armed() const { return kept_.armed; }
  bool ever_granted() const { return kept_.ever_granted; }
  std::uint64_t disarm_count() const { return kept_.disarm_count; }
  const std::string& disarm_reason() const { return kept_.disarm_reason; }

  /// The same command has been applied as the newest one.
  bool IsRepeated(const CommandView& command) const;
  /// A command that is taken, before its effect. Firing uncertain points belongs to the
  /// grant that it came with: the next command, unless a speed, makes another one.
  void Note(const CommandView& command);
  void Arm(const CommandView& command, Nanoseconds now);
  void Disarm(const std::string& reason, Nanoseconds now);
  void ForbidUncertain() { kept_.fire_uncertain = false; }
  /// Drops that of a restored job: not a Disarm, for no ARM can be on its way.
  void Drop() { kept_.armed = false; }
  /// After a loss: armed as it was, a while later; not when the job asks before it goes
  /// on, nor for the 21st time without a point made. `renewal`: greater than any before,
  /// over restarts, too.
  void Renew(std::uint64_t done_count, std::uint64_t renewal, Nanoseconds now);

  /// Armed, and a withdrawal before it has lasted long enough.
  bool MayFire(Nanoseconds now) const { return kept_.armed && now >= armed_at_; }
  /// The machine's report of a fault was still about an older grant.
  bool IsOutdated(Nanoseconds now) const {
    return kept_.armed && now < armed_at_ + kHold;
  }
  void NoteGranted() { kept_.ever_granted = true; }
  /// Number of the newest grant. A speed is none of them: it must not bring back a grant
  /// that the synchronizer has spent.
  std::uint64_t grant() const { return kept_.last_command + 1; }
  std::uint64_t renewal() const { return renewal_; }

  /// The synchronizer is absent since then, unless it was absent before.
  void BeginAbsence(Nanoseconds since) { absence_.Begin(since); }
  void EndAbsence(Nanoseconds now) { absence_.End(now); }
  /// By all its absences since it was last there for host::kMaxAbsence without a gap.
  bool IsAbsentForTooLong(Nanoseconds now) const { return absence_.IsTooLong(now); }

 private:
  KeptArm kept_;
  Nanoseconds withdrawn_at_{0};
  Nanoseconds armed_at_{0};
  std::uint64_t renewal_ = 0;
  std::uint32_t renewal_count_ = 0;    // without a point made between them
  std::uint64_t done_at_renewal_ = 0;  // points
  host::AbsenceSum absence_;
};

}  // namespace intaglio::job_service
