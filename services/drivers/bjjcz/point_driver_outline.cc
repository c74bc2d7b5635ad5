// The outline that the guide laser draws (point_driver.h).

#include <limits>
#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/bjjcz/point_driver.h"

namespace intaglio::drivers {

Status BjjczPointDriver::DrawOutline(std::span<const Vec2> corners_mm,
                                     double speed_mm_s) {
  GuideOutline outline = INTAGLIO_TRY(GuideOutline::Make(
      board_, lists_.field(), lists_.guide_jumps(), corners_mm, speed_mm_s));
  INTAGLIO_TRY(CheckByHand());
  for (const Vec2& corner : corners_mm)
    INTAGLIO_TRY(
        pieces_.Check(Vec3(corner.x(), corner.y(), pieces_.travel().min_mm.z())));
  wanted_open_ = false;
  outline_ = std::move(outline);
  // Until it is held, or ended.
  jog_ = JogWay{state_.position_mm, state_.position_mm, speed_mm_s,
                std::numeric_limits<double>::infinity()};
  state_.at_rest = false;
  return {};
}

void BjjczPointDriver::FeedOutline() {
  // The guide laser is switched on before the first list of its way.
  if (!draws_outline() || asked_outputs_ != WantedOutputs()) return;
  if (std::exchange(oscillates_, false))
    return line_.Send({LmcOperation::kFibreOscillator, {0}});
  const LmcList list = lists_.TakeGuide(*outline_);
  Plan(list.seconds);
  Send(list);
}

}  // namespace intaglio::drivers
