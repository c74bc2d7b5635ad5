// The outline that the guide laser draws (point_driver.h).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "services/drivers/bjjcz/point_driver.h"

namespace intaglio::drivers {
namespace {

/// The closed way over the corners in steps of at most `step_mm`, each on the edge
/// itself, so that a place of the board is rounded once.
std::vector<Vec2> ClosedWay(std::span<const Vec2> corners_mm, double step_mm) {
  std::vector<Vec2> way_mm;
  for (std::size_t i = 0; i < corners_mm.size(); ++i) {
    const Vec2 from = corners_mm[i], to = corners_mm[(i + 1) % corners_mm.size()];
    const auto count =
        static_cast<std::size_t>(std::max(1.0, std::ceil((to - from).norm() / step_mm)));
    for (std::size_t at = 0; at < count; ++at) {
      const double share = static_cast<double>(at) / static_cast<double>(count);
      way_mm.push_back(from + share * (to - from));
    }
  }
  return way_mm;
}

}  // namespace

Status BjjczPointDriver::DrawOutline(std::span<const Vec2> corners_mm,
                                     double speed_mm_s) {
  if (!board_.has_guide_output()) {
    return Fail(ErrorCode::kUnsupported,
                "the profile names no guide laser: give the output of the board that "
                "switches it, bjjcz_board.guide_output");
  }
  if (auto may = CheckByHand(); !may) return may;
  if (corners_mm.empty() || corners_mm.size() > kMaxOutlineCorners) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the outline has {} corners: give 1 to {}", corners_mm.size(),
                            kMaxOutlineCorners));
  }
  for (const Vec2& corner : corners_mm) {
    const Vec3 place(corner.x(), corner.y(), pieces_.travel().min_mm.z());
    if (auto good = pieces_.Check(place); !good) return good;
  }
  if (!(speed_mm_s > 0)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("speed {} mm/s: give one above 0", speed_mm_s));
  }
  wanted_open_ = false;
  outline_ = Outline{
      .way_mm = ClosedWay(corners_mm, lists_.GuideStepMm(speed_mm_s)),
      .speed_mm_s = speed_mm_s,
  };
  // Until it is held, or ended.
  jog_ = JogWay{state_.position_mm, state_.position_mm, speed_mm_s,
                std::numeric_limits<double>::infinity()};
  state_.at_rest = false;
  return {};
}

void BjjczPointDriver::FeedOutline() {
  // The guide laser is switched on before the first list of its way.
  if (!draws_outline() || asked_outputs_ != WantedOutputs()) return;
  Outline& outline = *outline_;
  if (std::exchange(oscillates_, false))
    return line_.Send({LmcOperation::kFibreOscillator, {0}});
  if (!std::exchange(outline.has_begun, true)) {
    (void)lists_.AddGuide(outline.way_mm.front(),
                          std::numeric_limits<double>::infinity());
  } else {
    const auto next = [&] { return (outline.next + 1) % outline.way_mm.size(); };
    while (lists_.AddGuide(outline.way_mm[next()], outline.speed_mm_s))
      outline.next = next();
  }
  const LmcList list = lists_.Take();
  Plan(list.seconds);
  Send(list);
}

}  // namespace intaglio::drivers
