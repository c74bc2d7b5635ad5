#pragma once

// The outputs and inputs of a laser controller: one signal each, on or off, whatever
// voltage that is on the board. GpioPins has those of a Linux board, SimulatedPins those
// of tests and of measurements. Not thread-safe; no call waits.

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
  kAlive,  ///< changes while the program watches over the laser
};
inline constexpr int kOutputCount = 9;

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
};
inline constexpr int kInputCount = 9;

/// `channel`: from 0.
constexpr Output ShutterOutput(int channel) {
  return static_cast<Output>(static_cast<int>(Output::kShutter1) + channel);
}
constexpr Input PhotosensorInput(int channel) {
  return static_cast<Input>(static_cast<int>(Input::kPhotosensor1) + channel);
}
constexpr std::uint32_t BitOf(Input input) { return 1U << static_cast<int>(input); }

/// Every output is off when the object is there, and when it is gone.
class LaserPins {
 public:
  virtual ~LaserPins() = default;

  virtual bool Has(Output output) const = 0;
  virtual bool Has(Input input) const = 0;
  /// Nothing happens where the board has none. kIo.
  virtual Status Set(Output output, bool on) = 0;
  /// Bits of key, door, stop and in-position, on or off now. kIo.
  virtual Result<std::uint32_t> Levels() = 0;
  /// When the lamp sync or a photosensor went on, on the clock of
  /// link::MonotonicClock; the oldest time that was not given yet. Nothing: it did not.
  virtual Result<std::optional<std::chrono::nanoseconds>> NextEdge(Input input) = 0;
};

}  // namespace intaglio::reference_controller
