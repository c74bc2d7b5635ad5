// The ticks of marks, as they are due.

#include <algorithm>

#include "services/drivers/galvo/galvo_driver.h"

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

}  // namespace

// Marks that were sent before it are still made.
void GalvoDriver::StopFor(const std::string& fault) {
  fault_ = fault;
  if (player_.placed()) {
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
  if (!player_.playing()) {
    // With a closed shutter the controller would break it.
    if (pausing_ || taken_ == 0 || !state_.shutter_open) return false;
    const Status loaded = player_.Load(waiting_.front());
    if (!loaded) {
      StopFor(loaded.error().message);
      return false;
    }
    waiting_.pop_front();
    --announced_;
    --taken_;
  }
  const bool placed = player_.placed();
  auto next = player_.NextBlock(placed ? next_tick_ : first);
  if (!next) {
    StopFor(next.error().message);
    return false;
  }
  const bool holds = !next->has_value();
  if (holds && !(web && identity_.lockstep)) return false;
  link::HeadBlock block = holds ? player_.Hold(first) : std::move(**next);
  block.run = run_;
  // A mark on a piece at rest begins behind the one before, or where that one has ended
  // or ends too soon, a reserve later: with its first block alone it would be broken.
  const bool rests = !web && !identity_.lockstep;
  if (rests && !placed && next_tick_ < first) block.first_tick = first;
  if (!SendFrame(HeadFrame::kHeadBlock, Encode(block))) return false;
  credit_ -= static_cast<std::uint32_t>(block.ticks.size());
  next_tick_ =
      (block.first_tick != 0 ? block.first_tick : next_tick_) + block.ticks.size();
  if (!holds) player_.Took(block);
  return true;
}

}  // namespace intaglio::drivers
