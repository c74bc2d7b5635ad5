#pragma once

// The list that a BJJCZ board has, from its sending until BUSY is gone: one at a time.
// And what begins and ends one, which marks and points have in common.

#include <chrono>
#include <optional>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/lmc_line.h"

namespace intaglio::drivers {

inline constexpr double kMaxListSeconds = 0.15;
/// Boards take three before they execute them.
inline constexpr std::size_t kMaxListPackets = 3;
inline constexpr std::size_t kMaxListCommands = kMaxListPackets * kLmcPacketCommands - 1;

struct LmcList {
  std::vector<LmcCommand> commands;
  double seconds = 0;  ///< that the board takes, at most
};

/// The nearest that a board's number can be.
std::uint16_t ToUint16(double value);
std::uint16_t Microseconds(double seconds);

/// What the periods of the source's pulses are counted in, Hz.
double PeriodClockHz(const BjjczBoard& board);

/// Power and frequency of the source.
void AppendLaser(const BjjczBoard& board, double power_ratio, double frequency_hz,
                 std::vector<LmcCommand>& commands);

/// Begins a list; `first_of_run`: behind the start of a fibre laser's oscillator.
void BeginList(const BjjczBoard& board, bool first_of_run, LmcList& list);

/// Empties the board's list and writes this one, in packets.
void SendList(const LmcList& list, LmcLine& line);
/// Ends what the board executes, with these outputs on.
void SendStop(std::uint16_t outputs, LmcLine& line);

class PlayedList {
 public:
  explicit PlayedList(double seconds) : seconds_(seconds) {}

  double seconds() const { return seconds_; }
  /// Its execution may have begun.
  bool was_sent() const { return was_sent_; }
  void Execute(LmcLine& line);
  /// Takes each answer of the board.
  void Receive(const LmcAnswer& answer, std::chrono::nanoseconds now);
  /// A host that was late may have missed that the board was busy.
  bool HasEnded(bool busy, std::chrono::nanoseconds now) const;
  /// A board that executes it so much longer than it should is not the profile's.
  bool IsLate(std::chrono::nanoseconds now) const;

 private:
  double SecondsSince(std::chrono::nanoseconds now) const;

  double seconds_;
  bool was_sent_ = false, was_busy_ = false;
  std::optional<std::chrono::nanoseconds> executed_at_;
};

}  // namespace intaglio::drivers
