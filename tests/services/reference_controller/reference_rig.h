#pragma once

// The driver of the laser line together with the reference controller, its outputs
// simulated, over a pseudo-terminal that a test cuts; one clock that the test moves.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/platform/link/endpoint.h"
#include "services/reference_controller/controller.h"
#include "services/reference_controller/simulated_pins.h"
#include "services/virtual_engraver/lines/pty_line.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/reference_controller/wire.h"

namespace intaglio::reference_controller {

struct ReferenceRigOptions {
  SimulatedPinsOptions pins = {};
  // What the profile commands: from the lamp sync, and of the trigger.
  double qswitch_delay_us = 5, qswitch_width_us = 120;
  MachineSpec named = {};  ///< outputs and inputs for other uses of the profile
};

class ReferenceRig final : public drivers::LaserRig {
 public:
  /// `serial_number`: in the profile; empty: the controller's.
  explicit ReferenceRig(const std::string& serial_number,
                        ReferenceRigOptions options = {});
  ~ReferenceRig() override;

  void CutLine(bool cut) override;
  void CutLineAfter(std::uint64_t bytes) override;
  void SwitchOff() override;
  /// For other uses; `index`: from 0.
  void SetInput(int index, bool on);
  bool is_on(Output output) const { return pins_ && pins_->is_on(output); }
  void SwitchOn() override;
  void Set(Interlock interlock, bool holds) override;
  std::uint64_t tick() override;
  std::vector<std::uint64_t> FiredTicks() override { return fired_ticks_; }
  std::uint8_t shutters() override;
  bool lamp_on() override { return pins_ && pins_->is_on(Output::kLamp); }
  double rate_hz() const override { return 100; }
  double fast_rate_hz() const override { return 200; }

  SimulatedPins& pins() { return *pins_; }
  Controller& controller() { return *controller_; }
  /// Those of all outputs but Output::kAlive, since the first power-up.
  const std::vector<Edge>& edges() const { return edges_; }
  /// The newest error of a turn; empty: none.
  const std::string& error() const { return error_; }
  void HoldInPosition(bool on) { pins_->Hold(Input::kInPosition, on); }
  /// The stage of the same program agrees no longer with its in-position output.
  void StageHangs() { stage_hangs_ = true; }
  void StageBeginsARun() { ++stage_runs_; }
  /// The controller is not run for so long.
  void Stall(std::chrono::nanoseconds time) { now_ += time; }
  /// Each call of its outputs and inputs is an error from now on.
  void BreakBoard() { *board_is_broken_ = true; }
  /// Each wait of the controller ends so much later from now on.
  void DelayWaits(std::chrono::nanoseconds late) { waits_late_ = late; }

 private:
  void AdvanceController() override;
  link::SteadyClock clock() {
    return [this] { return now_; };
  }
  std::unique_ptr<link::ByteStream> ControllerEnd();

  ReferenceRigOptions options_;
  std::string path_;
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::chrono::nanoseconds waits_late_{0};
  bool stage_hangs_ = false;
  std::uint32_t stage_runs_ = 0;
  std::shared_ptr<Wire> wire_;
  std::vector<Edge> edges_;
  std::vector<std::uint64_t> fired_ticks_;
  std::string error_;
  std::uint32_t power_up_ = 0;
  std::optional<virtual_engraver::PtyLine> line_;
  std::unique_ptr<SimulatedPins> pins_;
  std::shared_ptr<bool> board_is_broken_ = std::make_shared<bool>(false);
  std::unique_ptr<Pins> board_;
  std::unique_ptr<Controller> controller_;
};

}  // namespace intaglio::reference_controller
