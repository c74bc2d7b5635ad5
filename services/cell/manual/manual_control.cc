#include "services/cell/manual/manual_control.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/platform/bus/manual_orders.h"
#include "services/platform/bus/open_chain.h"

namespace intaglio::cell {
namespace {

using namespace std::chrono_literals;

// At 50 states a second, more than two seconds; what is older is stale anyway.
constexpr std::size_t kRemembered = 128;
// Clients come and go; the oldest names are of processes that have ended.
constexpr std::size_t kMaxSenders = 256;

/// The number of this sender; the map keeps kMaxSenders at most.
std::uint64_t& NumberOf(const std::string& sender,
                        std::map<std::string, std::uint64_t>& numbers) {
  if (numbers.size() >= kMaxSenders && !numbers.contains(sender))
    numbers.erase(numbers.begin());
  return numbers[sender];
}

bool IsLight(intaglio_ManualCommandKind kind) {
  return kind == intaglio_MANUAL_LAMP || kind == intaglio_MANUAL_SHUTTER;
}

bool GoesToAPlace(intaglio_ManualCommandKind kind) {
  return kind == intaglio_MANUAL_JOG || kind == intaglio_MANUAL_MOVE ||
         kind == intaglio_MANUAL_BLOCK;
}

/// How far it goes on when key, door and stop are no longer reported.
std::string WayWithoutReport(double speed_mm_s) {
  return fmt::format("at {:g} mm/s at most {:.1f} mm and the braking distance",
                     speed_mm_s,
                     speed_mm_s * std::chrono::duration<double>(kInterlockTime).count());
}

/// Key, door and stop.
bool AreKnown(const ManualConditions& conditions, bool homes,
              std::chrono::nanoseconds now) {
  if (conditions.interlocks_at.count() < 0) return false;
  const auto since = now - conditions.interlocks_at;
  return since + (homes ? 0ns : conditions.interlocks_age) <= kInterlockTime;
}

constexpr const char* kNoPermission =
    "no job service answers for this machine: motion by hand needs its consent; start it";
constexpr const char* kInterlocksUnknown =
    "key and door are not known, because the laser controller does not answer: check the "
    "synchronizer and the laser line";

std::string DoneText(const ManualOrder& order, const Vec3& position) {
  if (order.kind != intaglio_TEACH_ZERO) return "";
  return fmt::format("the work zero is set: the tool is at {:.3f}, {:.3f}, {:.3f}",
                     position.x(), position.y(), position.z());
}

}  // namespace

std::string WhyNoMotionByHand(const ManualConditions& conditions,
                              const drivers::DriverState& state, const ManualOrder& order,
                              std::chrono::nanoseconds now) {
  const bool by_cell = order.by_cell;
  if (!state.link_up) return "the stage does not answer: " + state.message;
  if (conditions.run_active) return "a job moves the stage: pause it first";
  if (!by_cell && !conditions.permission_fresh) {
    return kNoPermission;
  }
  if (!by_cell && conditions.job_armed) return kJobIsArmed;
  if (conditions.stop_pressed)
    return "the emergency stop is pressed: release it with `intaglio stop --reset`";
  if (!AreKnown(conditions, order.kind == intaglio_MANUAL_HOME, now) ||
      !conditions.laser_line_up) {
    return kInterlocksUnknown;
  }
  if (bus::IsChainOpen(conditions.key_on, conditions.door_closed,
                       conditions.stop_released)) {
    return fmt::format("{}: close them", bus::kChainIsOpen);
  }
  if (!conditions.key_on) return "the key is off: turn it on";
  if (!conditions.door_closed) return "the door is open: close it";
  if (!conditions.stop_released)
    return "the machine's stop button is pressed, or its stop is latched: release it, "
           "then `intaglio stop --reset`";
  return "";
}

void ManualControl::NotePublished(std::uint64_t number, Nanoseconds now) {
  if (!first_published_) first_published_ = number;
  published_.emplace_back(number, now);
  if (published_.size() > kRemembered) published_.pop_front();
}

std::optional<ManualControl::Nanoseconds> ManualControl::PublishedAt(
    std::uint64_t number) const {
  for (const auto& [known, at] : published_) {
    if (known == number) return at;
  }
  return std::nullopt;
}

bool ManualControl::IsFresh(std::uint64_t seen, Nanoseconds now) const {
  const auto at = PublishedAt(seen);
  return at && now - *at <= kHeldTime;
}

bool ManualControl::IsNew(const ManualOrder& order) const {
  const auto spent = spent_.find(order.sender);
  return spent == spent_.end() || order.number > spent->second;
}

bool ManualControl::RefusesEarlier(const ManualOrder& order) {
  const bool began_here =
      first_published_ &&
      bus::BeganAmong(order.number, *first_published_, published_.back().first);
  if (order.by_cell || began_here) return false;
  std::uint64_t& refused = NumberOf(order.sender, earlier_);
  if (refused == order.number) return true;
  refused = order.number;
  answer_ = {.sender = order.sender,
             .number = order.number,
             .code = intaglio_MANUAL_REFUSED,
             .message =
                 "it began before the service of this machine was started again: "
                 "let go, and give it again"};
  return true;
}

void ManualControl::Answer(const ManualOrder& order, intaglio_ManualAnswer code,
                           std::string message) {
  answer_ = {.sender = order.sender,
             .number = order.number,
             .code = code,
             .message = std::move(message)};
  answer_.reports_missing =
      code == intaglio_MANUAL_REFUSED &&
      (answer_.message == kNoPermission || answer_.message == kInterlocksUnknown);
  if (code == intaglio_MANUAL_ACCEPTED) return;
  std::uint64_t& spent = NumberOf(order.sender, spent_);
  spent = std::max(spent, order.number);
}

void ManualControl::LoseSender(const std::string& sender) {
  if (moves() && order_.sender == sender) let_go_ = true;
}

void ManualControl::Receive(const ManualOrder& order, Nanoseconds now) {
  const bool of_mover = moves() && order.sender == order_.sender;
  if (of_mover && (order.kind == intaglio_MANUAL_NONE || order.number != order_.number))
    let_go_ = true;
  if (order.kind == intaglio_MANUAL_NONE || !IsNew(order)) return;
  const auto made_at = PublishedAt(order.seen);
  if (!made_at || now - *made_at > kHeldTime) return;  // its sender repeats a live one
  if (RefusesEarlier(order)) return;
  if (of_mover && order.number == order_.number) {
    held_at_ = std::max(held_at_, *made_at);
  } else if (moves() && !of_mover) {
    Answer(order, intaglio_MANUAL_REFUSED,
           fmt::format(
               "{} {}: wait until it has let go", order_.sender,
               IsLight(order_.kind) ? "has lamp or shutter by hand" : "moves the stage"));
  } else {
    pending_ = order;
  }
}

// A person may need the whole length of axes whose place is lost, in either direction.
Box3 ManualControl::LimitsNow() const {
  if (driver_.state().place_lost.empty()) return limits_;
  const Vec3 length = limits_.max_mm - limits_.min_mm;
  return {limits_.min_mm - length, limits_.max_mm + length};
}

Result<Vec3> ManualControl::TargetOf(const ManualOrder& order) const {
  const Vec3 here = driver_.state().position_mm;
  const Box3 limits = LimitsNow();
  if (!order.place.allFinite())
    return Fail(ErrorCode::kInvalidValue, "the place is no number");
  if (order.kind == intaglio_MANUAL_MOVE) {
    for (int i = 0; i < 3; ++i) {
      if (order.place[i] >= limits.min_mm[i] && order.place[i] <= limits.max_mm[i])
        continue;
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{} {:.6g} is outside the limits, {:g} to {:g}",
                              names_[static_cast<std::size_t>(i)], order.place[i],
                              limits.min_mm[i], limits.max_mm[i]));
    }
    return order.place;
  }
  // As far as every axis may go.
  double share = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double d = order.place[i];
    if (d == 0) continue;
    const double end = d > 0 ? limits.max_mm[i] : limits.min_mm[i];
    share = std::min(share, std::max(0.0, (end - here[i]) / d));
  }
  if (!std::isfinite(share))
    return Fail(ErrorCode::kInvalidValue, "a jog needs a direction");
  return (here + share * order.place)
      .cwiseMax(limits.min_mm.cwiseMin(here))
      .cwiseMin(limits.max_mm.cwiseMax(here));
}

