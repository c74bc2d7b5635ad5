#pragma once

// The driver of the motion line together with the reference controller of a stage, its
// outputs simulated, over a pseudo-terminal that a test cuts; one clock that the test
// moves. Where the stage is, is counted from the edges of its steps alone.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/reference_controller/simulated_stage.h"
#include "services/reference_controller/stage_controller.h"
#include "services/virtual_engraver/lines/pty_line.h"
#include "tests/services/drivers/motion_rig.h"
#include "tests/services/reference_controller/wire.h"

namespace intaglio::reference_controller {

class StageRig final : public drivers::MotionRig {
 public:
  /// `serial_number`: in the profile; empty: the controller's. Homed at first, if it
  /// `homes`.
  explicit StageRig(const std::string& serial_number, bool homes = true);
  ~StageRig() override;

  void CutLine(bool cut) override { wire_->Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { wire_->CutAfter(bytes); }
  void PowerCycle() override;
  bool Inflict(drivers::ControllerFault fault) override;
  void Relieve(drivers::ControllerFault fault) override;
  bool LosePlace() override;
  bool FindPlace() override;

  Vec3 actual_mm() override { return pins_ ? pins_->place_mm() : place_mm_; }
  bool moves() override;
  double rate_hz() const override { return 100; }
  std::uint64_t NsOfTick(std::uint64_t tick) override;
  Vec3 travel_min_mm() const override { return Vec3::Constant(-5); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(60); }
  double tolerance_mm() const override;
  std::chrono::milliseconds braking_time() const override {
    return std::chrono::milliseconds(40);
  }

  /// Steps of all axes, since the begin.
  std::uint64_t step_count() const { return step_count_; }
  SimulatedStage& pins() { return *pins_; }
  StageController& controller() { return *controller_; }
  std::uint64_t tick() const { return tick_; }
  /// Those of all outputs but Output::kAlive.
  const std::vector<Edge>& edges() const { return edges_; }
  const std::string& error() const { return error_; }
  std::chrono::nanoseconds now() const { return now_; }
  const StageControllerOptions& options() const { return options_; }
  /// Each call of its outputs and inputs is an error from now on.
  void BreakBoard() { *board_is_broken_ = true; }
  void SwitchOff();
  void SwitchOn();
  /// The clock goes on, and no turn of the controller with it.
  void Stall(std::chrono::nanoseconds time) { now_ += time; }

 private:
  void AdvanceController() override;
  void Record(const Edge& edge);
  std::chrono::nanoseconds TimeOf(std::uint64_t tick) const;
  void TurnUntil(std::chrono::nanoseconds end);
  link::SteadyClock clock() {
    return [this] { return now_; };
  }
  std::unique_ptr<link::ByteStream> ControllerEnd();

  StageControllerOptions options_;
  std::string path_;
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::chrono::nanoseconds first_tick_at_ = now_;  // tick 0
  std::uint64_t tick_ = 0;
  std::shared_ptr<Wire> wire_;
  std::vector<Edge> edges_;
  std::uint64_t step_count_ = 0;
  std::chrono::nanoseconds stepped_at_{0};
  std::string error_;
  std::uint32_t power_up_ = 0;
  Vec3 place_mm_;  // without power
  std::optional<virtual_engraver::PtyLine> line_;
  std::unique_ptr<SimulatedStage> pins_;
  std::shared_ptr<bool> board_is_broken_ = std::make_shared<bool>(false);
  std::unique_ptr<Pins> board_;
  std::unique_ptr<StageController> controller_;
};

}  // namespace intaglio::reference_controller
