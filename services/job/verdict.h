#pragma once

// The verdict that a shop can give on a block by itself: from the ledger of its
// engraving, which the laser controller's counters settle. It is no proof from the glass;
// that is the report of `intaglio run`, or an inspection by a person.

#include <string>

#include "proto/task.pb.h"

namespace intaglio {

enum class VerdictKind {
  kNone,     ///< nothing is in the glass
  kUnknown,  ///< done, but the outcome is not known any more
  kNotGood,
  kGood,  ///< done, every planned point is made, none is missed, skipped or uncertain
};

/// As programs read it: "none", "unknown", "not_good", "good".
const char* VerdictName(VerdictKind verdict);

struct ShopVerdict {
  VerdictKind verdict = VerdictKind::kNone;
  std::string reason;  ///< why it is not good, for people; else empty
};

/// `outcome`: null when it is not known.
ShopVerdict VerdictOf(bool done, const EngraveOutcome* outcome);

}  // namespace intaglio
