#include "tests/services/reference_controller/reference_rig.h"

#include <poll.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "services/drivers/laser_drivers.h"
#include "services/platform/link/serial_port.h"
#include "tests/test_folder.h"

namespace intaglio::reference_controller {
namespace {

constexpr char kControllerNumber[] = "R-03";

/// One way of the wire. The kernel carries its bytes in its own time, the test's clock
/// stops for them: a reader waits for all that was written.
struct Way {
  bool cut = false;
  std::uint64_t cut_after = UINT64_MAX;
  std::uint64_t written = 0, read = 0, taken = 0;

  void Forget() { written = read = 0; }
};

class WireEnd final : public link::ByteStream {
 public:
  WireEnd(std::unique_ptr<link::ByteStream> inner, Way& in, Way& out,
          std::shared_ptr<void> owner)
      : inner_(std::move(inner)), in_(in), out_(out), owner_(std::move(owner)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    if (in_.read < in_.written) {
      constexpr int kPatienceMs = 2000;
      pollfd readable{inner_->fd(), POLLIN, 0};
      (void)poll(&readable, 1, kPatienceMs);
    }
    auto got = inner_->Read(buffer);
    if (got) in_.read += *got;
    return got;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    if (!out_.cut && out_.taken + bytes.size() > out_.cut_after) {
      const auto left = static_cast<std::size_t>(out_.cut_after - out_.taken);
      (void)Pass(bytes.first(left));
      out_.cut = true;
    }
    return out_.cut ? bytes.size() : Pass(bytes);
  }
  int fd() const override { return inner_->fd(); }

 private:
  Result<std::size_t> Pass(std::span<const std::byte> bytes) {
    auto sent = inner_->Write(bytes);
    if (sent) out_.written += *sent, out_.taken += *sent;
    return sent;
  }

  std::unique_ptr<link::ByteStream> inner_;
  Way &in_, &out_;
  std::shared_ptr<void> owner_;
};

/// Pins that can fail.
class FrailBoard final : public LaserPins {
 public:
  FrailBoard(LaserPins& pins, std::shared_ptr<bool> broken)
      : pins_(pins), broken_(std::move(broken)) {}
  bool Has(Output output) const override { return pins_.Has(output); }
  bool Has(Input input) const override { return pins_.Has(input); }
  Status Set(Output output, bool on) override {
    if (*broken_) return Broken();
    return pins_.Set(output, on);
  }
  Result<std::uint32_t> Levels() override {
    if (*broken_) return Broken();
    return pins_.Levels();
  }
  Result<std::optional<std::chrono::nanoseconds>> NextEdge(Input input) override {
    if (*broken_) return Broken();
    return pins_.NextEdge(input);
  }

 private:
  static tl::unexpected<Error> Broken() {
    return Fail(ErrorCode::kIo, "the board is broken");
  }
  LaserPins& pins_;
  std::shared_ptr<bool> broken_;
};

const drivers::LaserDriverKind& LineDriver() {
  return *std::ranges::find(drivers::LaserDriverKinds(), "virtual-laser",
                            &drivers::LaserDriverKind::protocol);
}

}  // namespace

struct ReferenceRig::Wire {
  Way to_controller, to_host;

  /// A new plug: nothing of the time before is in it.
  void Renew() {
    to_controller.Forget();
    to_host.Forget();
  }
};

ReferenceRig::ReferenceRig(const std::string& serial_number, ReferenceRigOptions options)
    : options_(options),
      path_(test::FreshFolder() / "laser"),
      wire_(std::make_shared<Wire>()) {
  SwitchOn();
  MachineSpec profile;
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

void ReferenceRig::CutLine(bool cut) {
  for (Way* way : {&wire_->to_controller, &wire_->to_host}) {
    way->cut = cut;
    way->cut_after = UINT64_MAX;
  }
}

void ReferenceRig::CutLineAfter(std::uint64_t bytes) {
  wire_->to_controller.cut_after = wire_->to_controller.taken + bytes;
}

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
  options.laser.min_energy_mj = options.laser.max_energy_mj = 30;
  options.laser.fires_at_place = options.laser.measures_energy = false;
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
  // A cut is of both ways.
  if (wire_->to_controller.cut) wire_->to_host.cut = true;
}

}  // namespace intaglio::reference_controller
