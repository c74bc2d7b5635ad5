#pragma once

// A laser driver together with its controller, or a simulation of it, on a clock
// that the test moves: what the conformance of a driver is checked on.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/drivers/interface/laser_controller.h"
#include "services/drivers/interface/motion_driver.h"
#include "tests/services/drivers/controller_fault.h"

namespace intaglio::drivers {

class LaserRig {
 public:
  enum class Interlock { kKey, kDoor, kStopButton };

  virtual ~LaserRig() = default;

  /// A millisecond of the driver and its controller.
  void Step() {
    Advance();
    driver->Poll([this](const link::PulseReport& r) { reports.push_back(r); },
                 [this](const link::PastReport& r) { pasts.push_back(r); });
  }

  /// A millisecond of the controller alone.
  void Advance() { AdvanceController(); }

  /// Nothing passes either way, and the ends stay open.
  virtual void CutLine(bool cut) = 0;
  /// So it is after this many bytes more to the controller.
  virtual void CutLineAfter(std::uint64_t bytes) = 0;
  void PowerCycle() {
    SwitchOff();
    for (int i = 0; i < 1000; ++i) Step();
    SwitchOn();
  }
  virtual void SwitchOff() = 0;
  virtual void SwitchOn() = 0;
  /// Lets go, or holds again.
  virtual void Set(Interlock interlock, bool holds) = 0;

  /// At the controller; false: this family has no such thing. A power cycle and its
  /// second without power are over when it returns.
  virtual bool Inflict(ControllerFault fault) {
    if (fault == ControllerFault::kUnplug) CutLine(true);
    if (fault == ControllerFault::kPowerCycle) PowerCycle();
    if (fault == ControllerFault::kEmergencyStop) Set(Interlock::kStopButton, false);
    return fault == ControllerFault::kUnplug || fault == ControllerFault::kPowerCycle ||
           fault == ControllerFault::kEmergencyStop;
  }
  /// Its cause is gone: released, plugged in.
  virtual void Relieve(ControllerFault fault) {
    if (fault == ControllerFault::kUnplug) CutLine(false);
    if (fault == ControllerFault::kEmergencyStop) Set(Interlock::kStopButton, true);
  }

  // What the laser really does, whatever is reported.
  virtual std::uint64_t tick() = 0;
  /// In the order in which they were fired, since power-up.
  virtual std::vector<std::uint64_t> FiredTicks() = 0;
  virtual std::uint8_t shutters() = 0;
  virtual bool lamp_on() = 0;
  /// The slowest and the fastest that it has.
  virtual double rate_hz() const = 0;
  virtual double fast_rate_hz() const = 0;
  /// A sensor sees what it fires.
  virtual bool sees_cracks() const { return true; }
  /// From Disarm to its confirmation, with what the controller has to finish before.
  virtual std::chrono::milliseconds disarm_time() const {
    return std::chrono::milliseconds(100);
  }

  /// What a check finds because the family cannot keep a guarantee, as its driver's
  /// header and its page state, or the beginning of it; empty: it keeps it. A test of the
  /// family checks what holds instead.
  virtual std::string stated_violation(std::string_view /*check*/) const { return ""; }

  std::unique_ptr<LaserController> driver;
  std::vector<link::PulseReport> reports;
  std::vector<link::PastReport> pasts;

 private:
  virtual void AdvanceController() = 0;
};

/// The same object, of a controller that moves and switches the laser.
std::unique_ptr<LaserController> LaserOf(std::unique_ptr<MotionDriver> both);

/// Its profile names `serial_number`; empty: the one of the controller. Null for a driver
/// that has no rig: the conformance test fails for it. A motion controller that switches
/// the laser has one under its own protocol, too, with its driver as the laser's.
std::unique_ptr<LaserRig> MakeLaserRig(std::string_view protocol,
                                       const std::string& serial_number = "");

}  // namespace intaglio::drivers
