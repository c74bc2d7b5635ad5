#pragma once

// What became of each mark of a job: by its journal, and by what was burnt where that is
// known. Each mark has one outcome; whether the journal is uncertain about it is counted
// beside that.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/formats/journal_file.h"
#include "engrave/proof/mark_comparison.h"

namespace intaglio::proof {

enum class MarkOutcome : std::uint8_t {
  kMade,
  kSkipped,     ///< not begun by the journal, and nothing of it was burnt
  kMissed,      ///< nothing was burnt of a mark that was begun
  kIncomplete,  ///< only a part was burnt
  kDoubled,
  kUncertain,  ///< by the journal, where nothing else is known
};

struct AccountedMark {
  MarkOutcome outcome = MarkOutcome::kSkipped;
  bool uncertain = false;    ///< by the journal: begun, and not known to have ended
  bool unaccounted = false;  ///< burnt, though the journal has it as not begun

  bool is_right() const {
    return outcome == MarkOutcome::kMade && !uncertain && !unaccounted;
  }
};

struct MarkCount {
  std::uint64_t made = 0, skipped = 0, missed = 0, incomplete = 0, doubled = 0;
};

struct MarkAccount {
  std::vector<AccountedMark> marks;  ///< by their place in the job
  /// By outcome, with what was burnt: they add up to the marks of the job.
  MarkCount count;
  std::uint64_t uncertain_count = 0, unaccounted_count = 0;
  /// Of those that are uncertain, by what was burnt.
  MarkCount of_uncertain;
};

/// By journal and material: history and comparison are of the same marks.
MarkAccount AccountMarks(std::span<const formats::PointHistory> history,
                         const MarkComparison& burnt);

/// By the journal alone: a mark is uncertain, or what it says. Doubled: ended twice.
MarkAccount AccountMarks(std::span<const formats::PointHistory> history);

}  // namespace intaglio::proof
