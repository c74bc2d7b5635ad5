#pragma once

// What a laser controller family has to be able to do for the synchronizer: the laser at
// the end of the laser line. What a family is: motion_driver.h; its row is in
// laser_drivers.cc.
//
// Time is the laser's: a tick is one lamp sync, counted from its power-up. A family
// without ticks counts periods of its pulse rate.
//
// Guarantees of every driver together with its controller; each is checked for all that
// LaserDriverKinds lists (tests/services/drivers/laser_conformance.cc):
//   L1  Nothing blocks. What cannot be taken now is refused with an error, and nothing of
//       it is done.
//   L2  A pulse comes at a tick only if a window of this session decides that tick to
//       fire, and then once: however often it is armed, and whatever is repeated on the
//       line.
//   L3  Disarm, a new session, Stop, and an interlock leave no armed tick. disarmed() is
//       true only once the controller has reported that it took the newest Disarm: what
//       was armed before and is not reported then, never comes.
//   L4  The outcome of every decided tick is reported once, in order, without gap, as
//       long as the line holds. A window that comes too late is reported so and fires
//       nothing.
//   L5  status().pulse_count counts every pulse since power-up, seen or not.
//   L6  RequestPast answers for the newest link::kRememberedTicks ticks, whichever
//       session armed them: so that a pulse is known after a lost line or a killed
//       process.
//   L7  A line that is cut, and a host that dies or hangs, close the shutters and leave
//       nothing armed, by the controller itself: within 250 ms. up() is false within
//       300 ms.
//   L8  A lost line comes back by itself, with a new session(); the shutters do not open,
//       and nothing fires, before this host commands it again.
//   L9  Key, door and stop button let no pulse pass, and status().openings counts each
//       letting go, also while no host is connected.
//   L10 Without a warm lamp, or an open shutter, nothing fires; both are in the status.
//   L11 A power cycle is another identity().power_up: other ticks, other counters.
//   L12 A controller with another serial number than the profile's is refused: up() is
//       false, refusal() gives the reason, nothing of it is taken, and it is closed and
//       disarmed.
//   L13 A window whose energy is outside identity()'s range fires nothing: it is refused
//       with kUnsupported, or each of its pulses has the outcome kEnergyOutside.
//   L14 What the controller reports of itself is never a lost line alone: a reset, an
//       emergency stop, a hold, a limit, an alarm and an error are counted among
//       status().openings, or are another power_up, as a power cycle is. No shutter
//       opens and nothing fires before Reset, and a controller is unlocked by Reset
//       alone.
// Not thread-safe. An object may be a motion driver, too
// (services/drivers/interface/motion_driver.h), when one controller is both.

#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "services/platform/link/laser_protocol.h"

namespace intaglio::drivers {

/// Outputs and inputs for other uses, as the profile names them.
struct Accessories {
  std::uint8_t on = 0;   ///< outputs, bit 0: number 1; as the controller reports them
  std::string on_names;  ///< of these, separated by ", "
  /// Which input does not permit a job and what to do, or what the controller does not
  /// have; empty: nothing. Nothing fires meanwhile.
  std::string open_input;

  bool operator==(const Accessories&) const = default;
};

class LaserController {
 public:
  using ReportSink = std::function<void(const link::PulseReport&)>;
  using PastSink = std::function<void(const link::PastReport&)>;
  /// A status comes every 20 ms; without one nothing is known of the interlocks.
  static constexpr std::chrono::milliseconds kStatusLease{500};

  virtual ~LaserController() = default;

  /// Moves bytes and takes what came; `sink` gets every pulse report once, in order,
  /// `past` every answer to RequestPast.
  virtual void Poll(const ReportSink& sink, const PastSink& past) = 0;

  /// Connected, identified, and a status of this session has come.
  virtual bool up() const = 0;
  /// Not before the identity has come: a Disarm of a session that is not known yet would
  /// be counted by the controller and not by us.
  virtual bool CanSend() const = 0;
  /// A newer host has the controller; this is for good, and nothing more is sent to it.
  virtual bool taken_over() const = 0;
  /// Why the line is down; empty while it is up.
  virtual const std::string& message() const = 0;
  /// Why the controller that answers now is refused, and what to do; empty: it is not.
  virtual const std::string& refusal() const = 0;
  /// For poll(2); -1 when there is none.
  virtual int fd() const = 0;

  virtual const link::LaserIdentity& identity() const = 0;
  /// Its time is simulated, and waits for this host: no lease is wall time then, and what
  /// is late is waited for. A real controller in lockstep (identity().lockstep) is none.
  virtual bool simulates_time() const { return false; }
  virtual const link::LaserStatus& status() const = 0;
  /// Statuses of this session; grows with each.
  virtual std::uint64_t status_number() const = 0;
  /// When the newest status came, by the driver's clock.
  virtual std::chrono::nanoseconds status_at() const = 0;
  /// Grows with every session, i.e. whenever what was sent may have been lost.
  virtual std::uint64_t session() const = 0;
  /// A status that was made after the newest Disarm of this session has come.
  virtual bool disarmed() const = 0;

  /// Up, and the newest status is young enough to act on.
  bool IsFresh(std::chrono::nanoseconds now) const {
    return up() && now - status_at() < kStatusLease;
  }
  bool Has(link::InterlockBits bit) const { return (status().interlocks & bit) != 0; }

  virtual Status Lamp(bool on, double rate_hz) = 0;
  virtual Status OpenShutters(std::uint8_t mask) = 0;
  virtual Status Arm(const link::ArmWindow& window) = 0;
  virtual Status Disarm() = 0;
  virtual Status Reset() = 0;
  /// Emergency stop, which the controller keeps latched until Reset.
  virtual Status Stop() = 0;
  virtual Status RequestStatus() = 0;
  /// Of a family without them, whose profiles name none: nothing.
  virtual const Accessories& accessories() const {
    static const Accessories kNone;
    return kNone;
  }
  /// These outputs on, and all others off, until the next one. The controller switches
  /// them off by itself with a safe state, an open interlock, and another session.
  virtual Status SwitchOutputs(std::uint8_t on);
  /// Its stop is pressed or latched, or it has closed its shutters by itself.
  bool is_latched() const { return Has(link::kSafeState) || !Has(link::kStopReleased); }
  /// A Reset that is lost, or refused while the stop is pressed, is sent again by the
  /// caller as long as the controller is_latched().
  void SendReset() {
    (void)Reset();
    (void)RequestStatus();
  }
  /// Asks what came of `count` ticks (1..link::kMaxPastTicks), whichever session armed
  /// them. False: the line takes nothing now. A new session loses what was asked before.
  virtual bool RequestPast(std::uint64_t first_tick, std::uint16_t count) = 0;
};

/// laser_line.protocol of a laser on a digital output of the machine's motion controller:
/// the motion bridge has the controller's line and serves its laser
/// (services/drivers/laser_output.h); the synchronizer opens that.
inline constexpr std::string_view kMotionOutput = "motion-output";

/// Of a family that makes a point by one pulse: kUnsupported for a window of more.
Status CheckOnePulse(const link::ArmWindow& window);

/// For families that cannot set each pulse's energy: kUnsupported when the window fires
/// and its energy is outside the range of `laser`.
Status CheckEnergy(const link::LaserIdentity& laser, const link::ArmWindow& window);

}  // namespace intaglio::drivers
