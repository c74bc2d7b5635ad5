#pragma once

// The verdict that a shop can give on a block by itself: from the ledger of its
// engraving, which the laser controller's counters settle. It is no proof from the glass;
// that is the report of `intaglio run`, or an inspection by a person.

#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/warning.h"
#include "idl/job.h"

namespace intaglio {

enum class VerdictKind {
  kNone,     ///< nothing is in the glass
  kUnknown,  ///< done, but the outcome is not known any more
  kNotGood,
  kGoodWithWarnings,  ///< as good, but a warning says that the piece may look wrong
  kGood,  ///< done, every planned point is made, none is missed, skipped or uncertain
};

/// As programs read it: "none", "unknown", "not_good", "good_with_warnings", "good".
const char* VerdictName(VerdictKind verdict);
/// kUnknown for another name.
VerdictKind VerdictFromName(std::string_view name);

/// Also with warnings. What is not known is not good.
bool IsGood(VerdictKind verdict);

struct ShopVerdict {
  VerdictKind verdict = VerdictKind::kNone;
  std::string reason;  ///< why it is not good, or the warnings, for people; else empty
};

/// Of a block that was engraved: not good for any of these reasons; else good, with the
/// warnings that say that the piece may look wrong. Every verdict follows from this.
ShopVerdict VerdictFor(const std::vector<std::string>& reasons, const Warnings& warnings);

/// `counts`: at the end (AtEnd); all 0: not known. `makes`: what they count, "points",
/// "marks". `warnings`: all of the job.
ShopVerdict VerdictOf(bool done, const intaglio_PointCounts& counts,
                      const Warnings& warnings, const std::string& makes = "points");

}  // namespace intaglio
