#include "services/reference_controller/stage_controller.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/virtual_engraver/laser_end.h"

namespace intaglio::reference_controller {

using link::StageFault;
using std::chrono::nanoseconds;

StageController::StageController(const StageControllerOptions& options, Pins& pins,
                                 ControllerTime time)
    : options_(options),
      pins_(pins),
      time_(std::move(time)),
      axes_(new StepAxes(options.steps, StartMm(options.stage), pins, time_)),
      stage_(options.stage, std::unique_ptr<StepAxes>(axes_)),
      began_at_(time_.clock()),
      next_poll_(began_at_),
      began_ns_(stage_.own_clock()->now_ns()),
      now_ns_(began_ns_) {}

Result<nanoseconds> StageController::Turn() {
  auto idle = TryTurn();
  if (!idle) MakeSafe();
  return idle;
}

void StageController::MakeSafe() {
  in_position_until_ = 0;
  for (int axis = 0; axis < 3; ++axis) (void)pins_.Set(StepOutput(axis), false);
  for (const Output output : {Output::kInPosition, Output::kEnable, Output::kAlive})
    (void)pins_.Set(output, false);
  for (int axis = 0; axis < 3; ++axis) (void)pins_.Set(DirectionOutput(axis), false);
}

Result<nanoseconds> StageController::TryTurn() {
  const nanoseconds now = time_.clock();
  const bool polls = now >= next_poll_;
  if (polls) {
    next_poll_ = now + kPoll;
    INTAGLIO_TRY(ReadInputs());
    end_.Poll();
    runs_ = stage_.runs_begun();
    end_.KeepSafe();
    alive_ = !alive_;
    INTAGLIO_TRY(pins_.Set(Output::kAlive, alive_));
  }
  while (const auto notice = ticks_.Pop()) {
    AdvanceTo(notice->at);
    INTAGLIO_TRY(axes_->Step());
    stage_.ReceiveTick(notice->tick, NsAt(notice->at), notice->rate_hz);
  }
  AdvanceTo(now);
  INTAGLIO_TRY(WriteOutputs());
  INTAGLIO_TRY(axes_->Step());
  if (polls) {
    end_.SendPositions();
    const bool rests = !stage_.running();
    end_.SendStatus(
        now, false,
        rests ? virtual_engraver::kRestingStatusPeriod : virtual_engraver::kStatusPeriod);
    end_.own_line().Flush();
    // Sent data have to leave before the next wait.
    end_.Poll();
  }
  const bool moves = stage_.running() || !axes_->settled();
  return moves ? options_.turn
               : std::clamp(next_poll_ - time_.clock(), nanoseconds(0), kPoll);
}

Status StageController::ReadInputs() {
  const std::uint32_t levels = INTAGLIO_TRY(pins_.Levels());
  axes_->SetSwitches(levels);
  const auto off = [&](Input input) {
    return pins_.Has(input) && (levels & BitOf(input)) == 0;
  };
  const StageFault cause = off(Input::kStop)     ? StageFault::kStopPressed
                           : off(Input::kDrives) ? StageFault::kDriveFault
                                                 : StageFault::kNone;
  stage_.SetDrives(cause);
  if (cause != StageFault::kNone) enabled_ = false;
  return {};
}

// A tick may be older than the newest turn.
void StageController::AdvanceTo(nanoseconds now) {
  now_ns_ = std::max(now_ns_, NsAt(now));
  stage_.AdvanceClock(now_ns_);
}

Status StageController::WriteOutputs() {
  if (stage_.running()) enabled_ = true;
  INTAGLIO_TRY(pins_.Set(Output::kEnable, enabled_));
  const bool in_position = stage_.in_position();
  in_position_until_ = in_position ? (time_.clock() + kTurnIsGood).count() : 0;
  return pins_.Set(Output::kInPosition, in_position);
}

}  // namespace intaglio::reference_controller
