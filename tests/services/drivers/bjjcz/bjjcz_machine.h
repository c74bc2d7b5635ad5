#pragma once

// A virtual BJJCZ board behind a line that a test cuts, on a clock that the test moves.

#include <chrono>
#include <cstdint>
#include <memory>
#include <random>

#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"
#include "tests/services/drivers/bjjcz/virtual_bjjcz.h"
#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::drivers {

inline constexpr int kBjjczDoorInput = 3;
inline constexpr const char* kBjjczSerialNumber = "000142420017";

/// Board, line and mains switch.
class BjjczMachine {
 public:
  /// `interlocked`: a gate outside of the board cuts the laser where the door is open.
  explicit BjjczMachine(bool needs_oscillator, bool interlocked = false);
  BjjczMachine(const BjjczMachine&) = delete;
  BjjczMachine& operator=(const BjjczMachine&) = delete;

  /// A millisecond.
  void Advance();
  void Cut(bool cut);
  /// After so many bytes more to the board.
  void CutAfter(std::uint64_t bytes);
  void SwitchOff() { board.SwitchOff(); }
  void SwitchOn() { board.SwitchOn(); }
  /// Each opening is a connection of its own, through the same cable.
  link::StreamOpener Opener();
  link::SteadyClock clock() {
    return [this] { return now_; };
  }

  bjjcz::VirtualBjjcz board;

 private:
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::shared_ptr<link::FaultyPipe> to_board_, to_host_;
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::unique_ptr<link::ByteStream> end_;
};

}  // namespace intaglio::drivers
