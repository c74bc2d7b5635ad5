#pragma once

// A motion driver together with its controller, or a simulation of it, on a clock
// that the test moves: what the conformance of a driver is checked on.

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "services/drivers/interface/motion_driver.h"
#include "tests/services/drivers/controller_fault.h"

namespace intaglio::drivers {

class MotionRig {
 public:
  virtual ~MotionRig() = default;

  /// A millisecond of the driver and its controller.
  void Step() {
    AdvanceController();
    driver->Poll();
    ++steps_;
  }
  void StepFor(std::chrono::milliseconds time) {
    for (std::int64_t i = 0; i < time.count(); ++i) Step();
  }
  /// False when it did not become true within `limit`.
  bool Until(const std::function<bool()>& condition,
             std::chrono::milliseconds limit = std::chrono::seconds(3)) {
    for (std::int64_t i = 0; i < limit.count() && !condition(); ++i) Step();
    return condition();
  }
  bool Connect() {
    return Until([this] {
      return driver->state().link_up && driver->state().fault == intaglio_MOTION_OK;
    });
  }

  /// Nothing passes either way, and the ends stay open.
  virtual void CutLine(bool cut) = 0;
  /// So it is after this many bytes more to the controller.
  virtual void CutLineAfter(std::uint64_t bytes) = 0;
  virtual void PowerCycle() = 0;
  /// At the controller; false: this family has no such thing. A power cycle and its
  /// second without power are over when it returns.
  virtual bool Inflict(ControllerFault fault) {
    if (fault == ControllerFault::kUnplug) CutLine(true);
    if (fault == ControllerFault::kPowerCycle) PowerCycle();
    return fault == ControllerFault::kUnplug || fault == ControllerFault::kPowerCycle;
  }
  /// Its cause is gone: released, plugged in.
  virtual void Relieve(ControllerFault fault) {
    if (fault == ControllerFault::kUnplug) CutLine(false);
  }

  /// The controller does not know any more where its axes are, and moves nothing; false:
  /// one of this family always knows. Over when it returns.
  virtual bool LosePlace() { return false; }
  /// The same in the middle of a motion that nothing else ends; false: here a place is
  /// lost by what ends the motion (M17), or never.
  virtual bool LosePlaceInMotion() { return false; }
  /// As a person then does, until it knows again.
  virtual bool FindPlace() {
    return driver->SetZero(actual_mm(), {true, true, true}) &&
           Until([this] { return driver->state().at_rest; });
  }

  // What the stage really does, whatever is reported.
  virtual Vec3 actual_mm() = 0;
  virtual bool moves() = 0;
  /// Where the stage that carries the block is, by its own axes.
  virtual Vec2 block_mm() { return Vec2::Zero(); }
  /// The controller's time at actual_mm, ms.
  virtual double time_ms() { return static_cast<double>(steps_); }
  /// The guide laser of a machine that draws outlines is on.
  virtual bool guide_is_on() { return false; }
  /// The gate of its laser is open, or it emits.
  virtual bool may_fire() { return false; }
  /// The rate of the controller, Hz.
  virtual double rate_hz() const = 0;
  virtual Vec3 travel_min_mm() const = 0;
  virtual Vec3 travel_max_mm() const = 0;
  /// What the controller's own clock shows at a tick, ns; 0: it counts the ticks.
  virtual std::uint64_t NsOfTick(std::uint64_t tick) {
    (void)tick;
    return 0;
  }
  /// From one tick to the next it shows so much more, where it has one.
  double tick_ns() const { return 1e9 / rate_hz(); }
  /// How far from the commanded place the stage may be at a tick.
  virtual double tolerance_mm() const = 0;
  /// From 10 mm/s to rest, with all delays of the controller.
  virtual std::chrono::milliseconds braking_time() const = 0;
  /// A speed over 100 ms seems so much higher at most.
  virtual double speed_margin() const { return 1.02; }

  std::unique_ptr<MotionDriver> driver;

 private:
  virtual void AdvanceController() = 0;
  std::int64_t steps_ = 0;
};

/// Its profile names `serial_number`; empty: the one of the controller. Null for a driver
/// that has no rig: the conformance test fails for it.
std::unique_ptr<MotionRig> MakeMotionRig(std::string_view protocol,
                                         const std::string& serial_number = "");

}  // namespace intaglio::drivers
