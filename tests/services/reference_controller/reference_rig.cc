#include "tests/services/reference_controller/reference_rig.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "services/drivers/laser_drivers.h"
#include "services/platform/link/serial_port.h"
#include "tests/services/reference_controller/frail_board.h"
#include "tests/test_folder.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;

constexpr char kControllerNumber[] = "R-03";

const drivers::LaserDriverKind& LineDriver() {
  return *std::ranges::find(drivers::LaserDriverKinds(), "virtual-laser",
                            &drivers::LaserDriverKind::protocol);
}

}  // namespace

ReferenceRig::ReferenceRig(const std::string& serial_number, ReferenceRigOptions options)
    : options_(options),
      path_(test::FreshFolder() / "laser"),
      wire_(std::make_shared<Wire>()) {
  SwitchOn();
  MachineSpec profile = options_.named;
  profile.set_name("els-03");
  profile.mutable_laser_line()->set_device(path_);
  profile.mutable_laser_line()->set_serial_number(
      serial_number.empty() ? kControllerNumber : serial_number);
  PulseTiming& timing = *profile.mutable_laser()->mutable_timing();
  timing.set_qswitch_delay_us(options_.qswitch_delay_us);
  timing.set_qswitch_width_us(options_.qswitch_width_us);
  const auto open = [this]() -> Result<std::unique_ptr<link::ByteStream>> {
    if (!controller_) return Fail(ErrorCode::kIo, "no such device");
    auto port = link::OpenSerialPort(path_, 115200);
    if (!port) return port;
    wire_->Renew();
    return std::make_unique<WireEnd>(std::move(*port), wire_->to_host,
                                     wire_->to_controller, wire_);
  };
  driver = LineDriver().make(profile, open, clock());
}

ReferenceRig::~ReferenceRig() {
  driver.reset();
  SwitchOff();
}

void ReferenceRig::CutLine(bool cut) { wire_->Cut(cut); }

void ReferenceRig::CutLineAfter(std::uint64_t bytes) { wire_->CutAfter(bytes); }

void ReferenceRig::SwitchOff() {
  controller_.reset();
  board_.reset();
  pins_.reset();
  line_.reset();
}

void ReferenceRig::SwitchOn() {
  auto line = virtual_engraver::PtyLine::Open(path_, "laser line");
  if (!line) throw std::runtime_error(line.error().message);
  line_.emplace(std::move(*line));
  fired_ticks_.clear();
  pins_ =
      std::make_unique<SimulatedPins>(options_.pins, clock(), [this](const Edge& edge) {
        edges_.push_back(edge);
        if (edge.output == Output::kQSwitch && edge.on) fired_ticks_.push_back(tick());
      });
  pins_->Hold(Input::kInPosition, false);
  board_ = std::make_unique<FrailBoard>(*pins_, board_is_broken_);
  ControllerOptions options;
  options.laser.rates_hz = {rate_hz(), fast_rate_hz()};
  options.laser.warm_up_s = 0.1;
  options.laser.power_up = ++power_up_;
  options.laser.channels = static_cast<std::uint8_t>(options_.pins.channels);
  options.laser.serial_number = kControllerNumber;
  options.laser.output_count = static_cast<std::size_t>(options_.pins.output_count);
  options.laser.inputs.resize(static_cast<std::size_t>(options_.pins.input_count));
  options.laser.min_energy_mj = options.laser.max_energy_mj = 30;
  options.laser.fires_at_place = options.laser.measures_energy = false;
  options.stage = [this]() -> StageWitness {
    return {stage_hangs_ ? now_ - 1s : now_ + 1ms, stage_runs_};
  };
  controller_ = std::make_unique<Controller>(
      options, *board_, ControllerTime{clock(), [this](std::chrono::nanoseconds until) {
                                         now_ = std::max(now_, until) + waits_late_;
                                       }});
  controller_->Plug(ControllerEnd());
}

std::unique_ptr<link::ByteStream> ReferenceRig::ControllerEnd() {
  return std::make_unique<WireEnd>(line_->MachineEnd(), wire_->to_controller,
                                   wire_->to_host, wire_);
}

void ReferenceRig::SetInput(int index, bool on) {
  pins_->Hold(SpareInput(index), on);
  Advance();
}

// A person is slower than a turn of the controller.
void ReferenceRig::Set(Interlock interlock, bool holds) {
  if (interlock == Interlock::kKey) pins_->Hold(Input::kKey, holds);
  if (interlock == Interlock::kDoor) pins_->Hold(Input::kDoor, holds);
  if (interlock == Interlock::kStopButton) pins_->Hold(Input::kStop, holds);
  Advance();
}

std::uint64_t ReferenceRig::tick() {
  return controller_ ? controller_->laser().tick() : 0;
}

std::uint8_t ReferenceRig::shutters() {
  unsigned open = 0;
  for (int channel = 0; channel < options_.pins.channels; ++channel)
    if (pins_ && pins_->is_on(ShutterOutput(channel))) open |= 1U << channel;
  return static_cast<std::uint8_t>(open);
}

void ReferenceRig::AdvanceController() {
  const auto end = now_ + std::chrono::milliseconds(1);
  if (!controller_) {
    now_ = end;
    return;
  }
  if (line_->HostHasGone()) {
    wire_->Renew();
    controller_->Plug(ControllerEnd());
  }
  while (now_ < end) {
    const auto idle = controller_->Turn();
    if (!idle) error_ = idle.error().message;
    // As the program waits, and a little of its own time.
    constexpr std::chrono::nanoseconds kTurn{10'000};
    const auto waits = idle ? std::max(*idle, kTurn) : kTurn;
    now_ = std::max(now_, std::min(end, now_ + waits));
  }
  wire_->CutBothWays();
}

}  // namespace intaglio::reference_controller
