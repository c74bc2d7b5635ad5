#include "services/reference_controller/simulated_stage.h"

#include <utility>

namespace intaglio::reference_controller {

SimulatedStage::SimulatedStage(const SimulatedStageOptions& options,
                               link::SteadyClock clock,
                               std::function<void(const Edge&)> recorded)
    : options_(options),
      outputs_(std::move(clock), std::move(recorded)),
      levels_(BitOf(Input::kStop) | BitOf(Input::kDrives)) {}

SimulatedStage::~SimulatedStage() {
  for (int output = 0; output < kOutputCount; ++output)
    (void)Set(static_cast<Output>(output), false);
}

bool SimulatedStage::Has(Output output) const {
  if (output == Output::kEnable) return options_.has_enable;
  return output >= Output::kAlive;
}

bool SimulatedStage::Has(Input input) const {
  return input == Input::kStop || input >= Input::kFreeX;
}

Status SimulatedStage::Set(Output output, bool on) {
  if (!Has(output) || !outputs_.Change(output, on)) return {};
  const int axis = static_cast<int>(output) - static_cast<int>(Output::kStepX);
  if (!on || axis < 0 || axis > 2) return {};
  const bool powered = !options_.has_enable || is_on(Output::kEnable);
  const auto i = static_cast<std::size_t>(axis);
  const bool plus = is_on(DirectionOutput(axis)) != options_.steps.reversed[i];
  if (powered) steps_[i] += plus ? 1 : -1;
  return {};
}

Vec3 SimulatedStage::place_mm() const {
  Vec3 place_mm = options_.at_mm;
  for (int axis = 0; axis < 3; ++axis)
    place_mm[axis] += static_cast<double>(steps_[static_cast<std::size_t>(axis)]) /
                      options_.steps.steps_per_mm[axis];
  return place_mm;
}

bool SimulatedStage::IsPressed(int axis) const {
  const auto i = static_cast<std::size_t>(axis);
  if (stuck_free_[i]) return !*stuck_free_[i];
  const virtual_engraver::HomingOptions::Axis& at = options_.homing.axes[i];
  const double beyond_mm = place_mm()[axis] - at.switch_mm;
  return at.at_plus_end ? beyond_mm >= 0 : beyond_mm <= 0;
}

Result<std::uint32_t> SimulatedStage::Levels() {
  std::uint32_t levels = levels_;
  for (int axis = 0; axis < 3; ++axis)
    if (!IsPressed(axis)) levels |= BitOf(FreeInput(axis));
  return levels;
}

void SimulatedStage::Hold(Input input, bool on) {
  if (input == Input::kStop || input == Input::kDrives) {
    on ? levels_ |= BitOf(input) : levels_ &= ~BitOf(input);
  } else if (input >= Input::kFreeX && input <= Input::kFreeZ) {
    StuckFree(input) = on;
  }
}

}  // namespace intaglio::reference_controller
