#pragma once

// A grbl behind a serial line, on a clock that the test moves: what a sender sees of grbl
// 1.1h or grblHAL, and what the laser and the stage really do.
//
//   host -> 115200 baud -> receive buffer -> one line at a time -> planner -> stepper
//                |                               |
//                +-- ? ! ~ 0x18 0x85: at once    +-- "ok": queued, not done
//
// Every fact that it follows is a test in virtual_grbl_test.cc, named after it; they were
// measured on grblHAL's simulator and on the AVR code of grbl 1.1h.
//
// WPos = MPos - work offset; G54 only, mm only, G0 G1 G2 G3 (with I J, in XY) G4 G10L20
// G90 G91 M3 M4 M5 M62-M65 S F N; anything else is error:20. Not simulated: probing,
// overrides, G28/G30.

#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "services/virtual_engraver/mill/virtual_grbl_motion.h"

namespace intaglio::grbl {

struct VirtualGrblOptions {
  bool hal = false;  ///< grblHAL; else grbl 1.1h
  std::string serial_number = "G-03";
  std::uint32_t baud = 115200;
  std::size_t receive_bytes = 128;
  double parse_us = 1540;        ///< of one line,
  double parse_us_per_byte = 0;  ///< and of each of its bytes
  MotionOptions motion;
  Vec3 travel_min_mm = Vec3::Constant(-50), travel_max_mm = Vec3::Constant(50);
  bool laser_mode = true;           ///< $32
  double max_power = 1000;          ///< $30
  double arc_tolerance_mm = 0.002;  ///< $12
  bool soft_limits = false;         ///< $20
  bool homing = false;              ///< $22: locked from power-up until $H or $X
  Steps home_steps{};               ///< where the switches are, counted as TrueSteps
  double home_mm_s = 25;
  bool reports_lines = true;  ///< Ln in the status
};

/// What was measured of both: 1023 bytes and 100 blocks; lines a second.
VirtualGrblOptions GrblHal();
VirtualGrblOptions Grbl11();

class VirtualGrbl {
 public:
  enum class State { kIdle, kRun, kHold, kJog, kDoor, kAlarm, kHome };

  explicit VirtualGrbl(VirtualGrblOptions options);

  /// The host writes; bytes arrive at the baud rate.
  void Write(std::string_view bytes);
  /// The host reads what has arrived there.
  std::string Read();
  void Advance(double us);

  // What happens at the machine.
  void SetDoor(bool open);
  /// The button of a feed hold.
  void PressHold() { (void)TakeRealtime('!'); }
  /// A limit switch is hit, and released again.
  void HitLimit();
  /// The button at the reset input: as 0x18, and whatever moves loses steps.
  void PressReset();
  /// Emergency stop of grblHAL: ALARM:10, no motion, and neither $X nor $H while it is
  /// pressed; after its release it is locked. grbl 1.1 has a contact of it at the reset
  /// input alone, which it reports and does not obey any more.
  void SetEmergencyStop(bool pressed);
  /// A drive's alarm that stops it at once.
  void FailDrive();
  /// error:20 in place of the line behind the next `lines`.
  void RefuseLineBehind(std::uint64_t lines) { takes_before_refusal_ = lines; }
  void RefuseNextLine() { RefuseLineBehind(0); }
  /// Without power nothing moves, is lit or answers.
  void SwitchOff();
  /// On again: everything but the work offset is forgotten. Also without SwitchOff.
  void PowerCycle();

