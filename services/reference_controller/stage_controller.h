#pragma once

// A stage controller with real outputs: steps and directions of three axes, in-position,
// and what keeps the drives on. What may move, the queue, the end of a host, limits,
// homing and the protocol are those of the virtual engraver's stage (stage.h,
// stage_end.h), and no second ones; this shows it a real clock, and makes steps of its
// command (step_axes.h). It runs on a clock of its own and is notified of the lamp's
// ticks.
//
// Drives are off until a person has it homed, and from a stop or a fault of an amplifier
// on until the next Home. Their place is lost with them, for no step is measured.
// Outputs are off from before the line opens; when the board fails, a call of it is an
// error; and when this object is gone. While Turn is called, Output::kAlive changes at
// least every 20 ms. A killed process leaves its outputs as they are, and makes no step
// any more.
//
// Not thread-safe but for ReceiveTick. Turn waits for the length of a step.

#include <atomic>
#include <chrono>
#include <memory>

#include "services/reference_controller/controller.h"
#include "services/reference_controller/pins.h"
#include "services/reference_controller/step_axes.h"
#include "services/reference_controller/tick_ring.h"
#include "services/virtual_engraver/stage_end.h"

namespace intaglio::reference_controller {

struct StageControllerOptions {
  /// With a clock of its own and homing.
  virtual_engraver::StageOptions stage;
  StepOptions steps;
  /// Between two turns while it moves, > 0: so late may a step be.
  std::chrono::nanoseconds turn{10'000};
};

class StageController {
  using Time = std::chrono::nanoseconds;

 public:
  /// A turn is good for so long: shorter than a tick.
  static constexpr std::chrono::nanoseconds kTurnIsGood{500'000};
  /// Between two polls of line and inputs.
  static constexpr std::chrono::nanoseconds kPoll{1'000'000};

  /// `pins` outlive this.
  StageController(const StageControllerOptions& options, Pins& pins, ControllerTime time);
  ~StageController() { MakeSafe(); }
  StageController(const StageController&) = delete;
  StageController& operator=(const StageController&) = delete;

  /// The controller's end of the line; null unplugs it.
  void Plug(std::unique_ptr<link::ByteStream> end) {
    end_.Plug(std::move(end), time_.clock);
  }
  bool is_plugged() const { return end_.own_line().is_plugged(); }
  /// From the laser's thread, in the order of the ticks.
  void ReceiveTick(const TickNotice& notice) { ticks_.Push(notice); }
  /// What the laser needs beside the output; from any thread.
  StageWitness witness() const { return {Time(in_position_until_.load()), runs_.load()}; }
  /// Line, inputs, and the steps that are due. Returns how long nothing is due. kIo when
  /// the board fails: then everything is off.
  Result<std::chrono::nanoseconds> Turn();
  /// Brakes a motion; Turn brings it to rest.
  void Brake() { stage_.Abort(); }
  /// Every output off; nothing is stepped any more.
  void MakeSafe();

  virtual_engraver::Stage& stage() { return stage_; }
  /// What the stage's own clock shows at this time of the controller's.
  std::uint64_t NsAt(std::chrono::nanoseconds time) const {
    return began_ns_ + static_cast<std::uint64_t>((time - began_at_).count());
  }

 private:
  Result<Time> TryTurn();
  Status ReadInputs();
  void AdvanceTo(Time now);
  Status WriteOutputs();

  StageControllerOptions options_;
  Pins& pins_;
  ControllerTime time_;
  StepAxes* axes_;  // of stage_
  virtual_engraver::Stage stage_;
  virtual_engraver::StageEnd end_{stage_};
  TickRing ticks_;
  Time began_at_, next_poll_;
  std::uint64_t began_ns_;  // began_at_ on the clock of the stage
  std::uint64_t now_ns_;
  bool enabled_ = false, alive_ = false;
  std::atomic<Time::rep> in_position_until_{0};
  std::atomic<std::uint32_t> runs_{0};
};

}  // namespace intaglio::reference_controller
