#pragma once

// Motion by hand, lamp and shutters by hand: executes what a person (or the cell's
// synchronizer) holds, as long as it is held and nothing forbids it.
//
//            an order, fresh, nothing forbids it         at rest
//   kResting ----------------------------------> kMoving --------> kResting (done)
//      ^                                           | let go, stale, forbidden
//      +--------- at rest (stopped) -- kBraking <--+
//
// Dead-man. An order has the number of the ManualState that its sender received last, and
// this process knows when it published that: so the age of an order is measured by one
// clock, whatever delayed it, and a sample that a network held back, or that was stored,
// moves nothing. Motion whose newest order is older than kHeldTime is ended.
//
// Lamp and shutters belong to the synchronizer, which has the laser's line: it switches
// what lamp_by_hand() and shutters_by_hand() are in the published state, and reports what
// the laser controller has done (Interlock). An order whose effect is not reported within
// kLightTime, or ends, is ended. One order is executed at a time, of whichever kind.
//
// An outline of the guide laser is a motion by hand, too: the mirrors move until it is
// let go. Its speed is not bounded by kMaxSpeedMmS, since nothing that a hand could meet
// moves.
//
// Nothing restarts by itself: what ended, for whatever reason, is spent with its number;
// only an order with a greater number moves again. A number is that of the state at which
// the order began, so an order that is held while this process is started again has one
// that this process has not published, and moves nothing.
//
// Key, door and stop are read by the laser's controller and reported by another process.
// A motion is ended when what is known of them is older than kInterlockTime: so much
// longer than with a report it goes on when that process has died, and its braking
// distance,
//   v kInterlockTime + v^2 / 2a,   v: its speed, a: that of braking.
//
// Who decides: the job service, by a fresh Permission that is not granted. While a job is
// armed, nothing is moved by hand. Key, door and the stops hold as in engraving. A run of
// the synchronizer takes the stage at once (bridge.h). Used from one thread; pure but for
// the driver.

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "idl/teach.h"
#include "services/drivers/interface/hand_motion.h"

namespace intaglio::cell {

struct ManualOrder {
  std::string sender;
  std::uint64_t number = 0, seen = 0;
  intaglio_ManualCommandKind kind = intaglio_MANUAL_NONE;
  Vec3 place = Vec3::Zero();
  double speed_mm_s = 0;
  bool by_cell = false;            ///< the synchronizer, for a job that is armed
  std::uint32_t channel = 1;       ///< of a shutter
  std::uint8_t sets = 7;           ///< of a zero: bit 0..2, x, y, z
  std::vector<Vec2> corners = {};  ///< of an outline, by the first two axes
};

/// What the bridge knows of the rest of the machine.
struct ManualConditions {
  bool permission_fresh = false;  ///< the job service answers for this machine
  bool job_armed = false;
  bool run_active = false;  ///< of the synchronizer
  /// When the newest report of the next four came, by the clock of Turn; negative: none
  /// has come, or its sender has ended.
  std::chrono::nanoseconds interlocks_at{-1};
  /// How old they were by then: since the controller reported them.
  std::chrono::nanoseconds interlocks_age{0};
  bool key_on = false, door_closed = false, stop_released = false, laser_line_up = false;
  bool stop_pressed = false;       ///< on the bus
  bool lamp_on = false;            ///< as the laser controller reports it
  std::uint8_t shutters_open = 0;  ///< bit 0..3: channel 1..4
};

/// How old key, door and stop may be for a motion by hand: two periods of 50 ms in which
/// they are sent, and a third for a busy computer. A controller that homes answers
/// nothing meanwhile (grbl, isel) and watches its own chain: then the report that came
/// counts.
inline constexpr std::chrono::milliseconds kInterlockTime{150};

/// A pause takes the permission back, and the job goes on after it.
inline constexpr const char* kJobIsArmed =
    "a job is armed on this machine: pause it first (intaglio pause JOB), and resume it "
    "afterwards";

/// Why this order may not be executed at `now`, and what to do; empty: it may be.
std::string WhyNoMotionByHand(const ManualConditions& conditions,
                              const drivers::DriverState& state, const ManualOrder& order,
                              std::chrono::nanoseconds now);

struct ManualAnswer {
  std::string sender;
  std::uint64_t number = 0;
  intaglio_ManualAnswer code = intaglio_MANUAL_REFUSED;
  std::string message;
  /// Refused because the job service's permission, or key, door and stop, were not
  /// reported: a moment later they may be.
  bool reports_missing = false;
};

class ManualControl {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  static constexpr std::chrono::milliseconds kHeldTime{200};
  static constexpr double kMaxSpeedMmS = 50;
  /// From an order to the report that the lamp is on, or the shutter open.
  static constexpr std::chrono::seconds kLightTime{2};

