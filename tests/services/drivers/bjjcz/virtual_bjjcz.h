#pragma once

// A BJJCZ board of the tests' own, in simulated time: it takes the bytes of any host, by
// the public descriptions of the protocol, and records what beam and mirrors did. It
// shares no code with the driver.
//
// The beam is on while it marks, from the delay of its begin to that of its end, if its
// source may emit: laser enabled, gate output on, and of a fibre source the master
// oscillator. It plays a list to the end, whatever the host does.

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

namespace intaglio::bjjcz {

struct VirtualBjjczOptions {
  std::array<std::uint16_t, 3> serial_number = {0x0001, 0x4242, 0x0017};
  int gate_output = 0;
  bool needs_oscillator = true;
  /// While it is low, a gate outside of the board cuts the laser; -1: there is none.
  int interlock_input = -1;
  /// Not taken while so many packets wait: no READY.
  std::size_t packets = 4;
};

/// The laser was on at rest.
struct Flash {
  std::array<double, 2> at{};  ///< places of the board
  std::int32_t axis = 0;       ///< steps
  double begin_us = 0, lit_us = 0;
  std::uint16_t current = 0, power_ratio = 0;  ///< as of a Stroke
  /// So many periods of the source were in the time that it was lit: to the nearest,
  /// since nobody knows where in a period the light began.
  int pulses = 0;
};

/// One command of a list that moved the mirrors, when it has ended or was stopped.
struct Stroke {
  std::array<double, 2> from{}, to{};  ///< places of the board, 32768 the centre
  double begin_us = 0, end_us = 0;     ///< since the board was made
  double lit_us = 0;                   ///< of it with the beam on
  bool is_mark = false;
  std::uint16_t outputs = 0;                       ///< at its beginning
  std::uint16_t current = 0, q_switch_period = 0;  ///< of a fibre source
  std::uint16_t mark_period = 0, power_ratio = 0;  ///< of CO2 and UV
};

class VirtualBjjcz {
 public:
  explicit VirtualBjjcz(VirtualBjjczOptions options) : options_(options) {}

  /// Bytes of a host, in any pieces. What is no command of the protocol is counted.
  void Write(const std::string& bytes);
  std::string Read();
  /// Another host, or the same again: half a command is forgotten.
  void Reopen();
  void Advance(double us);

  void SetInput(int input, bool high);
  void SwitchOff();
  void SwitchOn();

  const std::vector<Stroke>& strokes() const { return strokes_; }
  const std::vector<Flash>& flashes() const { return flashes_; }
  /// Where the mirrors are now.
  std::array<double, 2> place() const;
  /// Steps of its axis, since its power-up or its origin.
  double axis() const { return axis_; }
  /// Somebody homes it at the machine, or turns it by hand.
  void SetAxis(std::int32_t steps) { axis_ = axis_to_ = steps; }
  /// A list is executed, or the axis moves.
  bool moves() const { return executes_ || axis_ != axis_to_; }
  bool lit() const { return lit_; }
  /// The master oscillator of a fibre source is on.
  bool oscillates() const { return oscillator_; }
  /// Grows with every step of the beam's time, and of the mirrors' way.
  std::uint64_t work_count() const { return work_count_; }
  std::uint16_t outputs() const { return outputs_; }
  /// Correction lines of the newest table, in the order in which they came.
  const std::vector<std::array<std::uint16_t, 2>>& correction() const {
    return correction_;
  }
  std::uint64_t lists_executed() const { return lists_executed_; }
  std::uint64_t unknown_count() const { return unknown_count_; }

 private:
  using Numbers = std::array<std::uint16_t, 6>;

  void TakeCommand(const Numbers& numbers);
  void Answer(std::array<std::uint16_t, 3> numbers);
  std::uint16_t Status() const;
  /// What executes takes from `left_us`; false: nothing more is due.
  bool Step(double& left_us);
  void BeginCommand(const Numbers& numbers);
  void EndMotion();
  int PulsesIn(double lit_us) const;
  bool MayEmit() const;
  void AdvanceAxis(double us);

  VirtualBjjczOptions options_;
  bool on_ = true;
  std::string in_, out_;
  double now_us_ = 0;
  std::uint16_t inputs_ = 0xFFFF, outputs_ = 0;
  bool enabled_ = false, oscillator_ = false, executes_ = false;
  std::deque<Numbers> list_;
  // They belong to the command in hand.
  bool moves_ = false, waits_ = false;
  Stroke stroke_;
  double left_us_ = 0, total_us_ = 0, settle_us_ = 0;
  std::array<double, 2> at_ = {32768, 32768};
  bool lit_ = false, follows_mark_ = false;
  double off_left_us_ = 0, on_left_us_ = 0;
  // Settings of lists.
  double jump_speed_ = 1000, mark_speed_ = 100;  ///< places/ms
  double on_delay_us_ = 0, off_delay_us_ = 0, jump_delay_us_ = 0, polygon_delay_us_ = 0;
  Stroke laser_;  ///< whose settings each stroke has
  std::vector<Stroke> strokes_;
  bool is_point_ = false;  ///< it waits with the laser on
  Flash flash_;
  std::vector<Flash> flashes_;
  double axis_ = 0, axis_to_ = 0;
  double axis_speed_ = 1000;  ///< steps/s
  std::vector<std::array<std::uint16_t, 2>> correction_;
  std::uint64_t work_count_ = 0, lists_executed_ = 0, unknown_count_ = 0;
};

}  // namespace intaglio::bjjcz
