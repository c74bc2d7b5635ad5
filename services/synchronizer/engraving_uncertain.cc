#include <fmt/format.h>

#include "services/synchronizer/engraving.h"

// What is done about points of which nobody knows whether they were fired: they are left,
// and a job that says so waits until a person has looked at the block.

namespace intaglio::synchronizer {

// Also when nothing is open any more: it costs the grant, as a fault does, and the answer
// is a newer one. Before any was heard of, there is none that could be spent.
void Engraving::AskOverUncertain(const EngravingInputs& inputs) {
  const bool settled = phase_ == Phase::kPreparing || phase_ == Phase::kWaiting;
  if (!asks_ || asked_ || stopping_ || !settled || inputs.grant.number == 0) return;
  const std::string why = faulted() && !lost_a_line_ ? message_ + "; " : "";
  Explain(Missing::kNothing, why + QuestionOverUncertain(), true);
  asked_ = true;
}

std::string Engraving::QuestionOverUncertain() const {
  std::uint32_t first = 0, last = 0;
  bool found = false;
  for (std::uint32_t point = 0; point < ledger_.size(); ++point) {
    if (ledger_.state(point) != PointState::kUncertain) continue;
    if (!found) first = point;
    found = true;
    last = point;
  }
  const Vec3 at_mm = job_.machine_from_glass.ToGlass(job_.machine_points_mm[first]);
  return fmt::format(
      "points of which nobody knows whether they were fired: {}, at places {}..{} of the "
      "order (from 0), the first at {:.3f}, {:.3f}, {:.3f} mm of the block; look at the "
      "block; `intaglio resume JOB` leaves them as they are",
      ledger_.count(PointState::kUncertain), first, last, at_mm.x(), at_mm.y(),
      at_mm.z());
}

// A question that is open is a reason to wait: only a grant that came after it is the
// answer.
bool Engraving::NothingIsLeft(const EngravingInputs& inputs) const {
  const bool granted = inputs.permission_fresh && inputs.permission_granted;
  if (asks_ && (!asked_ || chain_.latched() || !granted)) return false;
  return !ledger_.NextOpen(0) || idle_runs_ >= kMaxIdleRuns;
}

}  // namespace intaglio::synchronizer