  /// `limits`: in the axes' units; `names`: of the axes, for messages.
  ManualControl(drivers::HandMotion& driver, const Box3& limits,
                std::array<std::string, 3> names)
      : driver_(driver), limits_(limits), names_(std::move(names)) {}

  /// Channels whose shutters and lamp are switched by hand; default 1, 0: the machine has
  /// none.
  void SetChannels(std::uint32_t count) { channels_ = count; }
  void SetLimits(const Box3& limits) { limits_ = limits; }
  /// A ManualState of this number goes out.
  void NotePublished(std::uint64_t number, Nanoseconds now);
  /// Whether an order that was made on this number is young enough.
  bool IsFresh(std::uint64_t seen, Nanoseconds now) const;

  /// Once for each order that comes.
  void Receive(const ManualOrder& order, Nanoseconds now);
  /// Its process is gone.
  void LoseSender(const std::string& sender);
  /// Once a turn.
  void Turn(const ManualConditions& conditions, Nanoseconds now);

  bool moves() const { return phase_ != Phase::kResting; }
  /// Empty: nobody's motion is executed.
  std::string held_by() const { return moves() ? order_.sender : ""; }
  bool lamp_by_hand() const { return Holds(intaglio_MANUAL_LAMP); }
  /// Bit 0..3: channel 1..4.
  std::uint8_t shutters_by_hand() const {
    return Holds(intaglio_MANUAL_SHUTTER) ? MaskOf(order_.channel) : std::uint8_t{0};
  }
  /// The newest answer.
  const ManualAnswer& answer() const { return answer_; }
  void Answer(const ManualOrder& order, intaglio_ManualAnswer code, std::string message);
  /// A number of this sender that was not answered before.
  bool IsNew(const ManualOrder& order) const;
  /// It began at no state of this process: answered once, and not to be executed.
  bool RefusesEarlier(const ManualOrder& order);

 private:
  enum class Phase { kResting, kMoving, kBraking };

  void Begin(const ManualOrder& order, const ManualConditions& conditions,
             Nanoseconds now);
  Status Start(const ManualOrder& order);
  /// Why the motion has to end; empty: it has not.
  std::string WhyEnded(const ManualConditions& conditions, Nanoseconds now) const;
  Box3 LimitsNow() const;
  Result<Vec3> TargetOf(const ManualOrder& order) const;
  Status CheckOutline(const ManualOrder& order) const;
  void Brake(std::string why);
  void TurnLight(std::string why, const ManualConditions& conditions, Nanoseconds now);
  bool Holds(intaglio_ManualCommandKind kind) const {
    return phase_ == Phase::kMoving && order_.kind == kind;
  }
  static std::uint8_t MaskOf(std::uint32_t channel) {
    return static_cast<std::uint8_t>(1u << (channel - 1));
  }
  std::optional<Nanoseconds> PublishedAt(std::uint64_t number) const;

  drivers::HandMotion& driver_;
  Box3 limits_;
  std::array<std::string, 3> names_;
  std::deque<std::pair<std::uint64_t, Nanoseconds>> published_;
  std::optional<std::uint64_t> first_published_;
  std::map<std::string, std::uint64_t> spent_;    // greatest number by sender
  std::map<std::string, std::uint64_t> earlier_;  // number that was refused last
  std::optional<ManualOrder> pending_;
  Phase phase_ = Phase::kResting;
  ManualOrder order_;      // whose motion is executed
  double speed_mm_s_ = 0;  // of the newest jog
  std::uint32_t channels_ = 1;
  Nanoseconds began_at_{0};
  bool was_lit_ = false;    // the effect of order_ was reported
  Nanoseconds held_at_{0};  // when its newest repetition was made, at the earliest
  bool let_go_ = false;
  bool hold_owed_ = false;  // the line has not taken it
  std::string stopped_by_;
  ManualAnswer answer_;
};

}  // namespace intaglio::cell
