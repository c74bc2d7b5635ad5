#include "services/virtual_engraver/head/head_controller.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::virtual_engraver {
namespace {

using link::HeadMarkFate;
using link::HeadRunState;

constexpr double kHeadRate_hz = 1e5;
constexpr std::chrono::milliseconds kPermitLease{250};
constexpr std::uint16_t kWebStepTicks = 100;
// Only the newest are kept for a host that does not receive them.
constexpr std::size_t kMaxWebSamples = 4096;

}  // namespace

HeadController::HeadController(const HeadOptions& options,
                               std::function<void(const formats::BurntTick&)> burn,
                               std::function<void(const formats::PrintMark&)> print)
    : options_(options),
      burn_(std::move(burn)),
      print_(std::move(print)),
      physics_(options.physics) {}

link::HeadIdentity HeadController::Identity() const {
  return {options_.power_up,
          options_.lockstep,
          kHeadRate_hz,
          options_.physics.field_mm,
          options_.queue_ticks,
          HeadMemory::kMarks,
          options_.physics.eye_mm.has_value(),
          "virtual head",
          options_.serial_number};
}

void HeadController::NewSession() {
  LoseHost();
  run_state_ = HeadRunState::kNone;
  drops_taken_ = 0;
  memory_.DropReports();
  web_.samples.clear();
  unsent_prints_.clear();
}

void HeadController::LoseHost() {
  permitted_ = false;
  if (run_state_ == HeadRunState::kOpen) EnterSafeState(HeadRunState::kNoPermit);
}

void HeadController::Permit(bool permitted, std::chrono::nanoseconds now) {
  if (!permitted) {
    ++drops_taken_;
    permitted_ = false;
    EndRun(HeadRunState::kStopped);
    return;
  }
  permitted_ = !safe_state_ && !interlocked();
  permitted_at_ = now;
}

void HeadController::Begin(const link::HeadBegin& begin) {
  if (run_state_ == HeadRunState::kOpen || safe_state_ || interlocked()) return;
  run_ = begin.run;
  run_state_ = HeadRunState::kOpen;
  last_begun_ = last_done_ = link::kNoHeadMark;
  finishing_ = pausing_ = false;
}

void HeadController::Receive(link::HeadBlock block) {
  const auto note_dropped = [&] {
    for (const link::HeadEdge& edge : block.edges)
      if (edge.begins) memory_.Note(block.run, edge.mark, HeadMarkFate::kNotBegun);
  };
  const auto size = static_cast<std::uint32_t>(block.ticks.size());
  if (run_state_ != HeadRunState::kOpen || block.run != run_) return note_dropped();
  if (size > options_.queue_ticks - queued_ticks_) {
    note_dropped();
    return EnterSafeState(HeadRunState::kBadBlock);
  }
  queued_ticks_ += size;
  queue_.push_back({std::move(block)});
}

void HeadController::Pause() {
  ++drops_taken_;
  if (run_state_ != HeadRunState::kOpen) return;
  pausing_ = true;
  if (!in_hand_) EndRun(HeadRunState::kPaused);
}

void HeadController::Finish() {
  finishing_ = true;
  if (queue_.empty() && !in_hand_) EndRun(HeadRunState::kFinished);
}

void HeadController::Stop() {
  ++drops_taken_;
  permitted_ = false;
  EndRun(HeadRunState::kStopped);
}

void HeadController::Reset() {
  ++drops_taken_;
  if (!interlocked()) safe_state_ = false;
}

void HeadController::Watch(std::chrono::nanoseconds now) {
  // Its time waits for the host, which wall time does not measure.
  if (options_.lockstep || !permitted_ || now - permitted_at_ <= kPermitLease) return;
  permitted_ = false;
  if (run_state_ == HeadRunState::kOpen) EnterSafeState(HeadRunState::kNoPermit);
}

