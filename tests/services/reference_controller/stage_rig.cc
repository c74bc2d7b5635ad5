#include "tests/services/reference_controller/stage_rig.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "services/drivers/motion_drivers.h"
#include "services/platform/link/serial_port.h"
#include "tests/services/reference_controller/frail_board.h"
#include "tests/test_folder.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;
using drivers::ControllerFault;

constexpr char kStageNumber[] = "S-03";
constexpr double kStepsPerMm = 400;
constexpr std::chrono::nanoseconds kTick = 10ms;

const drivers::MotionDriverKind& StageLineDriver() {
  return *std::ranges::find(drivers::MotionDriverKinds(), "virtual-stage",
                            &drivers::MotionDriverKind::protocol);
}

StageControllerOptions OptionsOf(const StageRig& rig) {
  StageControllerOptions options;
  options.stage.travel_min_mm = rig.travel_min_mm();
  options.stage.travel_max_mm = rig.travel_max_mm();
  options.stage.mechanics.lag_s = 0;
  options.stage.position_tolerance_mm = 0.01;
  options.stage.following_error_limit_mm = 0.1;
  options.stage.queue_capacity = 64;
  options.stage.serial_number = kStageNumber;
  options.stage.max_speed_mm_s = Vec3::Constant(50);
  options.stage.homing.emplace();
  for (auto& axis : options.stage.homing->axes)
    axis = {false, rig.travel_min_mm().x() - 0.5, 70};
  options.stage.homing->acceleration_mm_s2 = 700;
  options.steps.steps_per_mm = Vec3::Constant(kStepsPerMm);
  options.steps.reversed = {false, true, false};
  options.turn = 50us;
  return options;
}

}  // namespace

StageRig::StageRig(const std::string& serial_number, bool homes)
    : options_(OptionsOf(*this)),
      path_(test::FreshFolder() / "motion"),
      wire_(std::make_shared<Wire>()),
      // Near its switches, where home is short; or within the travel.
      place_mm_(options_.stage.travel_min_mm + Vec3::Constant(homes ? -0.4 : 1)) {
  SwitchOn();
  if (homes) {
    controller_->stage().Home();
    do TurnUntil(now_ + 1ms);
    while (controller_->stage().running());
  }
  MachineSpec profile;
  profile.set_name("els-03");
  profile.mutable_motion_line()->set_device(path_);
  profile.mutable_motion_line()->set_serial_number(serial_number.empty() ? kStageNumber
                                                                         : serial_number);
  const auto open = [this]() -> Result<std::unique_ptr<link::ByteStream>> {
    if (!controller_) return Fail(ErrorCode::kIo, "no such device");
    auto port = link::OpenSerialPort(path_, 115200);
    if (!port) return port;
    wire_->Renew();
    return std::make_unique<WireEnd>(std::move(*port), wire_->to_host,
                                     wire_->to_controller, wire_);
  };
  driver = StageLineDriver().make(profile, open, clock());
}

StageRig::~StageRig() {
  driver.reset();
  SwitchOff();
}

void StageRig::SwitchOff() {
  controller_.reset();
  board_.reset();
  if (pins_) place_mm_ = pins_->place_mm();
  pins_.reset();
  line_.reset();
}

void StageRig::SwitchOn() {
  auto line = virtual_engraver::PtyLine::Open(path_, "motion line");
  if (!line) throw std::runtime_error(line.error().message);
  line_.emplace(std::move(*line));
  options_.stage.own_clock = virtual_engraver::OwnClockOptions{0, 0, ++power_up_, 0};
  pins_ = std::make_unique<SimulatedStage>(
      SimulatedStageOptions{options_.steps, *options_.stage.homing, place_mm_}, clock(),
      [this](const Edge& edge) { Record(edge); });
  board_ = std::make_unique<FrailBoard>(*pins_, board_is_broken_);
  controller_ = std::make_unique<StageController>(
      options_, *board_, ControllerTime{clock(), [this](std::chrono::nanoseconds until) {
                                          now_ = std::max(now_, until);
                                        }});
  controller_->Plug(ControllerEnd());
}

void StageRig::Record(const Edge& edge) {
  edges_.push_back(edge);
  if (!edge.on || edge.output < Output::kStepX || edge.output > Output::kStepZ) return;
  ++step_count_;
  stepped_at_ = edge.at;
}

void StageRig::PowerCycle() {
  SwitchOff();
  StepFor(1s);
  SwitchOn();
}

std::unique_ptr<link::ByteStream> StageRig::ControllerEnd() {
  return std::make_unique<WireEnd>(line_->MachineEnd(), wire_->to_controller,
                                   wire_->to_host, wire_);
}

bool StageRig::Inflict(ControllerFault fault) {
  if (fault == ControllerFault::kEmergencyStop) {
    pins_->Hold(Input::kStop, false);
  } else if (fault == ControllerFault::kAlarm) {
    pins_->Hold(Input::kDrives, false);
  } else if (fault == ControllerFault::kLimit) {
    pins_->Hold(Input::kFreeX, false);
  } else {
    return MotionRig::Inflict(fault);
  }
  return true;
}

void StageRig::Relieve(ControllerFault fault) {
  MotionRig::Relieve(fault);
  if (!pins_) return;
  pins_->Hold(Input::kStop, true);
  pins_->Hold(Input::kDrives, true);
  pins_->Release(Input::kFreeX);
}

bool StageRig::LosePlace() {
  pins_->Hold(Input::kDrives, false);
  StepFor(5ms);
  pins_->Hold(Input::kDrives, true);
  StepFor(5ms);
  return true;
}

bool StageRig::FindPlace() {
  return driver->Home() && Until([this] { return driver->state().at_rest; }, 20s) &&
         driver->state().homed;
}

bool StageRig::moves() { return now_ - stepped_at_ < 20ms; }

std::chrono::nanoseconds StageRig::TimeOf(std::uint64_t tick) const {
  return first_tick_at_ + static_cast<std::int64_t>(tick) * kTick;
}

std::uint64_t StageRig::NsOfTick(std::uint64_t tick) {
  return controller_ ? controller_->NsAt(TimeOf(tick)) : 1;
}

// A step between the command and the count, one between the press of a switch and the
// edge that makes it, and 1 ms at the speed of the touch.
double StageRig::tolerance_mm() const { return 2 / kStepsPerMm * 1.8 + 0.001; }

void StageRig::TurnUntil(std::chrono::nanoseconds end) {
  while (now_ < end) {
    const auto next_tick_at = TimeOf(tick_ + 1);
    if (now_ >= next_tick_at) {
      ++tick_;
      if (controller_) controller_->ReceiveTick({tick_, next_tick_at, rate_hz()});
    }
    auto wake = std::min(end, TimeOf(tick_ + 1));
    if (controller_) {
      const auto idle = controller_->Turn();
      if (!idle) error_ = idle.error().message;
      wake = std::min(wake, now_ + (idle ? std::max(*idle, 1'000ns) : 1'000'000ns));
    }
    now_ = std::max(now_, wake);
  }
}

void StageRig::AdvanceController() {
  if (controller_ && line_->HostHasGone()) {
    wire_->Renew();
    controller_->Plug(ControllerEnd());
  }
  TurnUntil(now_ + 1ms);
  wire_->CutBothWays();
}

}  // namespace intaglio::reference_controller
