#pragma once

// Driver of a machine whose axes and laser are LinuxCNC's HAL, with the configuration of
// deploy/linuxcnc: MotionDriver and LaserController in one object. The profile:
//   motion_line { protocol: "linuxcnc" device: "/run/intaglio-linuxcnc" }
//   laser_line { protocol: "motion-output" }
// where the device is the folder of deploy/linuxcnc/start.
//
// Rows are sent at most kLead_s ahead of the newest one that HAL has reported; what is
// decided later than that is too late. A tick is a whole number of servo periods, two at
// least, and begins with the row that may fire; ticks are counted by the rows played, so
// while no host sends rows no tick passes.
//
// Deviations: rates of the profile that are no whole number of periods are not offered.
// Of ticks of an earlier session only those that fired are remembered with their outcome,
// the others as not armed. HAL counts ticks in 32 bits: it has to be started again within
// 99 days at 500 Hz.

#include <deque>
#include <memory>

#include "proto/machine.pb.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/drivers/linuxcnc/hal_session.h"
#include "services/drivers/linuxcnc/laser_ticks.h"
#include "services/drivers/linuxcnc/row_course.h"
#include "services/drivers/linuxcnc/row_jog.h"
#include "services/job/machine/laser_setting.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class LinuxcncDriver final : public MotionDriver, public LaserController {
 public:
  // Bounds what a Disarm has to fence off, and how long a killed host's rows play on.
  static constexpr double kLead_s = 0.1;
  static constexpr std::uint32_t kMaxPeriods = 1'000'000;  ///< of a tick
  /// `lead_s`: above the 20 ms that a report takes and what the host may be late, s.
  LinuxcncDriver(const MachineSpec& machine, HalOpener open, link::SteadyClock clock,
                 double lead_s = kLead_s);

  int fd() const override { return session_.fd(); }

  // MotionDriver
  void Poll() override;
  const DriverState& state() const override { return state_; }
  std::vector<LatchedPositions> TakePositions() override {
    return std::exchange(positions_, {});
  }
  Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                  std::uint64_t start_ns) override;
  std::size_t Room() const override;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override;
  Status AbortRun() override;
  Status ClearFault() override;
  LaserController* laser() override { return this; }
  /// Rows of a straight way, with the shutter closed and no tick armed. HAL stops the
  /// axes when the host is gone. Home is not offered: the axes' file of the machine does
  /// it, before HAL takes rows.
  Status Jog(const Vec3& axes, double speed_mm_s) override;

  // LaserController
  void Poll(const ReportSink& sink, const PastSink& past) override;
  bool up() const override { return session_.up() && status_number_ > 0; }
  bool CanSend() const override { return up(); }
  bool taken_over() const override { return session_.fenced(); }
  const std::string& message() const override { return session_.message(); }
  const std::string& refusal() const override { return session_.refusal(); }
  const link::LaserIdentity& identity() const override { return identity_; }
  const link::LaserStatus& status() const override { return status_; }
  std::uint64_t status_number() const override { return status_number_; }
  std::chrono::nanoseconds status_at() const override { return status_at_; }
  std::uint64_t session() const override { return session_.sessions(); }
  bool disarmed() const override;
  Status Lamp(bool on, double rate_hz) override;
  Status OpenShutters(std::uint8_t mask) override;
  Status Arm(const link::ArmWindow& window) override;
  Status Disarm() override;
  Status Reset() override;
  Status Stop() override;
  Status RequestStatus() override;
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override;

 private:
  /// A row that HAL has not reported yet.
  struct SentRow {
    std::uint64_t number = 0, tick = 0, arm = 0, motion = 0;
    bool sync = false;  ///< the first of its tick
    LaserTicks::Decision decision;
    bool knot = false;      ///< a knot marked for a pulse lies here
    std::uint32_t run = 0;  ///< 0: none
    bool by_hand = false;   ///< of a jog
    bool last = false;      ///< of its run or jog
    Vec3 position_mm = Vec3::Zero();
  };

  void Turn();
  void BeginSession();
  void SetDown();
  void Receive(const HalSample& sample);
  void TakeRow(const HalSample& sample);
  void TakeSync(const SentRow& row, const HalSample& sample);
  void TakeRest(const HalSample& sample);
  void TakeLatches(const HalSample& sample);
  link::TickOutcome OutcomeOf(const SentRow& row, const HalSample& sample) const;
  void UpdateState(const HalSample& sample);
  void UpdateStatus(const HalSample& sample);
  void SendRows();
  SentRow NextRow();
  void FollowCourse(SentRow& row);
  void FollowJog(SentRow& row);
  void SetFault(intaglio_MotionFault fault, std::string message);
  void Brake();
  bool Inside(const Vec3& place_mm) const;
  bool interlocked() const;
  std::uint64_t sent_through() const;
  std::uint32_t PeriodsOf(double rate_hz) const;
  double period_s() const { return session_.identity().period_ns * 1e-9; }
  double tick_s() const { return period_s() * periods_; }
  Status LinkLost() const { return Fail(ErrorCode::kLinkLost, session_.message()); }

  HalSession session_;
  link::SteadyClock clock_;
  Box3 travel_;
  Vec3 max_speed_mm_s_, max_acceleration_mm_s2_;
  double lead_s_;
  EnergyRange energies_;  ///< one of each wavelength
  std::vector<double> profile_rates_hz_;
  std::uint64_t begun_sessions_ = 0;

  // rows
  std::deque<SentRow> sent_;
  std::uint64_t next_row_ = 0, next_tick_ = 0;  // of the next row
  std::uint32_t next_period_ = 0, periods_ = 2, wanted_periods_ = 2;

  // motion
  RowCourse course_;
  RowJog jog_;
  std::uint32_t lost_places_ = 0;  ///< times that axes-homed went off
  bool run_in_flight_ = false;     ///< rows of the run are not reported yet, or to come
  bool jog_in_flight_ = false;     ///< the same of a jog
  bool run_lost_ = false;          ///< by a lost line
  bool clearing_ = false;
  bool settled_ = false;  ///< `place_mm_` is where the axes rest
  int still_samples_ = 0;
  Vec3 place_mm_ = Vec3::Zero();
  Vec3 last_actual_mm_ = Vec3::Zero();
  DriverState state_;
  std::vector<LatchedPositions> positions_;

  // laser
  LaserTicks ticks_;
  link::LaserIdentity identity_;
  link::LaserStatus status_;
  std::uint64_t status_number_ = 0;
  std::chrono::nanoseconds status_at_{0};
  std::uint32_t disarms_ = 0;
  std::uint64_t disarm_number_ = 0;  ///< arm number of the newest Disarm
  bool shutter_open_ = false;
  std::uint64_t reset_number_ = 0;  ///< of the command that ended the newest Reset
};

std::unique_ptr<MotionDriver> MakeLinuxcncDriver(const MachineSpec& machine,
                                                 link::StreamOpener open,
                                                 link::SteadyClock clock);

}  // namespace intaglio::drivers
