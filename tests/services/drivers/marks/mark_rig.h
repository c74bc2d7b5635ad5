#pragma once

// A mark driver together with its controller, or a simulation of it, on a clock that the
// test moves: what the conformance of a driver is checked on.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "services/drivers/interface/mark_driver.h"
#include "tests/services/drivers/controller_fault.h"

namespace intaglio::drivers {

class MarkRig {
 public:
  virtual ~MarkRig() = default;

  /// A millisecond of the controller, then of the host, which permits while it is told to
  /// and takes the events.
  void Step();

  /// Nothing passes either way, and the ends stay open.
  virtual void CutLine(bool cut) = 0;
  /// At the controller; false: this family has no such thing.
  virtual bool Inflict(ControllerFault fault) = 0;
  /// Its cause is gone: switched on, released, plugged in.
  virtual void Relieve(ControllerFault fault) = 0;
  /// The chain of key, door and stop button.
  virtual void SetDoor(bool closed) = 0;
  /// A cable that was pulled differs from a power cycle; false: each is one (K9).
  virtual bool knows_power_ups() const { return true; }
  /// A new driver in place of the one before, as when its process was killed.
  virtual std::unique_ptr<MarkDriver> MakeDriver(const std::string& serial_number) = 0;

  // What the tool really does, whatever is reported.
  /// Grows with all that it does: steps of the axes, and ticks with the beam on.
  virtual std::uint64_t work_count() = 0;
  /// The beam is on, or the spindle turns.
  virtual bool is_on() = 0;
  /// The guide laser is on; a machine without one has it off.
  virtual bool guide_is_on() { return false; }
  /// The beam could be on, by the outputs of the controller alone.
  virtual bool gate_is_open() { return is_on(); }
  /// Where a guide laser shines, mm in the field, and how far beside a place that may be
  /// on each axis.
  virtual Vec2 guide_at_mm() { return Vec2::Zero(); }
  virtual double place_tolerance_mm() { return 0; }
  /// A controller that may have lost its place says so (K10); false: it cannot lose it.
  virtual bool can_lose_place() const { return driver->hand() != nullptr; }

  /// Marks for a tool as it is here, each some tenths of a second.
  virtual mark::MarkSet MarksFor(int count) = 0;
  /// From Stop to rest, dark.
  virtual std::chrono::milliseconds stop_time() const = 0;

  std::unique_ptr<MarkDriver> driver;
  std::vector<MarkEvent> events;
  bool permits = true;

 private:
  virtual void AdvanceController() = 0;
  int steps_ = 0;
};

/// The rigs of a row of MarkDriverKinds, by name: of each kind of tool one. Empty: the
/// conformance test fails for it.
std::vector<std::string> MarkRigsOf(std::string_view protocol);
/// Its profile names `serial_number`; empty: the one of the controller.
std::unique_ptr<MarkRig> MakeMarkRig(const std::string& name,
                                     const std::string& serial_number = "");

}  // namespace intaglio::drivers
