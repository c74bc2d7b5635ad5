#pragma once

// Lamp syncs, from the thread of the laser to that of the stage. One thread calls Push,
// one calls Pop; neither waits. What finds no room is dropped: the stage then latches no
// place for that tick.

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>

namespace intaglio::reference_controller {

struct TickNotice {
  std::uint64_t tick = 0;
  std::chrono::nanoseconds at{0};  ///< of the lamp sync, on the clock of both
  double rate_hz = 1;              ///< of the lamp
};

class TickRing {
 public:
  void Push(const TickNotice& notice) {
    const std::uint32_t pushed = pushed_.load(std::memory_order_relaxed);
    if (pushed - popped_.load(std::memory_order_acquire) == ring_.size()) return;
    ring_[pushed % ring_.size()] = notice;
    pushed_.store(pushed + 1, std::memory_order_release);
  }
  std::optional<TickNotice> Pop() {
    const std::uint32_t popped = popped_.load(std::memory_order_relaxed);
    if (popped == pushed_.load(std::memory_order_acquire)) return std::nullopt;
    const TickNotice notice = ring_[popped % ring_.size()];
    popped_.store(popped + 1, std::memory_order_release);
    return notice;
  }

 private:
  std::array<TickNotice, 256> ring_;
  std::atomic<std::uint32_t> pushed_{0}, popped_{0};
};

}  // namespace intaglio::reference_controller
