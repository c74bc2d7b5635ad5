#pragma once

// An isel stepper controller behind a serial line, on a clock that the test moves: what a
// sender sees of it, and what stage and laser output really do.
//
//   host -> 19200 baud -> receive buffer -> one command at a time -> axes, output
//                |                                   |
//                +-- bytes 253 254 255: at once      +-- one character, no line end:
//                                                        '0' when it is done
//
// The facts that it follows are the tests of virtual_isel_test.cc, each named after its
// fact. Assumed, for no source describes it: a command that comes during a move waits in
// the receive buffer; an axis runs at its own constant speed; opening the cover stops a
// move and does not switch the output. Places in steps, speeds in steps/s.

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::isel {

using Steps = std::array<std::int32_t, 3>;

struct VirtualIselOptions {
  std::uint32_t baud = 19200;
  double command_us = 800;  ///< from the last byte of a command to its begin
  std::int32_t min_speed = 21, max_speed = 10000;
  std::int32_t home_speed = 2000;
  Steps travel_min = {0, 0, 0}, travel_max = {120000, 120000, 40000};
};

/// The output from on to off, with the place at which it was switched on.
struct Flash {
  Steps place;
  double on_us = 0, off_us = 0;
  bool moved = false;  ///< an axis ran meanwhile
};

class VirtualIsel {
 public:
  explicit VirtualIsel(VirtualIselOptions options = {});

  /// The host writes; bytes arrive at the baud rate.
  void Write(std::string_view bytes);
  /// The host reads what has arrived there.
  std::string Read();
  void Advance(double us);

  void SetCover(bool open);
  /// A hand on the controller's stop key.
  void PressStop() { StopMove('F'); }
  /// Another host, or a hand at the panel, moves the axis by so many steps.
  void MoveAtPanel(std::size_t axis, std::int32_t steps) { place_[axis] += steps; }
  /// A person initializes it and drives it to its reference, at its panel; at once.
  void HomeAtPanel();
  /// Off and on again: neither initialized nor referenced, at the counter's zero.
  void PowerCycle();

  Steps place() const { return place_; }
  bool moves() const { return moving_; }
  bool output() const { return output_; }
  const std::vector<Flash>& flashes() const { return flashes_; }
  double now_us() const { return now_us_; }

 private:
  struct Byte {
    double at_us;
    char value;
  };

  void Receive(char byte);
  void Obey(const std::string& command);
  char BeginMove(const std::string& numbers, bool relative);
  char BeginHome();
  char SetOutput(const std::string& numbers);
  std::string Position() const;
  void AdvanceMove();
  void EndMove(char answer);
  void StopMove(char answer);
  void Answer(const std::string& text);

  VirtualIselOptions options_;
  double now_us_ = 0, arrives_at_us_ = 0, sent_at_us_ = 0;
  std::deque<Byte> to_controller_, to_host_;
  std::string receive_buffer_;
  double ready_at_us_ = 0;  // the next command begins no sooner
  int axes_ = 0;            // 0: not initialized
  bool referenced_ = false, cover_open_ = false, output_ = false;
  bool moving_ = false, homing_ = false;
  double began_us_ = 0;
  Steps place_{}, from_{}, target_{}, speed_{};
  Steps zero_{};  // of the counter that @0P reports
  std::vector<Flash> flashes_;
};

}  // namespace intaglio::isel
