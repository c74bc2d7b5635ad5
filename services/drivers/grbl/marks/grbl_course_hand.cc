#include "services/drivers/grbl/marks/grbl_course_hand.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "engrave/core/try.h"

namespace intaglio::drivers {
namespace {

constexpr char kCancelJog = static_cast<char>(0x85);

Status RefuseByHand(std::string why) { return Fail(ErrorCode::kRefused, std::move(why)); }

}  // namespace

Status GrblCourseHand::Begin(What what) {
  if (!state_.link_up) return RefuseByHand("the line to the controller is down");
  if (line_.stop_is_pressed())
    return RefuseByHand("the emergency stop is pressed: release it");
  if (state_.fault != intaglio_MOTION_OK) return RefuseByHand(state_.message);
  if (!state_.at_rest || active()) return RefuseByHand("the tool is not at rest");
  if (what != What::kHome && !line_.takes_lines()) {
    return RefuseByHand(
        "the controller is locked, and does not know where its axes are: home it "
        "(`intaglio teach home`)");
  }
  what_ = what;
  dark_ = cancelled_ = all_sent_ = placed_ = homed_ = false;
  sent_.clear();
  state_.at_rest = false;
  return {};
}

Status GrblCourseHand::Jog(const Vec3& axes_mm, double speed_mm_s) {
  if (!axes_mm.allFinite() || !(speed_mm_s > 0)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("jog to {:g}, {:g}, {:g} at {:g} mm/s: give numbers and a "
                            "speed above 0",
                            axes_mm.x(), axes_mm.y(), axes_mm.z(), speed_mm_s));
  }
  INTAGLIO_TRY(Begin(What::kJog));
  to_mm_ = axes_mm;
  sent_mm_ = 0;
  speed_mm_s_ = speed_mm_s;
  return {};
}

Status GrblCourseHand::Home() {
  if (state_.link_up && !line_.traits().homing) {
    return RefuseByHand(
        "the controller does not home: $22 is 0; set $22=1 if its axes have switches");
  }
  return Begin(What::kHome);
}

Status GrblCourseHand::SetZero(const Vec3& here_mm, const std::array<bool, 3>& sets) {
  if (!here_mm.allFinite() || std::ranges::find(sets, true) == sets.end()) {
    return Fail(ErrorCode::kInvalidValue,
                "a zero needs numbers, and one of the axes x, y and z at least");
  }
  INTAGLIO_TRY(Begin(What::kZero));
  to_mm_ = here_mm;
  sets_ = sets;
  return {};
}

Status GrblCourseHand::Hold() {
  if (what_ == What::kJog) cancelled_ = true;
  if (what_ != What::kHome) return {};
  if (all_sent_) line_.Reset();
  End();
  return {};
}

Status GrblCourseHand::ClearFault() {
  if (refused_) {
    refused_.reset();
    return {};
  }
  return reset_();
}

Box3 GrblCourseHand::reach() const {
  constexpr double kAnywhere_mm = 1e9;
  if (what_ == What::kHome)
    return {Vec3::Constant(-kAnywhere_mm), Vec3::Constant(kAnywhere_mm)};
  Vec3 to_mm = to_mm_;
  for (int i = 0; i < 3; ++i) {
    if (what_ == What::kZero && !sets_[static_cast<std::size_t>(i)])
      to_mm[i] = state_.position_mm[i];
  }
  return {state_.position_mm.cwiseMin(to_mm), state_.position_mm.cwiseMax(to_mm)};
}

void GrblCourseHand::End() {
  what_ = What::kNone;
  sent_.clear();
}

void GrblCourseHand::Receive(const GrblLine::Event& event) {
  status_is_behind_ = std::holds_alternative<GrblStatus>(event);
  if (status_is_behind_) return;
  if (const auto* error = std::get_if<GrblError>(&event)) {
    refused_ = "the controller refused the motion: " + TextOfGrblError(error->code);
    cancelled_ = true;
    if (what_ == What::kHome) return End();
  }
  homed_ = homed_ || std::holds_alternative<GrblHomed>(event);
  const bool answer =
      std::holds_alternative<GrblOk>(event) || std::holds_alternative<GrblError>(event);
  const auto first = std::ranges::find(sent_, false, &Sent::acknowledged);
  if (!answer || first == sent_.end()) return;
  first->acknowledged = true;
  const bool is_zero = what_ == What::kZero && all_sent_ && first + 1 == sent_.end();
  if (is_zero && std::holds_alternative<GrblOk>(event)) line_.TakeZero(sets_);
  if (first->blocks == 0) sent_.erase(sent_.begin(), first + 1);
}

