#include "services/drivers/virtual/virtual_cell_driver.h"

#include <utility>

#include "services/drivers/virtual/virtual_laser_driver.h"
#include "services/drivers/virtual/virtual_stage_driver.h"

namespace intaglio::drivers {
namespace {

class VirtualCellDriver final : public MotionDriver, public LaserController {
 public:
  VirtualCellDriver(const MachineSpec& machine, std::array<link::FramePort, 2> ports,
                    link::SteadyClock clock)
      : stage_(MakeVirtualStageDriver(machine, ports[0])),
        laser_(MakeVirtualLaserDriver(machine, ports[1], std::move(clock))) {}

  int fd() const override { return stage_->fd(); }

  // The motion driver.
  void Poll() override { stage_->Poll(); }
  const DriverState& state() const override { return stage_->state(); }
  std::vector<LatchedPositions> TakePositions() override {
    return stage_->TakePositions();
  }
  Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                  std::uint64_t start_ns) override {
    return stage_->BeginRun(run, start_tick, start_ns);
  }
  Status RequireBlockAt(const Vec2& place_mm) override {
    return stage_->RequireBlockAt(place_mm);
  }
  std::size_t Room() const override { return stage_->Room(); }
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override {
    return stage_->Append(segments, end_ns);
  }
  Status AbortRun() override { return stage_->AbortRun(); }
  Status ClearFault() override { return stage_->ClearFault(); }
  // M16: armed ticks and open shutters are the laser's own matter; a pulse by hand needs
  // both, so they go first.
  Status Jog(const Vec3& axes, double speed_mm_s) override {
    DarkenForMotionByHand();
    return stage_->Jog(axes, speed_mm_s);
  }
  Status Home() override {
    DarkenForMotionByHand();
    return stage_->Home();
  }
  Status MoveBlock(const Vec2& place_mm, double speed_mm_s) override {
    DarkenForMotionByHand();
    return stage_->MoveBlock(place_mm, speed_mm_s);
  }
  Status Hold() override { return stage_->Hold(); }
  LaserController* laser() override { return this; }

  // The laser driver.
  void Poll(const ReportSink& sink, const PastSink& past) override {
    laser_->Poll(sink, past);
  }
  bool up() const override { return laser_->up(); }
  bool CanSend() const override { return laser_->CanSend(); }
  bool taken_over() const override { return laser_->taken_over(); }
  const std::string& message() const override { return laser_->message(); }
  const std::string& refusal() const override { return laser_->refusal(); }
  const link::LaserIdentity& identity() const override { return laser_->identity(); }
  bool simulates_time() const override { return laser_->simulates_time(); }
  const link::LaserStatus& status() const override { return laser_->status(); }
  std::uint64_t status_number() const override { return laser_->status_number(); }
  std::chrono::nanoseconds status_at() const override { return laser_->status_at(); }
  std::uint64_t session() const override { return laser_->session(); }
  bool disarmed() const override { return laser_->disarmed(); }
  Status Lamp(bool on, double rate_hz) override { return laser_->Lamp(on, rate_hz); }
  Status OpenShutters(std::uint8_t mask) override { return laser_->OpenShutters(mask); }
  Status Arm(const link::ArmWindow& window) override { return laser_->Arm(window); }
  Status Disarm() override { return laser_->Disarm(); }
  Status Reset() override { return laser_->Reset(); }
  Status Stop() override { return laser_->Stop(); }
  Status RequestStatus() override { return laser_->RequestStatus(); }
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override {
    return laser_->RequestPast(first_tick, count);
  }

 private:
  void DarkenForMotionByHand() {
    if (!laser_->CanSend() || !state().at_rest) return;  // what moves refuses it
    (void)laser_->OpenShutters(0);
    (void)laser_->Disarm();
  }

  std::unique_ptr<MotionDriver> stage_;
  std::unique_ptr<LaserController> laser_;
};

}  // namespace

std::unique_ptr<MotionDriver> MakeVirtualCellDriver(const MachineSpec& machine,
                                                    link::StreamOpener open,
                                                    link::SteadyClock clock) {
  return std::make_unique<VirtualCellDriver>(
      machine, link::FramePort::Divide(std::move(open), clock), clock);
}

}  // namespace intaglio::drivers
