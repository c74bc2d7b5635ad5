#include "services/virtual_engraver/mill/virtual_grbl_motion.h"

#include <algorithm>
#include <cmath>

namespace intaglio::grbl {
namespace {

constexpr double kUsPerS = 1e6;
constexpr double kTinyMm = 1e-9;
// A speed that counts as rest: below it a step takes longer than a minute.
constexpr double kRest_mm_s = 1e-6;

}  // namespace

void VirtualGrblMotion::Add(const Steps& target, double speed_mm_s, Beam beam, bool jog,
                            std::int64_t line, double power) {
  Block block;
  block.from = planned_end();
  block.target = target;
  Vec3 way;
  for (int i = 0; i < 3; ++i) {
    way[i] = static_cast<double>(target[i] - block.from[i]) / options_.steps_per_mm;
  }
  block.length_mm = way.norm();
  if (block.length_mm == 0) return;
  block.unit = way / block.length_mm;
  block.nominal_mm_s = std::min(speed_mm_s, options_.max_speed_mm_s);
  block.beam = beam;
  block.jog = jog;
  block.line = line;
  block.power = power;
  if (!blocks_.empty()) block.junction_mm_s = JunctionSpeed(blocks_.back(), block);
  blocks_.push_back(block);
  Replan();
}

// planner.c, plan_buffer_line: of the angle between both blocks, cos = -u1.u2.
double VirtualGrblMotion::JunctionSpeed(const Block& before, const Block& block) const {
  const double cosine = -before.unit.dot(block.unit);
  const double nominal = std::min(before.nominal_mm_s, block.nominal_mm_s);
  if (cosine > 0.999999) return 0;
  if (cosine < -0.999999) return nominal;
  const double half_sine = std::sqrt(0.5 * (1 - cosine));
  return std::min(nominal,
                  std::sqrt(options_.acceleration_mm_s2 * options_.junction_deviation_mm *
                            half_sine / (1 - half_sine)));
}

void VirtualGrblMotion::Replan() {
  double exit = 0;
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    const double reachable =
        std::sqrt(exit * exit +
                  2 * options_.acceleration_mm_s2 * (block->length_mm - block->done_mm));
    block->entry_mm_s = std::min(block->junction_mm_s, reachable);
    exit = block->entry_mm_s;
  }
}

bool VirtualGrblMotion::CommandedLit() const {
  if (forced_dark_) return false;
  const bool executes = !blocks_.empty() && (speed_mm_s_ > 0 || blocks_.front().begun);
  if (!executes) return resting_lit_;
  const Block& block = blocks_.front();
  if (block.lost) return false;
  if (block.beam == Beam::kConstant) return true;
  return block.beam == Beam::kDynamic && speed_mm_s_ > 0;
}

Steps VirtualGrblMotion::PlusUncounted(const Steps& counted) const {
  Steps steps = counted;
  for (std::size_t i = 0; i < 3; ++i) steps[i] += uncounted_[i];
  return steps;
}

void VirtualGrblMotion::CountAs(const Steps& at) {
  const Steps is = TrueSteps();
  at_ = at;
  for (std::size_t i = 0; i < 3; ++i) uncounted_[i] = is[i] - at[i];
}

void VirtualGrblMotion::SetOutput(bool lit) {
  if (lit == lit_) return;
  EndWay();
  lit_ = lit;
  if (lit) {
    flashes_.push_back({now_us_, now_us_, TrueSteps(), TrueSteps(), 0, line()});
  } else {
    flashes_.back().off_us = now_us_;
    flashes_.back().off_at = TrueSteps();
  }
}

void VirtualGrblMotion::EndWay() {
  way_.push_back(
      {now_us_, TrueSteps(), lit_, blocks_.empty() ? 0 : blocks_.front().power});
}

void VirtualGrblMotion::Pass(double us, bool moves) {
  now_us_ += us;
  if (!lit_) return;
  flashes_.back().off_us = now_us_;
  flashes_.back().off_at = TrueSteps();
  if (moves) return;
  flashes_.back().at_rest_us += us;
  lit_at_rest_us_ += us;
}

void VirtualGrblMotion::Move(Block& block, double mm) {
  block.done_mm = std::min(block.length_mm, block.done_mm + mm);
  const double share = block.done_mm / block.length_mm;
  for (int i = 0; i < 3; ++i) {
    const auto way = static_cast<double>(block.target[i] - block.from[i]);
    const std::int64_t now = block.from[i] + std::llround(way * share);
    steps_made_ += static_cast<std::uint64_t>(std::abs(now - at_[i]));
    at_[i] = now;
  }
}