// A status behind the last answer has the place and the zero. One that came before it, in
// the same bytes that a busy host read at once, has those from before the zero.
void GrblCourseHand::TakeStatus(const GrblStatus& status) {
  const bool all = std::ranges::all_of(sent_, &Sent::acknowledged);
  if (all && !status_is_behind_) return;
  if (all && status.state == GrblState::kIdle) {
    sent_.clear();
    if (dark_ && !placed_ && status.work_mm) {
      placed_ = true;
      from_mm_ = *status.work_mm;
      moves_.Begin(from_mm_, line_.traits().steps_per_mm);
    }
    WatchJog(status);
    const bool is_home = homed_ && line_.takes_lines();
    if (what_ == What::kHome ? is_home : all_sent_ || cancelled_) End();
  } else if (status.free_blocks >= 0) {
    auto executed = std::ranges::count(sent_, true, &Sent::acknowledged) -
                    (line_.traits().planner_blocks - status.free_blocks);
    for (; executed > 0 && !sent_.empty(); --executed) sent_.pop_front();
    WatchJog(status);
  }
}

void GrblCourseHand::WatchJog(const GrblStatus& status) {
  if (what_ != What::kJog || cancelled_ || !placed_) return;
  const auto unanswered = std::ranges::count(sent_, false, &Sent::acknowledged);
  moves_.TakeStatus(status, sent_.size(), static_cast<std::size_t>(unanswered));
  if (moves_.was_cut()) stopped_(WhyGrblJogWasCut());
}

void GrblCourseHand::TakeState(const MarkDeviceState& mark, const GrblStatus& status,
                               bool runs) {
  const bool is_new = mark.number != state_.number;
  grbl_ = status.state;
  state_.link_up = mark.link_up;
  state_.number = mark.number;
  state_.refusal = mark.refusal;
  if (is_new && active()) TakeStatus(status);
  // A controller with switches is locked until it has homed: that is no fault.
  const bool locked = (line_.locked() || what_ == What::kHome) && line_.traits().homing;
  const std::string& fault = refused_ ? *refused_ : mark.fault;
  const bool faulted = !fault.empty() && (refused_ || !locked);
  state_.homed = !locked || homed_;
  state_.fault = !mark.link_up ? intaglio_MOTION_LINK_LOST
                 : faulted     ? intaglio_MOTION_SAFE_STATE
                               : intaglio_MOTION_OK;
  state_.message = !mark.link_up ? mark.message : faulted ? fault : "";
  state_.position_mm = mark.position_mm;
  state_.at_rest = !runs && !active() && status.at_rest();
}

bool GrblCourseHand::SendDark() {
  if (dark_) return true;
  dark_ = line_.Send({"M5S0"});
  if (dark_) Sends(0, 0);
  return dark_;
}

void GrblCourseHand::Sends(double seconds, int blocks) {
  sent_.push_back({seconds, blocks, false});
}

double GrblCourseHand::AheadSeconds() const {
  double ahead_s = 0;
  for (const Sent& one : sent_) ahead_s += one.seconds;
  return ahead_s;
}

void GrblCourseHand::Feed() {
  if (what_ == What::kHome) {
    // A controller that is locked is dark since its reset, and takes $H alone.
    if (all_sent_ || (!line_.locked() && !SendDark()) || !sent_.empty()) return;
    all_sent_ = line_.SendHome();
    return;
  }
  if (!active() || !line_.takes_lines() || !SendDark()) return;
  if (what_ == What::kZero) return FeedZero();
  FeedJog();
}

void GrblCourseHand::FeedZero() {
  if (all_sent_) return;
  all_sent_ = line_.Send({ZeroLine(to_mm_, sets_)});
  if (all_sent_) Sends(0, 0);
}

void GrblCourseHand::FeedJog() {
  if (cancelled_) {
    // A line may be parsed behind the first one; so it is repeated while one moves.
    const bool moves = grbl_ == GrblState::kJog || !sent_.empty();
    if (moves && !line_.has_unsent()) line_.SendRealtime(kCancelJog);
    return;
  }
  if (!placed_) return;
  const double length_mm = (to_mm_ - from_mm_).norm();
  while (!all_sent_ && moves_.may_send() && AheadSeconds() < kAhead_s) {
    const double end_mm = std::min(length_mm, sent_mm_ + speed_mm_s_ * kPiece_s);
    const Vec3 to_mm = length_mm > 0
                           ? Vec3(from_mm_ + (to_mm_ - from_mm_) * (end_mm / length_mm))
                           : to_mm_;
    const auto line = moves_.Line(to_mm, speed_mm_s_);
    if (line && !line_.Send({*line})) return;
    if (line) {
      moves_.TakeSent(to_mm);
      Sends((end_mm - sent_mm_) / speed_mm_s_, 1);
    }
    sent_mm_ = end_mm;
    all_sent_ = end_mm >= length_mm;
  }
}

}  // namespace intaglio::drivers
