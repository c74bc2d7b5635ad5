#pragma once

// How the work of a stage is cut into parts, as everything that hands them out, works on
// them or puts them together has to know it.

#include <cstdint>

namespace intaglio::host {

/// About eight for each discretizer, so that one that is slower or dies costs little;
/// more than this many only cost hand-overs.
inline constexpr std::uint32_t kMaxParts = 32;

/// Times that a part of one attempt is lost at work before the job is given up.
inline constexpr std::uint32_t kMaxPartLosses = 3;

/// Times that a part of one attempt is given: once it may be lost before it is begun. The
/// consumer grants credit for all of them at once: it need not be notified when one is
/// begun again.
inline constexpr std::uint32_t kMaxPartAttempts = kMaxPartLosses + 1;

/// Times that a part of one attempt is made once more for its checksum alone, to compare
/// discretizers. These follow the attempts in their numbers: the consumer grants no
/// credit for them, so that their points cannot reach it.
inline constexpr std::uint32_t kMaxComparisons = 8;

constexpr bool IsComparison(std::uint32_t part_attempt) {
  return part_attempt >= kMaxPartAttempts;
}

/// Part `index` of `count`, begun for the `attempt`th time (from 0); of a stage that is
/// not cut, the only one.
struct TaskPart {
  std::uint32_t index = 0;
  std::uint32_t count = 1;
  std::uint32_t attempt = 0;

  /// It may be sent to a consumer.
  bool valid() const { return may_be_made() && !IsComparison(attempt); }
  bool may_be_made() const {
    return count <= kMaxParts && index < count &&
           attempt < kMaxPartAttempts + kMaxComparisons;
  }
};

}  // namespace intaglio::host
