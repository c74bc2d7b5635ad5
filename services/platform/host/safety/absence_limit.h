#pragma once

// How long a part of a machine's supervision may be away before an arm ends. An arm is a
// person's statement about the block that is in the machine now. It survives a process or
// a line that comes back within this time, because no person can change a block and leave
// in less; after a longer absence the block may be another one, and the job waits for a
// new arm. Absences are added up: between two short ones a person may do the first and
// the second half of it.
//
// The one limit for every absence: of the synchronizer and of the job service (judged by
// the job service), of the laser controller and of the motion controller (judged by the
// synchronizer). docs/jobs.md states it.

#include <chrono>
#include <optional>

namespace intaglio::host {

inline constexpr std::chrono::seconds kMaxAbsence{30};

/// The absences of one part, added up since it was last observed for kMaxAbsence without
/// a gap, or since a person has armed. It is present at first. Pure; times of one
/// monotonic clock, which do not fall.
class AbsenceSum {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  /// What the next process needs to go on with the sum.
  struct Kept {
    Nanoseconds present_since{Nanoseconds::min() / 2};
    Nanoseconds sum{0};
  };

  AbsenceSum() = default;
  /// Present.
  explicit AbsenceSum(const Kept& kept)
      : present_since_(kept.present_since), sum_(kept.sum) {}
  /// Of one that is present.
  Kept ToKeep() const { return {present_since_, sum_}; }

  /// Absent since then, unless it is absent already.
  void Begin(Nanoseconds since) {
    if (absent_since_) return;
    if (since - present_since_ >= kMaxAbsence) sum_ = {};
    absent_since_ = since;
  }
  /// Present from now on, unless it is present already.
  void End(Nanoseconds now) {
    if (!absent_since_) return;
    sum_ += now - *absent_since_;
    absent_since_.reset();
    present_since_ = now;
  }
  /// A person has armed now, and so has judged what came before.
  void Restart(Nanoseconds now) {
    sum_ = {};
    if (absent_since_) absent_since_ = now;
  }
  bool absent() const { return absent_since_.has_value(); }
  /// All its absences together, with the one that lasts.
  Nanoseconds Total(Nanoseconds now) const {
    return sum_ + (absent_since_ ? now - *absent_since_ : Nanoseconds(0));
  }
  /// It is absent, and all its absences together exceed the limit.
  bool IsTooLong(Nanoseconds now) const {
    return absent_since_ && Total(now) > kMaxAbsence;
  }

 private:
  std::optional<Nanoseconds> absent_since_;
  Nanoseconds present_since_{Nanoseconds::min() / 2};
  Nanoseconds sum_{0};  // without the absence that lasts
};

}  // namespace intaglio::host
