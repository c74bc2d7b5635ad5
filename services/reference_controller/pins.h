#pragma once

// The outputs and inputs of a controller: one signal each, on or off, whatever voltage
// that is on the board. Laser and stage have objects of their own. GpioPins has those of
// a Linux board, SimulatedPins and SimulatedStage those of tests and of measurements. Not
// thread-safe; no call waits.

#include <chrono>
#include <cstdint>
#include <optional>

#include "engrave/core/result.h"

namespace intaglio::reference_controller {

/// In the order in which they are switched off: what fires first.
enum class Output : std::uint8_t {
  kQSwitch,
  kShutter1,
  kShutter2,
  kShutter3,
  kShutter4,
  kLampTrigger,
  kLamp,
  kDoorLock,
  kOutput1,  ///< for other uses, and the seven behind it
  kOutput8 = kOutput1 + 7,
  kAlive,  ///< changes while the program watches over the laser, or over the stage
  // What follows belongs to a stage.
  kStepX,
  kStepY,
  kStepZ,
  kDirectionX,
  kDirectionY,
  kDirectionZ,
  kEnable,  ///< of the drives
  kInPosition,
};
inline constexpr int kOutputCount = 25;

enum class Input : std::uint8_t {
  kKey,
  kDoor,  ///< on: closed
  kStop,  ///< on: not pressed
  kInPosition,
  kLampSync,
  kPhotosensor1,
  kPhotosensor2,
  kPhotosensor3,
  kPhotosensor4,
  // What follows belongs to a stage.
  kFreeX,  ///< on: the home switch is not pressed
  kFreeY,
  kFreeZ,
  kDrives,  ///< on: no amplifier reports a fault
  kInput1,  ///< for other uses, of the laser's board, and the seven behind it
  kInput8 = kInput1 + 7,
};
inline constexpr int kInputCount = 21;

/// `channel`: from 0.
constexpr Output ShutterOutput(int channel) {
  return static_cast<Output>(static_cast<int>(Output::kShutter1) + channel);
}
constexpr Input PhotosensorInput(int channel) {
  return static_cast<Input>(static_cast<int>(Input::kPhotosensor1) + channel);
}
/// For other uses; `index`: from 0.
constexpr Output SpareOutput(int index) {
  return static_cast<Output>(static_cast<int>(Output::kOutput1) + index);
}
constexpr Input SpareInput(int index) {
  return static_cast<Input>(static_cast<int>(Input::kInput1) + index);
}
/// `axis`: 0 to 2.
constexpr Output StepOutput(int axis) {
  return static_cast<Output>(static_cast<int>(Output::kStepX) + axis);
}
constexpr Output DirectionOutput(int axis) {
  return static_cast<Output>(static_cast<int>(Output::kDirectionX) + axis);
}
constexpr Input FreeInput(int axis) {
  return static_cast<Input>(static_cast<int>(Input::kFreeX) + axis);
}
/// Edges of it are read, and no level.
constexpr bool HasEdges(Input input) {
  return input >= Input::kLampSync && input <= Input::kPhotosensor4;
}
constexpr std::uint32_t BitOf(Input input) { return 1U << static_cast<int>(input); }

/// Every output is off when the object is there, and when it is gone.
class Pins {
 public:
  virtual ~Pins() = default;

  virtual bool Has(Output output) const = 0;
  virtual bool Has(Input input) const = 0;
  /// Nothing happens where the board has none. kIo.
  virtual Status Set(Output output, bool on) = 0;
  /// Bits of all inputs that the board has, but of those with edges: on or off now. kIo.
  virtual Result<std::uint32_t> Levels() = 0;
  /// When the lamp sync or a photosensor went on, on the clock of
  /// link::MonotonicClock; the oldest time that was not given yet. Nothing: it did not.
  virtual Result<std::optional<std::chrono::nanoseconds>> NextEdge(Input input) = 0;
};

}  // namespace intaglio::reference_controller
