#pragma once

// The line to one controller of the grbl family: opens it, brings the controller to a
// known state, streams lines into its receive buffer, and notices when it is lost.
//
//   kClosed --open--> kAsking --at rest: 0x18--> kResetting --banner--> kIdentifying
//                      ^  ^                                                  | $I, $$
//                      |  +-- no answer for 250 ms, or a banner unasked      v
//                      +----------------------------------------- kUp <------+-->
//                      kRefused
//
// kAsking sends '?' and, once, '!' to a controller that moves for a host of before, and
// $G at rest to one that was set up: behind half a line it makes one that means nothing.
// The reset at rest drops what an earlier host left in the receive buffer, also half a
// line, is dark, and keeps the position; no line is sent before it. A hold that this host
// did not ask for is a person's: it is reported behind GrblUp (GrblHeld).
//
// A reset, or an unlock, is sent once, and no line before a status that was made behind
// it has come.
//
// Where the tool is may be unknown to the controller: after its power-up, a reset by
// another, an alarm and an unlock. place_is_lost() is true until it has homed or a person
// has set its zero. That it was switched off or reset while the line was down shows as a
// banner, as a place that nothing which was sent leads to, or by its modes ($G), which a
// reset and a power-up forget. One that does not answer $G, or lost the line before it
// was set up, was switched off if it is at the zero of its axes, where each power-up
// begins.
//
// A line of the set-up that is refused is reported, and no line is sent until Recover,
// which a person's new grant leads to, has sent the set-up once more.
//
// Lines are counted by their characters: what is not acknowledged never exceeds the
// receive buffer, so no byte is lost in it. Realtime commands need no room.

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "services/drivers/grbl/grbl_text.h"
#include "services/drivers/lockstep/controller_line.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/expected_device.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// What the controller reports of itself in $I and $$.
struct GrblTraits {
  std::string version, serial_number;
  int planner_blocks = 15, receive_bytes = 128;
  Vec3 steps_per_mm = Vec3::Zero();
  Vec3 max_speed_mm_s = Vec3::Zero();  ///< $110 .. $112
  double arc_tolerance_mm = 0.002;     ///< $12
  double max_power = 0;                ///< $30: S of full power, or a spindle's most rpm
  bool laser_mode = false;
  bool homing = false;  ///< $22: it has switches, and is locked from power-up until $H
};

/// What its output switches. In laser mode ($32=1) the output is off at rest and in G0:
/// so a laser needs it, and a spindle, which has to turn there, must not have it.
enum class GrblTool { kLaser, kSpindle };

struct GrblUp {};      ///< a session has begun: the controller is at rest, empty and dark
struct GrblHomed {};   ///< what SendHome began has ended well
struct GrblLost {};    ///< the line, or the controller's memory of what was sent
struct GrblHeld {};    ///< it was on hold, by a person, when the session began
struct GrblNotSetUp {  ///< it refused a line of the set-up, and takes none
  int code = 0;
};

class GrblLine final : public ControllerLine {
 public:
  /// A GrblStatus has work_mm. In the order in which they came. GrblOk and GrblError are
  /// of Send's lines alone.
  using Event = std::variant<GrblUp, GrblLost, GrblOk, GrblError, GrblAlarm, GrblStatus,
                             GrblHomed, GrblHeld, GrblNotSetUp>;

  GrblLine(link::StreamOpener open, link::SteadyClock clock,
           link::ExpectedDevice expected, GrblTool tool = GrblTool::kLaser);

  /// Moves bytes; appends what has happened.
  void Poll(std::vector<Event>& events);

  /// Also for a while after its own reset.
  bool up() const override { return phase_ == Phase::kUp || resets_itself_; }
  /// Lines are taken: up, unlocked and set up.
  bool takes_lines() const { return is_ready() && set_up_; }
  /// The newest status is an alarm.
  bool locked() const { return needs_recovery() && alarm_; }
  /// It takes no line before Recover, or a home: it is locked, or its set-up was refused.
  bool needs_recovery() const { return is_ready() && !set_up_; }
  /// A reset was sent, and its answer has not come.
  bool resetting() const { return phase_ == Phase::kResetting; }
  const GrblTraits& traits() const { return traits_; }
  /// How often an input of the chain was seen to open: the safety door's, the emergency
  /// stop's of grblHAL, or the reset's, where a contact of the emergency stop may be.
  std::uint32_t chain_openings() const { return chain_openings_; }
  bool door_is_open() const { return door_open_; }
  bool stop_is_pressed() const { return stop_pressed_; }
  bool chain_is_open() const { return door_open_ || stop_pressed_; }
  /// The controller may not know where its tool is.
  bool place_is_lost() const { return lost_axes_ != std::array<bool, 3>{}; }
  /// A person has set the zero of these axes where the tool is.
  void TakeZero(const std::array<bool, 3>& sets);
  /// Of G54 and what is added to it; none: not reported yet.
  const std::optional<Vec3>& work_offset_mm() const { return work_offset_mm_; }