Status ManualControl::CheckOutline(const ManualOrder& order) const {
  const Box3 limits = LimitsNow();
  for (const Vec2& corner : order.corners) {
    for (int i = 0; i < 2; ++i) {
      if (corner[i] >= limits.min_mm[i] && corner[i] <= limits.max_mm[i]) continue;
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{} {:.6g} of the outline is outside the limits, {:g} to "
                              "{:g}: check the zero, and where the job is in the block",
                              names_[static_cast<std::size_t>(i)], corner[i],
                              limits.min_mm[i], limits.max_mm[i]));
    }
  }
  return {};
}

Status ManualControl::Start(const ManualOrder& order) {
  if (IsLight(order.kind) && channels_ == 0) {
    return Fail(ErrorCode::kUnsupported,
                "this machine has neither lamp nor shutter that is switched by hand");
  }
  if (order.kind == intaglio_MANUAL_LAMP) return {};
  if (order.kind == intaglio_MANUAL_SHUTTER) {
    if (order.channel >= 1 && order.channel <= channels_) return {};
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("channel {}: the machine has 1 to {}", order.channel, channels_));
  }
  if (order.kind == intaglio_MANUAL_HOME) return driver_.Home();
  if (order.kind == intaglio_TEACH_ZERO) {
    return driver_.SetZero(order.place, {(order.sets & 1) != 0, (order.sets & 2) != 0,
                                         (order.sets & 4) != 0});
  }
  if (!(order.speed_mm_s > 0)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("speed {} mm/s: give one above 0", order.speed_mm_s));
  }
  if (order.kind == intaglio_MANUAL_OUTLINE) {
    const Status inside = CheckOutline(order);
    return inside ? driver_.DrawOutline(order.corners, order.speed_mm_s) : inside;
  }
  if (order.kind == intaglio_MANUAL_BLOCK) {
    if (!order.by_cell) {
      return Fail(
          ErrorCode::kRefused,
          "the stage that carries the block moves for a job alone, when it is armed: "
          "submit a job with the block_place that you need, and arm it");
    }
    speed_mm_s_ = std::min(order.speed_mm_s, kMaxSpeedMmS);
    return driver_.MoveBlock(order.place.head<2>(), speed_mm_s_);
  }
  const auto target = TargetOf(order);
  if (!target) return tl::unexpected(target.error());
  speed_mm_s_ = std::min(order.speed_mm_s, kMaxSpeedMmS);
  return driver_.Jog(*target, speed_mm_s_);
}

