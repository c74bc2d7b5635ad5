#pragma once

// Outputs that are recorded, each change with its time, and a laser that answers them:
// photosensors that see a flash of each trigger behind an open shutter, and a lamp sync
// for each lamp trigger.

#include <array>
#include <atomic>
#include <deque>
#include <functional>
#include <vector>

#include "services/platform/link/steady_clock.h"
#include "services/reference_controller/recorded_outputs.h"

namespace intaglio::reference_controller {

struct SimulatedPinsOptions {
  int channels = 1;  ///< 1..4, each with a shutter and a photosensor
  /// A laser that flashes by itself while its lamp is on, with a lamp sync each; 0: it
  /// flashes with each lamp trigger.
  std::chrono::nanoseconds flash_period{0};
  bool has_lamp_sync = false;       ///< of the laser; else ticks begin with the trigger
  std::uint8_t blind_channels = 0;  ///< bit 0..3: their photosensors see nothing
  std::chrono::nanoseconds sync_after{0};  ///< from the lamp trigger to the lamp sync
  int output_count = 0, input_count = 0;   ///< for other uses, 0..8
  /// The in-position output of a simulated stage, whose thread sets it; null: the input
  /// is held.
  const std::atomic<bool>* in_position = nullptr;
};

class SimulatedPins final : public Pins {
 public:
  /// `recorded` is called with each change of an output but Output::kAlive.
  SimulatedPins(SimulatedPinsOptions options, link::SteadyClock clock,
                std::function<void(const Edge&)> recorded);
  ~SimulatedPins() override;

  bool Has(Output output) const override;
  bool Has(Input input) const override;
  Status Set(Output output, bool on) override;
  Result<std::uint32_t> Levels() override;
  Result<std::optional<std::chrono::nanoseconds>> NextEdge(Input input) override;

  /// Key, door, stop, in-position or one for other uses; all are on at first.
  void Hold(Input input, bool on);
  bool is_on(Output output) const { return outputs_.is_on(output); }
  /// Changes of Output::kAlive.
  std::uint64_t alive_count() const { return outputs_.alive_count(); }

 private:
  std::deque<std::chrono::nanoseconds>& Edges(Input input) {
    return edges_[static_cast<std::size_t>(input)];
  }
  void Answer(Output output);
  void FlashByItself();

  SimulatedPinsOptions options_;
  link::SteadyClock clock_;
  RecordedOutputs outputs_;
  std::array<std::deque<std::chrono::nanoseconds>, kInputCount> edges_;
  std::uint32_t levels_;
  std::chrono::nanoseconds next_flash_{0};
};

}  // namespace intaglio::reference_controller
