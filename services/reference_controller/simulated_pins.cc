#include "services/reference_controller/simulated_pins.h"

#include <utility>

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;

// A flash comes with its trigger; the next look of a controller sees it.
constexpr nanoseconds kFlashAfter{1000};

}  // namespace

SimulatedPins::SimulatedPins(SimulatedPinsOptions options, link::SteadyClock clock,
                             std::function<void(const Edge&)> recorded)
    : options_(options),
      clock_(clock),
      outputs_(std::move(clock), std::move(recorded)),
      levels_(BitOf(Input::kKey) | BitOf(Input::kDoor) | BitOf(Input::kStop) |
              BitOf(Input::kInPosition)) {
  for (int i = 0; i < options_.input_count; ++i) Hold(SpareInput(i), true);
}

SimulatedPins::~SimulatedPins() {
  for (int output = 0; output < kOutputCount; ++output)
    (void)Set(static_cast<Output>(output), false);
}

bool SimulatedPins::Has(Output output) const {
  if (output > Output::kAlive) return false;
  if (output == Output::kLampTrigger) return options_.flash_period.count() == 0;
  if (output >= Output::kOutput1 && output <= Output::kOutput8)
    return output < SpareOutput(options_.output_count);
  const int shutter = static_cast<int>(output) - static_cast<int>(Output::kShutter1);
  return shutter < 0 || shutter >= 4 || shutter < options_.channels;
}

bool SimulatedPins::Has(Input input) const {
  if (input == Input::kLampSync)
    return options_.has_lamp_sync || options_.flash_period.count() > 0;
  if (input >= Input::kInput1) return input < SpareInput(options_.input_count);
  const int sensor = static_cast<int>(input) - static_cast<int>(Input::kPhotosensor1);
  return sensor < options_.channels && input < Input::kFreeX;
}

Status SimulatedPins::Set(Output output, bool on) {
  if (Has(output) && outputs_.Change(output, on) && on) Answer(output);
  return {};
}

void SimulatedPins::Answer(Output output) {
  if (output == Output::kLampTrigger && options_.has_lamp_sync)
    Edges(Input::kLampSync).push_back(clock_() + options_.sync_after);
  if (output != Output::kQSwitch) return;
  for (int channel = 0; channel < options_.channels; ++channel) {
    const bool blind = (options_.blind_channels >> channel & 1) != 0;
    if (is_on(ShutterOutput(channel)) && !blind)
      Edges(PhotosensorInput(channel)).push_back(clock_() + kFlashAfter);
  }
}

void SimulatedPins::FlashByItself() {
  if (options_.flash_period.count() == 0) return;
  const nanoseconds now = clock_();
  if (!is_on(Output::kLamp)) next_flash_ = now + options_.flash_period;
  for (; next_flash_ <= now; next_flash_ += options_.flash_period)
    Edges(Input::kLampSync).push_back(next_flash_);
}

Result<std::uint32_t> SimulatedPins::Levels() {
  if (options_.in_position != nullptr) Hold(Input::kInPosition, *options_.in_position);
  return levels_;
}

Result<std::optional<nanoseconds>> SimulatedPins::NextEdge(Input input) {
  FlashByItself();
  auto& edges = Edges(input);
  if (edges.empty() || edges.front() > clock_()) return std::optional<nanoseconds>();
  const nanoseconds at = edges.front();
  edges.pop_front();
  return std::optional(at);
}

void SimulatedPins::Hold(Input input, bool on) {
  levels_ = on ? levels_ | BitOf(input) : levels_ & ~BitOf(input);
}

}  // namespace intaglio::reference_controller
