#pragma once

// Outputs of a stage that are recorded, each change with its time, and a stage that
// answers them: its place is counted from the edges of steps and directions alone, its
// home switches are pressed where they are, and drives that are off do not move.

#include <array>
#include <atomic>
#include <functional>

#include "engrave/core/geometry.h"
#include "services/platform/link/steady_clock.h"
#include "services/reference_controller/recorded_outputs.h"
#include "services/reference_controller/stage_controller.h"

namespace intaglio::reference_controller {

struct SimulatedStageOptions {
  StepOptions steps;                       ///< of the motors: steps_per_mm and reversed
  virtual_engraver::HomingOptions homing;  ///< where the switches are
  Vec3 at_mm = Vec3::Zero();               ///< where the stage really is at first
  bool has_enable = true;
};

class SimulatedStage final : public Pins {
 public:
  /// `recorded` is called with each change of an output but Output::kAlive.
  SimulatedStage(const SimulatedStageOptions& options, link::SteadyClock clock,
                 std::function<void(const Edge&)> recorded);
  ~SimulatedStage() override;

  bool Has(Output output) const override;
  bool Has(Input input) const override;
  Status Set(Output output, bool on) override;
  Result<std::uint32_t> Levels() override;
  Result<std::optional<std::chrono::nanoseconds>> NextEdge(Input) override {
    return std::optional<std::chrono::nanoseconds>();
  }

  /// Stop or drives, from any thread; both are on at first. A home switch: it is stuck
  /// there.
  void Hold(Input input, bool on);
  /// A home switch is pressed where it is again.
  void Release(Input free) { StuckFree(free).reset(); }
  bool is_on(Output output) const { return outputs_.is_on(output); }
  /// Where the stage really is, machine frame.
  Vec3 place_mm() const;
  std::uint64_t alive_count() const { return outputs_.alive_count(); }

 private:
  bool IsPressed(int axis) const;
  std::optional<bool>& StuckFree(Input free) {
    return stuck_free_[static_cast<std::size_t>(free) -
                       static_cast<std::size_t>(Input::kFreeX)];
  }

  SimulatedStageOptions options_;
  RecordedOutputs outputs_;
  std::array<std::int64_t, 3> steps_{};
  std::array<std::optional<bool>, 3> stuck_free_{};
  std::atomic<std::uint32_t> levels_;
};

}  // namespace intaglio::reference_controller
