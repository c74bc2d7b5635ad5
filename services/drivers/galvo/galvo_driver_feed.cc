// The ticks of marks, as they are due.

#include <fmt/format.h>

#include <algorithm>

#include "services/drivers/galvo/galvo_driver.h"
#include "services/job/machine/head_ticks.h"

namespace intaglio::drivers {
namespace {

using link::HeadFrame;

// Marks whose beginning was announced and whose ticks were not all sent.
constexpr std::size_t kMaxAnnounced = 64;
// That a status does not count yet: a window of the line, and a block more.
constexpr std::uint32_t kTicksUnderWay = 33 * link::kMaxHeadTicks;
// On a piece at rest nothing is predicted, so more can be sent ahead.
constexpr double kRestAheadSeconds = 0.2;
// How long before its beginning the first block of a mark is sent that begins alone.
constexpr double kRestReserveSeconds = 0.05;
// Repeats without a print mark that a text names.
constexpr std::uint32_t kMaxSkippedNamed = 12;

}  // namespace

// Marks that were sent before it are still made.
void GalvoDriver::StopFor(const std::string& fault) {
  fault_ = fault;
  if (player_.playing() && player_.placed()) {
    (void)Stop();
  } else {
    ending_ = SendFrame(HeadFrame::kHeadFinish).has_value();
  }
}

void GalvoDriver::Announce() {
  while (announced_ < waiting_.size() && announced_ < kMaxAnnounced) {
    events_.push_back({run_, waiting_[announced_].number, MarkFate::kBegun});
    open_[waiting_[announced_].number] = true;
    ++announced_;
  }
}

/// In real time it goes on since the newest status.
std::uint64_t GalvoDriver::TickNow() const {
  if (identity_.lockstep) return status_.tick;
  const double since_s = std::chrono::duration<double>(clock_() - status_at_).count();
  return status_.tick + static_cast<std::uint64_t>(since_s * identity_.rate_hz);
}

void GalvoDriver::Pump() {
  if (held_) return;
  if (!ending_ && !pausing_) Announce();
  while (!ending_ && SendNext()) {
  }
  if (ending_ || pausing_ || !finishing_ || finish_sent_ || !waiting_.empty() ||
      player_.playing())
    return;
  finish_sent_ = SendFrame(HeadFrame::kHeadFinish).has_value();
}

/// Behind what was sent, and late enough for the line and for a host that loses its
/// processor for some milliseconds. In lockstep time waits.
std::uint64_t GalvoDriver::FirstTick(std::uint64_t now, bool web) const {
  const double reserve_s = identity_.lockstep ? 0
                           : web              ? AheadSeconds(head_) / 2
                                              : kRestReserveSeconds;
  return std::max(next_tick_,
                  now + 1 + static_cast<std::uint64_t>(reserve_s * identity_.rate_hz));
}

void GalvoDriver::DropFront() {
  waiting_.pop_front();
  --announced_;
  --taken_;
}

void GalvoDriver::LeaveOut(const NumberedMark& mark) {
  if (open_.erase(mark.number) != 0)
    events_.push_back({run_, mark.number, MarkFate::kNoPrintMark});
  const std::uint32_t repeat = RepeatOf(mark.mark.web_mm, eye_->pitch_mm);
  if (skipped_count_ > 0 && repeat == last_skipped_) return;
  last_skipped_ = repeat;
  if (++skipped_count_ > kMaxSkippedNamed) return;
  skipped_ += skipped_.empty() ? "repeat " : ", ";
  skipped_ += skipped_count_ < kMaxSkippedNamed ? fmt::format("{}", repeat + 1) : "more";
}

GalvoDriver::Next GalvoDriver::FindPrintMark(const NumberedMark& mark,
                                             std::optional<double>& origin_count) {
  if (!eye_) return Next::kLoaded;
  const std::uint32_t repeat = RepeatOf(mark.mark.web_mm, eye_->pitch_mm);
  switch (prints_.StateOf(repeat)) {
    case PrintTracker::State::kAwaited:
      return Next::kNothing;
    case PrintTracker::State::kLost:
      StopFor(prints_.LossText());
      return Next::kNothing;
    case PrintTracker::State::kMissing:
      LeaveOut(mark);
      DropFront();
      return Next::kLeftOut;
    case PrintTracker::State::kSeen:
      break;
  }
  // The print mark was at the eye then, and the origin lies beside it.
  origin_count = (prints_.PlaceOf(repeat) + head_.eye_mm() - eye_->offset_mm) /
                 player_.tracker().count_mm();
  return Next::kLoaded;
}

GalvoDriver::Next GalvoDriver::LoadNext() {
  // With a closed shutter the controller would break it.
  if (pausing_ || taken_ == 0 || !state_.shutter_open) return Next::kNothing;
  std::optional<double> origin_count;
  const Next found = FindPrintMark(waiting_.front(), origin_count);
  if (found != Next::kLoaded) return found;
  if (const Status loaded = player_.Load(waiting_.front(), origin_count); !loaded) {
    StopFor(loaded.error().message);
    return Next::kNothing;
  }
  DropFront();
  return Next::kLoaded;
}

bool GalvoDriver::SendBlock(link::HeadBlock block) {
  block.run = run_;
  if (!SendFrame(HeadFrame::kHeadBlock, Encode(block))) return false;
  credit_ -= static_cast<std::uint32_t>(block.ticks.size());
  next_tick_ =
      (block.first_tick != 0 ? block.first_tick : next_tick_) + block.ticks.size();
  return true;
}

/// False: nothing more for now.
bool GalvoDriver::SendNext() {
  if (!session_.CanSend() || credit_ < kTicksUnderWay) return false;
  const bool web = player_.tracker().follows();
  double ahead_s = AheadSeconds(head_);
  if (!web) ahead_s = std::max(ahead_s, kRestAheadSeconds);
  const auto ahead = static_cast<std::uint64_t>(ahead_s * identity_.rate_hz);
  const std::uint64_t now = TickNow();
  const std::uint64_t first = FirstTick(now, web);
  if (web ? first >= now + ahead : identity_.queue_ticks - credit_ > ahead) return false;
  // In lockstep a web moves no more than the ticks that were sent.
  const bool waits = web && identity_.lockstep;
  if (!player_.playing()) {
    const Next next = LoadNext();
    if (next == Next::kLeftOut) return true;
    if (next == Next::kNothing) {
      const bool awaits_print =
          eye_ && !ending_ && taken_ > 0 && !pausing_ && state_.shutter_open;
      return waits && awaits_print && SendBlock(player_.Hold(first));
    }
  }
  const bool placed = player_.placed();
  auto next = player_.NextBlock(placed ? next_tick_ : first);
  if (!next) {
    StopFor(next.error().message);
    return false;
  }
  if (!next->has_value()) return waits && SendBlock(player_.Hold(first));
  link::HeadBlock block = std::move(**next);
  // A mark on a piece at rest begins behind the one before, or where that one has ended
  // or ends too soon, a reserve later: with its first block alone it would be broken.
  const bool rests = !web && !identity_.lockstep;
  if (rests && !placed && next_tick_ < first) block.first_tick = first;
  if (!SendBlock(block)) return false;
  player_.Took(block);
  return true;
}

}  // namespace intaglio::drivers