void ManualControl::Begin(const ManualOrder& order, const ManualConditions& conditions,
                          Nanoseconds now) {
  if (!IsFresh(order.seen, now)) return Answer(order, intaglio_MANUAL_STOPPED, "let go");
  std::string why = WhyNoMotionByHand(conditions, driver_.state(), order, now);
  if (!why.empty()) return Answer(order, intaglio_MANUAL_REFUSED, std::move(why));
  if (order.by_cell && !driver_.state().place_lost.empty())
    return Answer(order, intaglio_MANUAL_REFUSED, driver_.state().place_lost);
  // No command brings air back.
  if (!IsLight(order.kind) && driver_.state().fault == intaglio_MOTION_NO_AIR)
    return Answer(order, intaglio_MANUAL_REFUSED, driver_.state().message);
  // A fault of before; the order is repeated while it is held.
  if (!IsLight(order.kind) && driver_.state().fault != intaglio_MOTION_OK) {
    (void)driver_.ClearFault();
    pending_ = order;
    return;
  }
  if (auto started = Start(order); !started)
    return Answer(order, intaglio_MANUAL_REFUSED, started.error().message);
  order_ = order;
  held_at_ = *PublishedAt(order.seen);
  began_at_ = now;
  let_go_ = hold_owed_ = was_lit_ = false;
  stopped_by_.clear();
  phase_ = Phase::kMoving;
  Answer(
      order, intaglio_MANUAL_ACCEPTED,
      GoesToAPlace(order.kind)
          ? fmt::format("without a report of key, door and stop it ends after {} ms: {}",
                        kInterlockTime.count(), WayWithoutReport(speed_mm_s_))
          : "");
}