  State state() const { return state_; }
  const VirtualGrblMotion& motion() const { return motion_; }
  Steps TrueSteps() const { return motion_.TrueSteps(); }
  bool spindle_on() const { return spindle_ != Spindle::kOff; }
  /// An output of M62..M65 is on; where it was switched on.
  bool output_on() const { return output_on_; }
  const Steps& output_at() const { return output_at_; }
  /// Bytes that came while the receive buffer was full, and are lost.
  std::uint64_t lost_bytes() const { return lost_bytes_; }
  std::uint64_t lines_taken() const { return lines_taken_; }
  /// How often 0x18 came.
  std::uint64_t resets_taken() const { return resets_taken_; }
  /// Whether the line of RefuseLineBehind has not come yet.
  bool refuses() const { return takes_before_refusal_.has_value(); }
  /// Every S above 0 that came.
  const std::set<double>& powers() const { return powers_; }
  /// Those of motions, in their order.
  const std::vector<double>& motion_powers() const { return motion_powers_; }
  /// Dead by a memory error of the firmware; only a power cycle helps.
  bool crashed() const { return crashed_; }
  Vec3 WorkPosition_mm() const { return motion_.Position_mm() - work_offset_mm_; }

 private:
  enum class Spindle { kOff, kConstant, kDynamic };
  struct GcodeLine;
  /// A line that is parsed and waits: for room in the planner, or for an empty one.
  struct Waiting {
    enum class For { kRoom, kEmpty, kDwell } reason = For::kEmpty;
    Steps target{};
    std::deque<Steps> later = {};  ///< chords of an arc behind the first
    double speed_mm_s = 0, power = 0;
    Beam beam = Beam::kDark;
    bool jog = false;
    std::int64_t line = 0;
    double dwell_us = 0;
    std::optional<Spindle> spindle = {};
    Vec3 offset_mm = Vec3::Zero();
    bool sets_offset = false;
  };

  void Slice(double us);
  void ReceiveBytes();
  void TakeByte(char byte);
  bool TakeRealtime(unsigned char byte);
  void TakeLines();
  bool suspended() const { return state_ == State::kHold || state_ == State::kDoor; }
  const char* stop_pin() const {
    return !emergency_stop_ ? "" : options_.hal ? "E" : "R";
  }
  void Execute(const std::string& line);
  void ExecuteSystem(const std::string& line);
  void PrintSettings();
  void ExecuteGcode(const std::string& line, bool jog);
  int QueueMotion(const GcodeLine& words, bool jog);
  int AddChords(const GcodeLine& words, const Vec3& to_mm, Waiting& wait) const;
  int CheckRange(const Vec3& machine_mm, bool jog);
  bool range_is_checked() const;
  void QueueWait(const GcodeLine& words);
  void FinishWaiting(double us);
  void CommandSpindle(Spindle spindle);
  Beam BeamOf(bool rapid) const;
  void BeginHome();
  void AdvanceHome(double us);
  void EndHome(int alarm);
  void Reset();
  void RaiseAlarm(int code);
  void UpdateState();
  void Report();
  void Send(std::string_view text);
  void Answer(int error);
  void Banner();
  const char* StateName() const;

  VirtualGrblOptions options_;
  VirtualGrblMotion motion_;
  double byte_us_;
  double now_us_ = 0;

  struct Timed {
    char byte;
    double at_us;
  };
  std::deque<Timed> to_grbl_, to_host_;
  std::deque<char> receive_buffer_;
  std::string line_;
  std::uint64_t lost_bytes_ = 0, lines_taken_ = 0, resets_taken_ = 0;
  double parses_until_us_ = 0;
  std::optional<std::string> parsing_;
  std::optional<Waiting> waiting_;

  State state_ = State::kIdle;
  bool mute_ = false, crashed_ = false, locked_ = false, homed_ = false;
  bool door_open_ = false, reports_ = false, off_ = false;
  bool emergency_stop_ = false;
  std::optional<std::uint64_t> takes_before_refusal_;
  int reports_to_offset_ = 0;  // WCO comes with every tenth

  Steps home_from_{}, home_way_{};  // of $H
  double home_us_ = 0, home_done_us_ = 0;

  // The parser's modal state.
  bool absolute_ = true, rapid_ = true;
  double feed_mm_min_ = 0, power_ = 0;
  std::set<double> powers_;
  std::vector<double> motion_powers_;
  Spindle spindle_ = Spindle::kOff;
  Vec3 work_offset_mm_ = Vec3::Zero();

  bool output_on_ = false;
  Steps output_at_{};
};

}  // namespace intaglio::grbl
