#pragma once

// What a shop can say of a block by itself: by the ledger of its engraving, which the
// laser controller's counters settle. It is no proof from the glass; that is the report
// of `intaglio run`, or a person's eye.

#include <string>

#include "proto/task.pb.h"

namespace intaglio {

struct ShopVerdict {
  std::string word;    ///< "good", "not_good", "none" or "unknown"
  std::string reason;  ///< why it is not good, for people; else empty
};

/// Good: the job is done, every planned point is made, none is missed, skipped or
/// uncertain. None: nothing is in the glass. Unknown: done, but the outcome (null) is not
/// known any more.
ShopVerdict VerdictOf(bool done, const EngraveOutcome* outcome);

}  // namespace intaglio
