#include "services/reference_controller/gpio_pins.h"

#include <fmt/format.h>
#include <gpiod.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <map>
#include <string>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;

constexpr char kConsumer[] = "intaglio-reference-controller";

struct ChipCloser {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};

/// A line that the board has; null: it has none.
struct Pin {
  gpiod_line* line = nullptr;
  std::string name = {};
  bool on = false;
};

tl::unexpected<Error> PinError(const Pin& pin, const char* what) {
  return Fail(
      ErrorCode::kIo,
      fmt::format("{}: cannot {} the line: {}", pin.name, what, std::strerror(errno)),
      pin.name);
}

class GpioPins final : public Pins {
 public:
  ~GpioPins() override {
    for (Pin& pin : outputs_)
      if (pin.line != nullptr) (void)gpiod_line_set_value(pin.line, 0);
  }

  Status Open(const std::vector<NamedLine>& lines) {
    for (const auto& [name, line] : lines) {
      const auto output = kOutputs.find(name);
      if (output != kOutputs.end())
        INTAGLIO_TRY(Request(name, line, outputs_[Index(output->second)], &OpenOutput));
    }
    for (const auto& [name, line] : lines) {
      const auto input = kInputs.find(name);
      if (input == kInputs.end()) continue;
      INTAGLIO_TRY(Request(name, line, inputs_[Index(input->second)],
                           HasEdges(input->second) ? &OpenEdges : &OpenInput));
    }
    return {};
  }

  bool Has(Output output) const override {
    return outputs_[Index(output)].line != nullptr;
  }
  bool Has(Input input) const override { return inputs_[Index(input)].line != nullptr; }

  Status Set(Output output, bool on) override {
    Pin& pin = outputs_[Index(output)];
    if (pin.line == nullptr || pin.on == on) return {};
    if (gpiod_line_set_value(pin.line, on ? 1 : 0) != 0) return PinError(pin, "set");
    pin.on = on;
    return {};
  }

  Result<std::uint32_t> Levels() override {
    std::uint32_t levels = 0;
    for (int i = 0; i < kInputCount; ++i) {
      const auto input = static_cast<Input>(i);
      const Pin& pin = inputs_[Index(input)];
      if (pin.line == nullptr || HasEdges(input)) continue;
      const int value = gpiod_line_get_value(pin.line);
      if (value < 0) return PinError(pin, "read");
      if (value > 0) levels |= BitOf(input);
    }
    return levels;
  }

  Result<std::optional<nanoseconds>> NextEdge(Input input) override {
    const Pin& pin = inputs_[Index(input)];
    if (pin.line == nullptr) return std::optional<nanoseconds>();
    const timespec at_once{};
    const int waiting = gpiod_line_event_wait(pin.line, &at_once);
    if (waiting == 0) return std::optional<nanoseconds>();
    gpiod_line_event event{};
    if (waiting < 0 || gpiod_line_event_read(pin.line, &event) != 0)
      return PinError(pin, "read an edge of");
    return std::optional(std::chrono::seconds(event.ts.tv_sec) +
                         nanoseconds(event.ts.tv_nsec));
  }

 private:
  using Opener = int (*)(gpiod_line*, bool active_low);
  static const std::map<std::string, Output> kOutputs;
  static const std::map<std::string, Input> kInputs;

  template <typename Signal>
  static std::size_t Index(Signal signal) {
    return static_cast<std::size_t>(signal);
  }
  static int OpenOutput(gpiod_line* line, bool active_low) {
    const int flags = active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    return gpiod_line_request_output_flags(line, kConsumer, flags, 0);
  }
  static int InputFlags(bool active_low) {
    return active_low
               ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW | GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP
               : GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  }
  static int OpenInput(gpiod_line* line, bool active_low) {
    return gpiod_line_request_input_flags(line, kConsumer, InputFlags(active_low));
  }
  static int OpenEdges(gpiod_line* line, bool active_low) {
    return gpiod_line_request_rising_edge_events_flags(line, kConsumer,
                                                       InputFlags(active_low));
  }

  Status Request(const std::string& name, const BoardLine& line, Pin& pin, Opener open) {
    auto& chip = chips_[line.chip()];
    if (!chip) chip.reset(gpiod_chip_open(line.chip().c_str()));
    pin.name = fmt::format("{}, line {} of {}", name, line.line(), line.chip());
    if (!chip) return PinError(pin, "open the chip of");
    gpiod_line* const found = gpiod_chip_get_line(chip.get(), line.line());
    if (found == nullptr) return PinError(pin, "find");
    if (open(found, line.active_low()) != 0) return PinError(pin, "request");
    pin.line = found;
    return {};
  }

  std::map<std::string, std::unique_ptr<gpiod_chip, ChipCloser>> chips_;
  std::array<Pin, kOutputCount> outputs_;
  std::array<Pin, kInputCount> inputs_;
};

const std::map<std::string, Output> GpioPins::kOutputs = {
    {"q_switch", Output::kQSwitch},
    {"shutters[0]", Output::kShutter1},
    {"shutters[1]", Output::kShutter2},
    {"shutters[2]", Output::kShutter3},
    {"shutters[3]", Output::kShutter4},
    {"lamp_trigger", Output::kLampTrigger},
    {"lamp", Output::kLamp},
    {"door_lock", Output::kDoorLock},
    {"outputs[0]", SpareOutput(0)},
    {"outputs[1]", SpareOutput(1)},
    {"outputs[2]", SpareOutput(2)},
    {"outputs[3]", SpareOutput(3)},
    {"outputs[4]", SpareOutput(4)},
    {"outputs[5]", SpareOutput(5)},
    {"outputs[6]", SpareOutput(6)},
    {"outputs[7]", SpareOutput(7)},
    {"alive", Output::kAlive},
    {"x.step", Output::kStepX},
    {"y.step", Output::kStepY},
    {"z.step", Output::kStepZ},
    {"x.direction", Output::kDirectionX},
    {"y.direction", Output::kDirectionY},
    {"z.direction", Output::kDirectionZ},
    {"enable", Output::kEnable},
    {"in_position_output", Output::kInPosition}};
const std::map<std::string, Input> GpioPins::kInputs = {
    {"key", Input::kKey},
    {"door", Input::kDoor},
    {"stop", Input::kStop},
    {"in_position", Input::kInPosition},
    {"lamp_sync", Input::kLampSync},
    {"photosensors[0]", Input::kPhotosensor1},
    {"photosensors[1]", Input::kPhotosensor2},
    {"photosensors[2]", Input::kPhotosensor3},
    {"photosensors[3]", Input::kPhotosensor4},
    {"x.free", Input::kFreeX},
    {"y.free", Input::kFreeY},
    {"z.free", Input::kFreeZ},
    {"drives", Input::kDrives},
    {"inputs[0]", SpareInput(0)},
    {"inputs[1]", SpareInput(1)},
    {"inputs[2]", SpareInput(2)},
    {"inputs[3]", SpareInput(3)},
    {"inputs[4]", SpareInput(4)},
    {"inputs[5]", SpareInput(5)},
    {"inputs[6]", SpareInput(6)},
    {"inputs[7]", SpareInput(7)}};

}  // namespace

Result<std::unique_ptr<Pins>> OpenGpioPins(const std::vector<NamedLine>& lines) {
  auto pins = std::make_unique<GpioPins>();
  INTAGLIO_TRY(pins->Open(lines));
  return std::unique_ptr<Pins>(std::move(pins));
}

}  // namespace intaglio::reference_controller