// The stage rests all the time; the synchronizer switches off what is not held any more.
void ManualControl::TurnLight(std::string why, const ManualConditions& conditions,
                              Nanoseconds now) {
  const bool lit = order_.kind == intaglio_MANUAL_LAMP
                       ? conditions.lamp_on
                       : (conditions.shutters_open & MaskOf(order_.channel)) != 0;
  if (why.empty() && was_lit_ && !lit) {
    why =
        "the laser controller has switched it off: check its state (intaglio teach "
        "status)";
  }
  if (why.empty() && !lit && now - began_at_ > kLightTime) {
    why =
        "the laser controller has not switched it on within 2 s: check the interlocks "
        "(intaglio teach status), whether a job has this machine (intaglio list), and "
        "the synchronizer's log";
  }
  was_lit_ = was_lit_ || lit;
  if (why.empty()) return;
  phase_ = Phase::kResting;
  Answer(order_, intaglio_MANUAL_STOPPED, std::move(why));
}

void ManualControl::Brake(std::string why) {
  phase_ = Phase::kBraking;
  stopped_by_ = std::move(why);
  hold_owed_ = !driver_.Hold();
}

std::string ManualControl::WhyEnded(const ManualConditions& conditions,
                                    Nanoseconds now) const {
  const drivers::DriverState& state = driver_.state();
  std::string why = WhyNoMotionByHand(conditions, state, order_, now);
  if (GoesToAPlace(order_.kind) && state.link_up && !AreKnown(conditions, false, now)) {
    why += fmt::format(
        "; the motion was ended {} ms after the last report of key, door and stop: {}",
        kInterlockTime.count(), WayWithoutReport(speed_mm_s_));
  }
  if (why.empty() && !IsLight(order_.kind) && state.fault != intaglio_MOTION_OK)
    why = state.message;
  if (why.empty() && (let_go_ || now - held_at_ > kHeldTime)) why = "let go";
  return why;
}

void ManualControl::Turn(const ManualConditions& conditions, Nanoseconds now) {
  const drivers::DriverState& state = driver_.state();
  if (phase_ == Phase::kMoving) {
    const bool light = IsLight(order_.kind);
    std::string why = WhyEnded(conditions, now);
    if (light) {
      TurnLight(std::move(why), conditions, now);
    } else if (!why.empty()) {
      Brake(std::move(why));
    } else if (state.at_rest) {
      phase_ = Phase::kResting;
      Answer(order_, intaglio_MANUAL_DONE, DoneText(order_, state.position_mm));
    }
  }
  if (phase_ == Phase::kBraking) {
    if (hold_owed_) hold_owed_ = !driver_.Hold();
    // The controller itself ends the motion when its line is lost.
    if (state.link_up && (hold_owed_ || !state.at_rest)) return;
    phase_ = Phase::kResting;
    Answer(order_, intaglio_MANUAL_STOPPED, stopped_by_);
  }
  if (phase_ == Phase::kResting && pending_) {
    const ManualOrder order = *std::exchange(pending_, std::nullopt);
    if (IsNew(order)) Begin(order, conditions, now);
  }
}

}  // namespace intaglio::cell
