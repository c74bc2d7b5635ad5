#include "services/synchronizer/engraving/consent.h"

#include <fmt/format.h>

namespace intaglio::synchronizer {

std::string Consent::Question() const {
  const auto [first, last] = UncertainRange();
  const Vec3 at_mm = job_.machine_from_glass.ToGlass(job_.machine_points_mm[first]);
  return fmt::format(
      "points of which nobody knows whether or where they were fired: {}, at places "
      "{}..{} of the order (from 0), the first at {:.3f}, {:.3f}, {:.3f} mm of the "
      "block; check the block; `intaglio resume JOB` leaves them as they are, "
      "`intaglio resume JOB --fire-uncertain` makes them",
      record_.ledger().count(PointState::kUncertain), first, last, at_mm.x(), at_mm.y(),
      at_mm.z());
}

}  // namespace intaglio::synchronizer
