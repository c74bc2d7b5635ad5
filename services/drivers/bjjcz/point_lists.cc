#include "services/drivers/bjjcz/point_lists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "services/job/head/point_pulses.h"

namespace intaglio::drivers {

using enum LmcOperation;

/// A delay counts tens of microseconds.
constexpr double kShortestDelaySeconds = 1e-5;

PointLists::PointLists(const MachineSpec& machine)
    : machine_(machine),
      board_(machine.bjjcz_board()),
      jumps_(machine.head_over_block().jump_and_dwell()),
      field_(machine.scan_head().field_mm()),
      max_points_(std::max(1U, machine.laser().max_unsettled_points())) {}

void PointLists::Begin(double places_ms, double power_ratio) {
  if (!empty()) return;
  BeginList(board_, std::exchange(first_of_run_, false), list_);
  list_.commands.push_back({kJumpSpeed, {ToUint16(std::max(1.0, places_ms))}});
  power_ratio_ = power_ratio;
  AppendLaser(board_, power_ratio, board_.point_frequency_hz(), list_.commands);
  list_.commands.push_back({kJumpDelay, {Microseconds(jumps_.jump_delay_s())}});
  has_jump_ = false;
  point_count_ = 0;
}

void PointLists::AddJump(const BoardPlace& to) {
  if (to == at_ && std::exchange(has_jump_, true)) return;
  const double way = PlacesBetween(at_, to);
  list_.commands.push_back({kJump,
                            {static_cast<std::uint16_t>(to.x),
                             static_cast<std::uint16_t>(to.y), 0, ToUint16(way)}});
  at_ = to;
  has_jump_ = true;
}

bool PointLists::AddPause() {
  while (pause_s_ > 0) {
    const double part_s = std::min({pause_s_, kMaxListSeconds - list_.seconds,
                                    1e-5 * std::numeric_limits<std::uint16_t>::max()});
    if (part_s < kShortestDelaySeconds || list_.commands.size() + 3 > kMaxListCommands)
      return false;
    AddJump(at_);  // the mirrors stay
    list_.commands.push_back({kDelay, {ToUint16(std::ceil(1e5 * part_s))}});
    list_.seconds += part_s;
    pause_s_ = pause_s_ - part_s < kShortestDelaySeconds ? 0 : pause_s_ - part_s;
  }
  return true;
}

void PointLists::CountPoint() {
  ++point_count_;
  if (++points_since_pause_ != jumps_.pause_after_points()) return;
  points_since_pause_ = 0;
  pause_s_ = jumps_.pause_s();
}

bool PointLists::Add(const Vec2& to_mm, bool fires, double power_ratio, unsigned pulses) {
  const double dwell_s = pulses > 0 ? DwellSecondsOf(machine_, pulses) : jumps_.dwell_s();
  const bool is_first = empty() && pause_s_ == 0;
  Begin(jumps_.jump_mm_s() * field_.places_per_mm() / 1000, power_ratio);
  if (!AddPause()) return false;
  if (fires && power_ratio != power_ratio_) return false;
  const BoardPlace to = field_.PlaceOf(to_mm);
  const double way = PlacesBetween(at_, to);
  const double seconds = way / (jumps_.jump_mm_s() * field_.places_per_mm()) +
                         jumps_.jump_delay_s() + (fires ? dwell_s : 0);
  const bool has_room = list_.seconds + seconds <= kMaxListSeconds &&
                        list_.commands.size() + 3 <= kMaxListCommands &&
                        (!fires || point_count_ < max_points_);
  if (!is_first && !has_room) return false;
  AddJump(to);
  if (fires) CountPoint();
  if (fires) list_.commands.push_back({kLaserOnPoint, {ToUint16(1e5 * dwell_s)}});
  list_.seconds += seconds;
  return true;
}

void PointLists::AddSlow(const Vec2& to_mm, double seconds) {
  const BoardPlace to = field_.PlaceOf(to_mm);
  const double way = PlacesBetween(at_, to);
  const double places_ms = std::max(1.0, std::floor(way / (1000 * seconds)));
  Begin(places_ms, power_ratio_);
  AddJump(to);
  const double jump_s = way / (1000 * places_ms), rest_s = seconds - jump_s;
  if (rest_s > 0) list_.commands.push_back({kDelay, {ToUint16(std::ceil(1e5 * rest_s))}});
  list_.seconds += std::max(jump_s, seconds) + jumps_.jump_delay_s();
}

LmcList PointLists::Take() {
  LmcList list = std::exchange(list_, {});
  list.commands.push_back({kEnd, {}});
  return list;
}

void PointLists::Drop() {
  list_ = {};
  at_ = begun_at_;
}

}  // namespace intaglio::drivers
