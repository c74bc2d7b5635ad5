#pragma once

// A controller that moves the stage and fires the laser, and its driver: one object that
// is both a motion driver and a laser driver. It has no line of bytes: its commands are
// calls, so that both interfaces are seen to ask for none.

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "services/drivers/interface/laser_controller.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/virtual_engraver/laser.h"
#include "services/virtual_engraver/stage.h"

namespace intaglio::cell {

/// Stage and laser on one clock, with a cable to their host and a mains switch. Silence
/// of 250 ms stops and closes both.
class OneMachine {
 public:
  static constexpr double kRateHz = 100, kFastRateHz = 4000;

  OneMachine(virtual_engraver::StageOptions stage, virtual_engraver::LaserOptions laser);

  /// A millisecond.
  void Advance();
  void SwitchOff();
  void SwitchOn();  ///< another clock, other counters
  void Cut(bool cut);
  /// After so many commands and questions more nothing passes.
  void CutAfter(std::uint64_t commands) { commands_left_ = commands; }
  /// False: the command is lost on its way.
  bool TakesCommand();

  bool reachable() const { return stage != nullptr && !cut_; }
  std::chrono::milliseconds now() const { return now_; }
  const std::vector<std::uint64_t>& fired_ticks() const { return fired_; }

  std::unique_ptr<virtual_engraver::Stage> stage;  ///< null: switched off, as the laser
  std::unique_ptr<virtual_engraver::Laser> laser;

 private:
  void PassTick();

  virtual_engraver::StageOptions stage_options_;
  virtual_engraver::LaserOptions laser_options_;
  bool cut_ = false;
  std::uint64_t commands_left_ = UINT64_MAX;
  std::chrono::milliseconds now_{0}, reached_at_{0};
  double next_tick_s_ = 0;
  std::vector<std::uint64_t> fired_;
};

class OneController final : public drivers::MotionDriver,
                            public drivers::LaserController {
 public:
  OneController(OneMachine& machine, std::string serial_number);

  // Both interfaces have it.
  int fd() const override { return -1; }

  // The motion driver.
  void Poll() override;
  const drivers::DriverState& state() const override { return state_; }
  std::vector<drivers::LatchedPositions> TakePositions() override;
  Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                  std::uint64_t start_ns) override;
  std::size_t Room() const override;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override;
  Status AbortRun() override;
  Status ClearFault() override;
  drivers::LaserController* laser() override { return this; }

  // The laser driver.
  void Poll(const ReportSink& sink, const PastSink& past) override;
  bool up() const override { return link_up_ && status_number_ > 0; }
  bool CanSend() const override { return link_up_; }
  bool taken_over() const override { return false; }
  const std::string& message() const override { return message_; }
  const std::string& refusal() const override { return state_.refusal; }
  const link::LaserIdentity& identity() const override { return identity_; }
  const link::LaserStatus& status() const override { return status_; }
  std::uint64_t status_number() const override { return status_number_; }
  std::chrono::nanoseconds status_at() const override { return reported_at_; }
  std::uint64_t session() const override { return sessions_; }
  bool disarmed() const override {
    return up() && status_.disarms_taken == disarms_sent_;
  }
  Status Lamp(bool on, double rate_hz) override;
  Status OpenShutters(std::uint8_t mask) override;
  Status Arm(const link::ArmWindow& window) override;
  Status Disarm() override;
  Status Reset() override;
  Status Stop() override;
  Status RequestStatus() override;
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override;

 private:
  /// Connection, and both states; what both Polls begin with.
  void Refresh();
  void Connect();
  void TakeState();
  void SetDown(intaglio_MotionFault fault, std::string why);
  template <typename Action>
  Status Command(Action action);

  OneMachine& machine_;
  std::string serial_number_;
  drivers::DriverState state_;
  link::LaserIdentity identity_;
  link::LaserStatus status_;
  std::string message_ = "the controller was not called yet";
  bool link_up_ = false;
  std::chrono::milliseconds reported_at_{0};
  std::uint64_t sessions_ = 0, status_number_ = 0, appended_ = 0;
  std::uint32_t disarms_sent_ = 0, begun_run_ = 0;
  std::vector<link::PastReport> pasts_;
};

}  // namespace intaglio::cell