void HeadController::Set(bool& holds, bool now) {
  if (holds && !now) ++openings_;
  holds = now;
  if (now) return;
  permitted_ = false;
  EnterSafeState(HeadRunState::kInterlocked);
}

void HeadController::EnterSafeState(HeadRunState why) {
  safe_state_ = true;
  permitted_ = false;
  EndRun(why);
}

void HeadController::EndRun(HeadRunState why) {
  if (run_state_ != HeadRunState::kOpen) return;
  run_state_ = why;
  output_.laser = false;
  if (in_hand_) memory_.Note(run_, in_hand_->mark, HeadMarkFate::kBroken);
  in_hand_.reset();
  for (const Queued& queued : queue_) {
    for (std::size_t i = queued.next_edge; i < queued.block.edges.size(); ++i) {
      const link::HeadEdge& edge = queued.block.edges[i];
      if (edge.begins) memory_.Note(run_, edge.mark, HeadMarkFate::kNotBegun);
    }
  }
  queue_.clear();
  queued_ticks_ = 0;
}

/// Those before the next tick. False: the run has ended.
bool HeadController::PassEdges(Queued& queued) {
  while (queued.next_edge < queued.block.edges.size() &&
         queued.block.edges[queued.next_edge].at == queued.next_tick) {
    const link::HeadEdge edge = queued.block.edges[queued.next_edge];
    if (edge.begins ? in_hand_.has_value() : !in_hand_ || in_hand_->mark != edge.mark) {
      EnterSafeState(HeadRunState::kBadBlock);
      return false;
    }
    ++queued.next_edge;
    memory_.Note(run_, edge.mark,
                 edge.begins ? HeadMarkFate::kBegun : HeadMarkFate::kDone);
    if (edge.begins) {
      in_hand_ = edge;
      last_begun_ = edge.mark;
      continue;
    }
    in_hand_.reset();
    last_done_ = edge.mark;
    if (!pausing_) continue;
    EndRun(HeadRunState::kPaused);
    return false;
  }
  return true;
}

bool HeadController::FollowWeb(const link::HeadFollow& follow, std::size_t at,
                               link::HeadTick& tick) const {
  if (follow.x_per_count == 0) return true;
  const double expected = follow.count + static_cast<double>(at) * follow.counts_per_tick;
  const double elsewhere = web_counter_.Ahead(follow.lead_ticks) - expected;
  const double x = tick.x + follow.x_per_count * elsewhere;
  const double held = std::clamp(x, 0.0, 65535.0);
  tick.x = static_cast<std::uint16_t>(std::lround(held));
  return !tick.laser || held == x;
}

void HeadController::Output(const link::HeadTick& tick) {
  output_ = tick;
  output_.laser = tick.laser && in_hand_ && permitted_ && !safe_state_;
  // A mark that the beam does not make is not made.
  if (tick.laser && !output_.laser) EnterSafeState(HeadRunState::kNoPermit);
  const Vec2 from_mm = physics_.PlaceOnMaterial();
  physics_.PassTick(tick.x, tick.y, 1 / kHeadRate_hz);
  if (!output_.laser) return;
  const Vec2 to_mm = physics_.PlaceOnMaterial();
  burn_({tick_, to_mm, to_mm - from_mm,
         1e3 * options_.laser_w * in_hand_->power_ratio / kHeadRate_hz, run_,
         in_hand_->mark});
}