// For at most `us` from the speed `from` to `to`; returns the time that it took.
double VirtualGrblMotion::Accelerate(Block& block, double from, double to, double us) {
  const double sign = to > from ? 1 : -1, a = options_.acceleration_mm_s2;
  const double time_s = std::min(us / kUsPerS, std::abs(to - from) / a);
  Move(block, from * time_s + 0.5 * sign * a * time_s * time_s);
  speed_mm_s_ = std::max(0.0, from + sign * a * time_s);
  return time_s * kUsPerS;
}

void VirtualGrblMotion::Begin(Block& block) {
  block.begun = true;
  if (block.beam != Beam::kDynamic || options_.lose_dynamic_every == 0) return;
  if (speed_mm_s_ >= block.nominal_mm_s) return;
  block.lost = ++dynamic_starts_ % options_.lose_dynamic_every == 0;
}

void VirtualGrblMotion::EndBlock() {
  at_ = blocks_.front().target;
  EndWay();
  if (blocks_.front().beam == Beam::kConstant) resting_lit_ = true;
  if (blocks_.front().beam == Beam::kDark) resting_lit_ = false;
  blocks_.pop_front();
  if (blocks_.empty()) speed_mm_s_ = 0;
}

// A phase of the trapezoid: up to the nominal speed, along, or down to the exit speed.
double VirtualGrblMotion::RunBlock(double us) {
  Block& block = blocks_.front();
  const double a = options_.acceleration_mm_s2, v = speed_mm_s_;
  const double left = block.length_mm - block.done_mm;
  if (holding_) return Accelerate(block, v, 0, us);
  const double exit = blocks_.size() > 1 ? blocks_[1].entry_mm_s : 0;
  const double to_brake = std::max(0.0, (v * v - exit * exit) / (2 * a));
  if (to_brake >= left - kTinyMm) {
    const double took = Accelerate(block, v, exit, us);
    // us in s and back may be less than us by a rounding.
    if (took < us - 1e-6 || v <= exit) block.done_mm = block.length_mm;
    return took;
  }
  if (v < block.nominal_mm_s) {
    // The speed at which it has to begin to brake: v^2 + 2 a s = exit^2 + 2 a (left - s).
    const double peak = std::sqrt((v * v + exit * exit) / 2 + a * left);
    return Accelerate(block, v, std::min(peak, block.nominal_mm_s), us);
  }
  const double time_us = std::min(us, (left - to_brake) / v * kUsPerS);
  Move(block, v * time_us / kUsPerS);
  return time_us;
}

void VirtualGrblMotion::Advance(double us) {
  while (us > 1e-6) {
    double part = us;
    if (options_.pwm_period_us > 0) {
      const double next = std::floor(now_us_ / options_.pwm_period_us + 1 + 1e-9) *
                          options_.pwm_period_us;
      part = std::min(part, next - now_us_);
    }
    if (holding_ && speed_mm_s_ < kRest_mm_s) {
      speed_mm_s_ = 0;
      if (flush_at_rest_) {
        if (!blocks_.empty() && blocks_.front().begun) {
          resting_lit_ = blocks_.front().beam == Beam::kConstant;
        }
        Flush();
      }
    }
    const bool moves = !blocks_.empty() && !holding_;
    if (moves && !blocks_.front().begun) Begin(blocks_.front());
    const bool braking = !blocks_.empty() && holding_ && speed_mm_s_ > 0;
    if (moves || braking) {
      // The output of a block begins with it, before its first step.
      const double v = speed_mm_s_;
      if (v == 0) speed_mm_s_ = kRest_mm_s;
      if (options_.pwm_period_us == 0) SetOutput(CommandedLit());
      speed_mm_s_ = v;
      part = std::max(RunBlock(part), 1e-6);
      Pass(part, true);
      if (blocks_.front().length_mm - blocks_.front().done_mm <= kTinyMm) EndBlock();
    } else {
      if (options_.pwm_period_us == 0) SetOutput(CommandedLit());
      Pass(part, false);
    }
    if (options_.pwm_period_us > 0 &&
        std::fmod(now_us_ + 1e-6, options_.pwm_period_us) < 2e-6) {
      SetOutput(CommandedLit());
    }
    us -= part;
  }
}

void VirtualGrblMotion::Flush() {
  if (!blocks_.empty()) EndWay();
  blocks_.clear();
  speed_mm_s_ = 0;
  holding_ = flush_at_rest_ = false;
}

void VirtualGrblMotion::Kill() {
  Flush();
  resting_lit_ = false;
  SetOutput(false);
}

}  // namespace intaglio::grbl
