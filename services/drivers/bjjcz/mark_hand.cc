#include "services/drivers/bjjcz/mark_hand.h"

#include "engrave/core/try.h"

namespace intaglio::drivers {

Status BjjczMarkHand::DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s) {
  GuideOutline outline = INTAGLIO_TRY(GuideOutline::Make(
      board_, lists_.field(), lists_.guide_jumps(), corners_mm, speed_mm_s));
  if (!state_.link_up) return Fail(ErrorCode::kLinkLost, state_.message);
  if (state_.fault != intaglio_MOTION_OK)
    return Fail(ErrorCode::kRefused, state_.message);
  if (!state_.at_rest || active())
    return Fail(ErrorCode::kRefused, "the mirrors are not at rest: wait");
  outline_ = std::move(outline);
  held_ = false;
  state_.at_rest = false;
  return {};
}

Status BjjczMarkHand::Hold() {
  held_ = true;
  return {};
}

void BjjczMarkHand::TakeState(const MarkDeviceState& mark) {
  const bool faulted = mark.safe_state || !mark.fault.empty();
  state_.link_up = mark.link_up;
  state_.number = mark.number;
  state_.refusal = mark.refusal;
  state_.fault = !mark.link_up ? intaglio_MOTION_LINK_LOST
                 : faulted     ? intaglio_MOTION_SAFE_STATE
                               : intaglio_MOTION_OK;
  if (!mark.link_up)
    state_.message = mark.message;
  else if (!mark.fault.empty())
    state_.message = mark.fault;
  else
    state_.message = mark.safe_state ? kChainWasOpened : "";
  state_.position_mm = mark.position_mm;
  state_.at_rest = mark.at_rest;
}

}  // namespace intaglio::drivers