  /// Bytes that the receive buffer has room for.
  std::size_t Room() const;
  bool idle() const { return outstanding_.empty(); }
  /// All places to which what was sent can lead, in work coordinates. A controller that
  /// rests elsewhere when the line comes back was switched off, or moved by another.
  void SetReach(const Box3& reach) { reach_ = reach; }
  /// All of these lines in one write, or none: false.
  bool Send(const std::vector<std::string>& lines);
  bool has_unsent() const { return !out_.empty(); }
  /// '!' and 0x85.
  void SendRealtime(char command);
  /// 0x18: dark with the last step, everything that was sent is forgotten. The session
  /// stays.
  void Reset();
  /// To a controller that takes lines, once for each call of a caller who repeats it: out
  /// of a hold and a closed door by a reset at rest, which forgets what was queued; out
  /// of an alarm by $X and the set-up, unless it has switches: then it is homed; out of a
  /// set-up that was refused by the same lines.
  /// `newest`: the newest status. True: it is idle and takes lines.
  bool Recover(const GrblStatus& newest);
  void RequestStatus() { next_status_ = {}; }
  /// $H, when nothing is outstanding; false: something is. The controller is mute until
  /// GrblHomed, a GrblAlarm or a GrblError tells how it ended. Reset ends it, with
  /// ALARM:6.
  bool SendHome();

 private:
  enum class Phase { kClosed, kAsking, kResetting, kIdentifying, kUp, kRefused };
  struct Sent {
    std::size_t bytes = 0;
    bool own = false;  ///< of the set-up
  };

  void Open();
  void Read(std::vector<Event>& events);
  void Receive(const GrblAnswer& answer, std::vector<Event>& events);
  void TakeBanner(std::vector<Event>& events);
  void TakeAcknowledgement(bool good, int code, std::vector<Event>& events);
  void TakeStatus(GrblStatus status, std::vector<Event>& events);
  void WatchChain(const GrblStatus& status);
  void TakeSetting(const GrblSetting& setting);
  void Lose(std::string why, std::vector<Event>& events);
  void CheckSilence(std::vector<Event>& events);
  void Ask();
  void Identified(std::vector<Event>& events);
  std::string RefusalOfTraits() const;
  void SendOwn(const std::vector<std::string>& lines);
  void Unlock();
  void SetUp();
  bool is_ready() const {
    return phase_ == Phase::kUp && !setting_up_ && !homing_ && !awaits_status_;
  }
  /// What $G answers is asked for, and has not come.
  bool AwaitsModes(const GrblStatus& status);
  bool WasSwitchedOff(const GrblStatus& status) const;
  void LosePlace() { lost_axes_ = {true, true, true}; }

  link::ExpectedDevice expected_;
  GrblTool tool_;
  GrblAnswerReader reader_;
  std::deque<Sent> outstanding_;
  std::size_t outstanding_bytes_ = 0;
  GrblTraits traits_;
  Phase phase_ = Phase::kClosed;
  bool resets_itself_ = false, set_up_ = false, setting_up_ = false, held_ = false;
  bool awaits_status_ = false;  // one that is newer than the newest reset or unlock
  bool found_held_ = false;     // by another than this host
  bool alarm_ = false;
  bool homing_ = false;
  bool home_failed_ = false;  // it resets itself behind the alarm
  bool door_open_ = false, door_latched_ = false, stop_pressed_ = false;
  std::uint32_t chain_openings_ = 0;
  std::optional<Vec3> work_offset_mm_;  // the newest that was reported
  std::optional<Box3> reach_;
  bool was_set_up_ = false;  // when the line was lost
  std::optional<std::chrono::nanoseconds> modes_asked_at_;
  std::optional<GrblModes> modes_;   // since the line was lost
  std::array<bool, 3> lost_axes_{};  // of which it may not know where they are
  std::chrono::nanoseconds next_status_{0}, phase_at_{0};
  /// Of the oldest question without an answer: a host that was too busy to ask has not
  /// lost its line.
  std::optional<std::chrono::nanoseconds> asked_at_;
};

}  // namespace intaglio::drivers
