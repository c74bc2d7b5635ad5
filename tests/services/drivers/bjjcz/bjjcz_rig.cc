#include "tests/services/drivers/bjjcz/bjjcz_rig.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <span>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

bjjcz::VirtualBjjczOptions BoardOf(BjjczLaser laser) {
  bjjcz::VirtualBjjczOptions options;
  options.needs_oscillator = laser == BJJCZ_LASER_FIBRE;
  return options;
}

class BjjczMarkRig final : public MarkRig {
 public:
  BjjczMarkRig(BjjczLaser laser, const std::string& serial_number)
      : laser_(laser), machine_(laser) {
    driver = MakeDriver(serial_number);
  }

  void CutLine(bool cut) override { machine_.Cut(cut); }
  bool Inflict(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) {
      machine_.SwitchOff();
    } else if (fault == ControllerFault::kEmergencyStop) {
      machine_.board.SetInput(kBjjczDoorInput, false);
    } else if (fault == ControllerFault::kUnplug) {
      machine_.Cut(true);
    } else {
      return false;  // it has neither limits nor a hold nor a reset of its own
    }
    return true;
  }
  void Relieve(ControllerFault fault) override {
    if (fault == ControllerFault::kPowerCycle) machine_.SwitchOn();
    if (fault == ControllerFault::kEmergencyStop)
      machine_.board.SetInput(kBjjczDoorInput, true);
    if (fault == ControllerFault::kUnplug) machine_.Cut(false);
  }
  bool knows_power_ups() const override { return false; }
  void SetDoor(bool closed) override { machine_.board.SetInput(kBjjczDoorInput, closed); }
  std::unique_ptr<MarkDriver> MakeDriver(const std::string& serial_number) override {
    MachineSpec profile = BjjczProfile(laser_);
    if (!serial_number.empty())
      profile.mutable_mark_line()->set_serial_number(serial_number);
    return machine_.MakeDriver(profile);
  }
  std::uint64_t work_count() override { return machine_.board.work_count(); }
  bool is_on() override { return machine_.board.lit(); }
  mark::MarkSet MarksFor(int count) override {
    mark::Pen pen;
    pen.name = "mark";
    pen.speed_mm_s = 100;
    pen.power_ratio = 0.5;
    pen.frequency_hz = 20000;
    mark::MarkSet set{{pen}, {}};
    for (int i = 0; i < count; ++i) {
      mark::Mark mark;
      mark.closed = true;
      mark.places = {{Vec2(10.0 * i - 30, 5), 1}, {Vec2(10.0 * i - 22, 5), 1}};
      set.marks.push_back(mark);
    }
    return set;
  }
  std::chrono::milliseconds stop_time() const override { return 60ms; }

 private:
  void AdvanceController() override { machine_.Advance(); }

  BjjczLaser laser_;
  BjjczMachine machine_;
};

}  // namespace

MachineSpec BjjczProfile(BjjczLaser laser) {
  MachineSpec machine;
  machine.set_name("board");
  machine.mutable_mark_line()->set_protocol("bjjcz");
  machine.mutable_mark_line()->set_device("/dev/null");
  machine.mutable_mark_line()->set_serial_number(kBjjczSerialNumber);
  machine.mutable_scan_head()->set_field_mm(100);
  machine.mutable_scan_head()->set_jump_mm_s(5000);
  machine.mutable_scan_head()->set_laser_on_delay_s(20e-6);
  machine.mutable_scan_head()->set_laser_off_delay_s(30e-6);
  machine.mutable_scan_head()->set_jump_delay_s(200e-6);
  machine.mutable_bjjcz_board()->set_laser(laser);
  machine.mutable_bjjcz_board()->set_door_input(kBjjczDoorInput);
  machine.mutable_bjjcz_board()->set_lamp_output(5);
  machine.mutable_bjjcz_board()->set_guide_output(8);
  return machine;
}

BjjczMachine::BjjczMachine(BjjczLaser laser) : board(BoardOf(laser)) {}

void BjjczMachine::Cut(bool cut) {
  if (!to_board_) return;
  to_board_->cut = to_host_->cut = cut;
}

void BjjczMachine::Advance() {
  now_ += 1ms;
  if (end_) {
    std::array<std::byte, 97> bytes;
    while (const std::size_t count = end_->Read(bytes).value_or(0))
      board.Write({reinterpret_cast<const char*>(bytes.data()), count});
  }
  board.Advance(1000);
  const std::string sent = board.Read();
  if (end_ && !sent.empty()) (void)end_->Write(std::as_bytes(std::span(sent)));
}

// Each opening is a connection of its own, through the same cable.
std::unique_ptr<MarkDriver> BjjczMachine::MakeDriver(const MachineSpec& profile) {
  const auto clock = [this] { return now_; };
  const auto open = [this, clock]() -> Result<std::unique_ptr<link::ByteStream>> {
    const bool cut = to_board_ && to_board_->cut;
    to_board_ = std::make_shared<link::FaultyPipe>();
    to_host_ = std::make_shared<link::FaultyPipe>();
    to_board_->cut = to_host_->cut = cut;
    board.Reopen();
    end_ = std::make_unique<link::FaultyEnd>(to_board_, to_host_, random_, clock);
    return std::make_unique<link::FaultyEnd>(to_host_, to_board_, random_, clock);
  };
  const auto kinds = MarkDriverKinds();
  const auto kind = std::ranges::find(kinds, "bjjcz", &MarkDriverKind::protocol);
  return kind->make(profile, open, clock);
}

std::unique_ptr<MarkRig> MakeBjjczMarkRig(const std::string& name,
                                          const std::string& serial_number) {
  return std::make_unique<BjjczMarkRig>(
      name == "bjjcz_fibre" ? BJJCZ_LASER_FIBRE : BJJCZ_LASER_UV, serial_number);
}

}  // namespace intaglio::drivers
