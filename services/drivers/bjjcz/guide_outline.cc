#include "services/drivers/bjjcz/guide_outline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/drivers/interface/hand_motion.h"

namespace intaglio::drivers {
namespace {

using enum LmcOperation;

// A guide laser that has no way to go shows its place so long, 10 us.
constexpr std::uint16_t kGuideRest = 100;
// Of a list, behind its begin: speed and delay of its jumps.
constexpr std::size_t kSettings = 2;

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

Result<GuideOutline> GuideOutline::Make(const BjjczBoard& board, const BoardField& field,
                                        const GuideJumps& jumps,
                                        std::span<const Vec2> corners_mm,
                                        double speed_mm_s) {
  if (!board.has_guide_output()) {
    return Fail(ErrorCode::kUnsupported,
                "the profile names no guide laser: give the output of the board that "
                "switches it, bjjcz_board.guide_output");
  }
  if (corners_mm.empty() || corners_mm.size() > kMaxOutlineCorners) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the outline has {} corners: give 1 to {}", corners_mm.size(),
                            kMaxOutlineCorners));
  }
  for (const Vec2& corner : corners_mm) {
    if (field.Contains(corner)) continue;
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("the corner ({:g}, {:g}) mm of the outline is outside the "
                            "field, which ends {:g} mm from its middle",
                            corner.x(), corner.y(), field.border_mm()));
  }
  if (!(speed_mm_s > 0)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("speed {} mm/s: give one above 0", speed_mm_s));
  }
  GuideOutline outline(board, field, jumps);
  outline.way_mm_ = ClosedWay(corners_mm, outline.StepMm(speed_mm_s));
  outline.speed_mm_s_ = speed_mm_s;
  return outline;
}

double GuideOutline::PlacesMs(double speed_mm_s) const {
  const double mm_s = std::min(speed_mm_s, jumps_.jump_mm_s);
  return std::max(1.0, std::floor(mm_s * field_.places_per_mm() / 1000));
}

double GuideOutline::StepMm(double speed_mm_s) const {
  const double seconds = std::max(0.0, kMaxListSeconds - jumps_.jump_delay_s) / 2;
  return 1000 * PlacesMs(speed_mm_s) * seconds / field_.places_per_mm();
}

LmcList GuideOutline::ListAt(double speed_mm_s) const {
  LmcList list;
  BeginList(board_, false, list);
  list.commands.push_back({kJumpSpeed, {ToUint16(PlacesMs(speed_mm_s))}});
  list.commands.push_back({kJumpDelay, {Microseconds(jumps_.jump_delay_s)}});
  return list;
}

bool GuideOutline::AddWay(const BoardPlace& to, BoardPlace& at, double speed_mm_s,
                          LmcList& list) const {
  const double way = PlacesBetween(at, to);
  const double seconds = way > 0
                             ? way / (1000 * PlacesMs(speed_mm_s)) + jumps_.jump_delay_s
                             : 1e-5 * kGuideRest;
  const bool has_room = list.seconds + seconds <= kMaxListSeconds &&
                        list.commands.size() + kSettings <= kMaxListCommands;
  if (list.seconds > 0 && !has_room) return false;
  if (way > 0) {
    list.commands.push_back({kJump,
                             {static_cast<std::uint16_t>(to.x),
                              static_cast<std::uint16_t>(to.y), 0, ToUint16(way)}});
  } else {
    list.commands.push_back({kDelay, {kGuideRest}});
  }
  list.seconds += seconds;
  at = to;
  return true;
}

LmcList GuideOutline::Next(BoardPlace& at) {
  const double speed_mm_s =
      has_begun_ ? speed_mm_s_ : std::numeric_limits<double>::infinity();
  LmcList list = ListAt(speed_mm_s);
  if (!has_begun_) {
    has_begun_ = true;
    (void)AddWay(field_.PlaceOf(way_mm_.front()), at, speed_mm_s, list);
  } else {
    const auto next = [&] { return (next_ + 1) % way_mm_.size(); };
    while (AddWay(field_.PlaceOf(way_mm_[next()]), at, speed_mm_s, list)) next_ = next();
  }
  list.commands.push_back({kEnd, {}});
  return list;
}

}  // namespace intaglio::drivers
