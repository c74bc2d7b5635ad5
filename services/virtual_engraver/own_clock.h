#pragma once

// The oscillator of a stage controller that does not run on the laser's ticks, and how it
// is notified of them: the laser's controller sends it a notice over a serial line, each
// time late by 0 .. receive_jitter_s, in the order of the ticks. Time is machine time,
// the lamp's.

#include <cstdint>
#include <deque>
#include <optional>
#include <random>

namespace intaglio::virtual_engraver {

struct OwnClockOptions {
  double drift_ppm = 0;         ///< -200..200; above 0: it is fast
  double receive_jitter_s = 0;  ///< 0..0.002
  std::uint32_t power_up = 1;   ///< random number of this power-up, not 0
  unsigned seed = 0;            ///< of the jitter
};

class OwnClock {
 public:
  explicit OwnClock(const OwnClockOptions& options);

  /// From now on; a crystal that warms up.
  void SetDrift(double drift_ppm) { drift_ppm_ = drift_ppm; }
  std::uint32_t power_up() const { return power_up_; }
  /// Own time since power-up, ns.
  std::uint64_t now_ns() const { return static_cast<std::uint64_t>(now_ns_); }
  std::uint64_t NsAfter(double seconds) const;
  void Advance(double seconds);
  /// A real one, which no machine time drives, has come to this time.
  void Show(std::uint64_t now_ns) { now_ns_ = static_cast<double>(now_ns); }

  /// A lamp sync passes now; its notice will follow.
  void ReceiveTick(std::uint64_t tick);
  struct Received {
    std::uint64_t tick = 0;
    std::uint64_t at_ns = 0;
  };
  /// The next notice that arrives by `ns`; it is then removed.
  std::optional<Received> ReceivesBy(std::uint64_t ns);

 private:
  double drift_ppm_;
  double jitter_ns_;
  std::uint32_t power_up_;
  std::mt19937_64 random_;
  double now_ns_;
  std::uint64_t received_by_ns_ = 0;
  std::deque<Received> underway_;
};

}  // namespace intaglio::virtual_engraver
