#include "services/drivers/bjjcz/point_lists.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::drivers {
namespace {

using enum LmcOperation;

constexpr double kMiddlePlace = 32768, kBoardPlaces = 65536;
// A guide laser that has no way to go shows its place so long, 10 us.
constexpr std::uint16_t kGuideRest = 100;

}  // namespace

PointLists::PointLists(const MachineSpec& machine)
    : board_(machine.bjjcz_board()),
      jumps_(machine.head_over_block().jump_and_dwell()),
      places_per_mm_(kBoardPlaces / std::max(1e-3, machine.scan_head().field_mm())),
      max_points_(std::max(1U, machine.laser().max_unsettled_points())) {}

PointLists::Place PointLists::PlaceOf(const Vec2& at_mm) const {
  const auto place = [&](double mm) {
    return static_cast<int>(std::clamp(std::round(kMiddlePlace + mm * places_per_mm_),
                                       0.0, kBoardPlaces - 1));
  };
  return {place(at_mm.x()), place(at_mm.y())};
}

Vec2 PointLists::at_mm() const {
  return Vec2(at_[0] - kMiddlePlace, at_[1] - kMiddlePlace) / places_per_mm_;
}

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

void PointLists::AddJump(const Place& to) {
  if (to == at_ && std::exchange(has_jump_, true)) return;
  const double way = std::hypot(to[0] - at_[0], to[1] - at_[1]);
  list_.commands.push_back({kJump,
                            {static_cast<std::uint16_t>(to[0]),
                             static_cast<std::uint16_t>(to[1]), 0, ToUint16(way)}});
  at_ = to;
  has_jump_ = true;
}

bool PointLists::Add(const Vec2& to_mm, bool fires, double power_ratio) {
  const bool is_first = empty();
  Begin(jumps_.jump_mm_s() * places_per_mm_ / 1000, power_ratio);
  if (fires && power_ratio != power_ratio_) return false;
  const Place to = PlaceOf(to_mm);
  const double way = std::hypot(to[0] - at_[0], to[1] - at_[1]);
  const double seconds = way / (jumps_.jump_mm_s() * places_per_mm_) +
                         jumps_.jump_delay_s() + (fires ? jumps_.dwell_s() : 0);
  const bool has_room = list_.seconds + seconds <= kMaxListSeconds &&
                        list_.commands.size() + 3 <= kMaxListCommands &&
                        (!fires || point_count_ < max_points_);
  if (!is_first && !has_room) return false;
  AddJump(to);
  if (fires) ++point_count_;
  if (fires)
    list_.commands.push_back({kLaserOnPoint, {ToUint16(1e5 * jumps_.dwell_s())}});
  list_.seconds += seconds;
  return true;
}

void PointLists::AddSlow(const Vec2& to_mm, double seconds) {
  const Place to = PlaceOf(to_mm);
  const double way = std::hypot(to[0] - at_[0], to[1] - at_[1]);
  const double places_ms = std::max(1.0, std::floor(way / (1000 * seconds)));
  Begin(places_ms, power_ratio_);
  AddJump(to);
  const double jump_s = way / (1000 * places_ms), rest_s = seconds - jump_s;
  if (rest_s > 0) list_.commands.push_back({kDelay, {ToUint16(std::ceil(1e5 * rest_s))}});
  list_.seconds += std::max(jump_s, seconds) + jumps_.jump_delay_s();
}

double PointLists::GuidePlacesMs(double speed_mm_s) const {
  const double mm_s = std::min(speed_mm_s, jumps_.jump_mm_s());
  return std::max(1.0, std::floor(mm_s * places_per_mm_ / 1000));
}

double PointLists::GuideStepMm(double speed_mm_s) const {
  const double seconds = std::max(0.0, kMaxListSeconds - jumps_.jump_delay_s()) / 2;
  return 1000 * GuidePlacesMs(speed_mm_s) * seconds / places_per_mm_;
}

bool PointLists::AddGuide(const Vec2& to_mm, double speed_mm_s) {
  const double places_ms = GuidePlacesMs(speed_mm_s);
  const Place to = PlaceOf(to_mm);
  const double way = std::hypot(to[0] - at_[0], to[1] - at_[1]);
  const double seconds =
      way > 0 ? way / (1000 * places_ms) + jumps_.jump_delay_s() : 1e-5 * kGuideRest;
  if (empty()) {
    BeginList(board_, false, list_);
    list_.commands.push_back({kJumpSpeed, {ToUint16(places_ms)}});
    list_.commands.push_back({kJumpDelay, {Microseconds(jumps_.jump_delay_s())}});
    has_jump_ = true;
  } else if (list_.seconds + seconds > kMaxListSeconds ||
             list_.commands.size() + 2 > kMaxListCommands) {
    return false;
  }
  if (way > 0)
    AddJump(to);
  else
    list_.commands.push_back({kDelay, {kGuideRest}});
  list_.seconds += seconds;
  return true;
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