void HeadController::PassTick() {
  ++tick_;
  const bool due = !queue_.empty() && (queue_.front().next_tick > 0 ||
                                       queue_.front().block.first_tick <= tick_);
  if (due && queue_.front().next_tick == 0 && queue_.front().block.first_tick != 0 &&
      queue_.front().block.first_tick < tick_) {
    EnterSafeState(HeadRunState::kUnderrun);
  } else if (!due && in_hand_) {
    EnterSafeState(HeadRunState::kUnderrun);
  }
  if (due && !queue_.empty() && PassEdges(queue_.front())) {
    Queued& queued = queue_.front();
    const std::size_t at = queued.next_tick++;
    link::HeadTick tick = queued.block.ticks[at];
    --queued_ticks_;
    if (FollowWeb(queued.block.follow, at, tick)) {
      Output(tick);
    } else {
      EnterSafeState(HeadRunState::kOutside);
    }
    if (!queue_.empty() && PassEdges(queue_.front()) &&
        queue_.front().next_tick == queue_.front().block.ticks.size())
      queue_.pop_front();
  } else {
    output_.laser = false;
    physics_.PassTick(output_.x, output_.y, 1 / kHeadRate_hz);
  }
  if (finishing_ && queue_.empty()) EndRun(HeadRunState::kFinished);
  web_counter_.Update(physics_.ReadEncoder());
  LatchPrints();
  if (tick_ % kWebStepTicks == 0) SampleWeb();
}

void HeadController::LatchPrints() {
  while (const auto seen = physics_.SeePrint()) {
    ++prints_;
    unsent_prints_.push_back({tick_, web_counter_.Ahead(0)});
    if (seen->printed) print_({tick_, seen->place_mm});
  }
}

std::vector<link::HeadPrint> HeadController::TakePrints() {
  std::vector<link::HeadPrint> frames;
  auto first = static_cast<std::uint32_t>(prints_ - unsent_prints_.size());
  for (const link::HeadPrintMark& mark : unsent_prints_) {
    if (frames.empty() || frames.back().marks.size() == link::kMaxHeadPrints)
      frames.push_back({first, {}});
    frames.back().marks.push_back(mark);
    ++first;
  }
  unsent_prints_.clear();
  return frames;
}

void HeadController::SampleWeb() {
  if (web_.samples.size() == kMaxWebSamples) web_.samples.clear();
  if (web_.samples.empty()) web_.first_tick = tick_;
  web_.step_ticks = kWebStepTicks;
  web_.samples.push_back(
      {physics_.ReadEncoder(), static_cast<float>(physics_.ReadEdge())});
}

std::vector<link::HeadWeb> HeadController::TakeWeb() {
  std::vector<link::HeadWeb> frames;
  for (std::size_t i = 0; i < web_.samples.size(); i += link::kMaxHeadSamples) {
    link::HeadWeb frame{web_.first_tick + i * kWebStepTicks, kWebStepTicks, {}};
    for (std::size_t k = i; k < web_.samples.size() && k < i + link::kMaxHeadSamples; ++k)
      frame.samples.push_back(web_.samples[k]);
    frames.push_back(std::move(frame));
  }
  web_.samples.clear();
  return frames;
}

link::HeadStatus HeadController::Status() const {
  link::HeadStatus status;
  status.tick = tick_;
  const auto bit = [](bool set, int value) { return set ? value : 0; };
  status.interlocks = static_cast<std::uint8_t>(
      bit(key_on_, link::kHeadKeyOn) | bit(door_closed_, link::kHeadDoorClosed) |
      bit(stop_released_, link::kHeadStopReleased) |
      bit(safe_state_, link::kHeadSafeState) | bit(permitted_, link::kHeadShutterOpen) |
      bit(output_.laser, link::kHeadLaserOn));
  status.x = output_.x;
  status.y = output_.y;
  status.queued_ticks = queued_ticks_;
  status.free_ticks = options_.queue_ticks - queued_ticks_;
  if (!web_.samples.empty()) {
    status.encoder_count = web_.samples.back().encoder_count;
    status.edge_mm = web_.samples.back().edge_mm;
    status.sampled_tick =
        web_.first_tick + (web_.samples.size() - 1) * std::uint64_t{kWebStepTicks};
  }
  status.openings = openings_;
  status.run = run_;
  status.run_state = run_state_;
  status.last_begun = last_begun_;
  status.last_done = last_done_;
  status.drops_taken = drops_taken_;
  status.prints = prints_;
  return status;
}

}  // namespace intaglio::virtual_engraver
