#pragma once

// The service of one cell: takes an EngraveTask, its path, and has it made; publishes the
// bus what is going on. Everything that decides about a pulse is in engraving.h.

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "proto/machine.pb.h"
#include "proto/task.pb.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/safety/stop_latch.h"
#include "services/platform/host/stage/flow.h"
#include "services/synchronizer/cell_drive.h"
#include "services/synchronizer/engraving.h"
#include "services/synchronizer/job_planner.h"
#include "services/synchronizer/lamp_hold.h"
#include "services/synchronizer/light_by_hand.h"
#include "services/synchronizer/mounted_parts.h"
#include "services/synchronizer/publisher.h"

namespace intaglio::synchronizer {

class Synchronizer {
 public:
  /// `machine`: the profile of this cell, read from `machine_file`; no value of the
  /// machine is taken from a task. `mounted`: as far as it is known. `laser`: not null.
  Synchronizer(host::ServiceHost& host, const MachineSpec& machine,
               std::string machine_file, const MountedParts& mounted,
               std::unique_ptr<drivers::LaserController> laser);
  ~Synchronizer();

  /// One turn of the loop; never blocks.
  void Turn(std::chrono::nanoseconds now);
  /// No more pulses: disarms, closes the shutters. Turn until stopped(). The job is not
  /// over: the next synchronizer that is given it takes it up from the journal.
  void Stop();
  bool stopped() const { return !engraving_ && !(lamp_hold_.holds() && laser_.up()); }
  /// Another synchronizer has the laser: Turn does nothing more.
  bool taken_over() const { return laser_.taken_over(); }

  /// The laser controller answers: from now on openings of key and door are counted.
  bool watches() const { return laser_.up(); }

  int line_fd() const { return laser_.fd(); }
  int journal_fd() const { return journal_ ? journal_->event_fd() : -1; }
  template <typename Loop>
  void AttachTo(Loop& loop) {
    loop.Attach(tasks_);
    loop.Attach(permissions_);
    loop.Attach(stops_);
    loop.Attach(motion_);
    loop.Attach(positions_);
    loop.Attach(by_hand_);
    loop.Attach(intake_.reader());
    loop.Attach(credit_.reader());
  }

 private:
  void AlarmRefusal();
  void TakeTasks();
  void Begin(const intaglio_StageTask& task);
  Status TakeTaught();
  void TakePermission(std::chrono::nanoseconds now);
  /// A press that was not known: this turn at least is stopped.
  void NoteStop(std::string_view source, std::string_view reason);
  void SendStop();
  void TakeMotion(std::chrono::nanoseconds now);
  void TakePositions();
  void TakePath();
  /// `path`: none when it is in the job's folder already.
  void Prepare(std::optional<PointCloud> path);
  void TakePrepared();
  void StartEngraving(PreparedJob prepared);
  /// `name`: of the taught position, for people; of the job with this uid.
  void Drive(const char* name, bool taught, const Vector3& axes,
             const std::string& job_uid);
  void TurnDrive();
  void TurnLight();
  void TakePlan();
  void FailTask(const Error& error);
  void Engrave(std::chrono::nanoseconds now);
  void RaiseNoProgress(const std::string& alarm);
  void DropTask();
  void EndTask(intaglio_TaskState state, intaglio_ErrorCode code,
               const std::string& message);
  EngraveOutcome Outcome() const;
  EngravingInputs InputsAt(std::chrono::nanoseconds now);
  /// While no path is there: an arm may have been given already.
  void WatchMachine(std::chrono::nanoseconds now);

  host::ServiceHost& host_;
  MachineSpec machine_;
  std::string machine_file_;
  MountedParts mounted_;
  std::string cell_;
  bus::Reader<intaglio_StageTask> tasks_;
  bus::Reader<intaglio_Permission> permissions_;
  bus::Reader<intaglio_EmergencyStop> stops_;
  bus::Reader<intaglio_MotionState> motion_;
  bus::Reader<intaglio_PositionReport> positions_;
  bus::Reader<intaglio_ManualState> by_hand_;
  bus::CreditBook credit_;
  bus::Writer<intaglio_MotionSegmentBatch> segments_;
  host::PathIntake intake_;
  JobPlanner planner_;
  Publisher publisher_;
  std::unique_ptr<drivers::LaserController> laser_driver_;
  drivers::LaserController& laser_;
  LightByHand light_;
  LampHold lamp_hold_;
  MotionFeed feed_;
  CellDrive drive_;
  std::string drive_name_, drive_job_;
  PermissionChain chain_;
  std::unique_ptr<JournalWriter> journal_;
  std::unique_ptr<Engraving> engraving_;

  std::optional<FrozenJob> job_;
  std::uint32_t attempt_ = 0;
  PlanSummary plan_;  ///< Of the whole job, without pauses; empty until it is computed.
  bool planned_ = false;  ///< The computation of plan_ has ended.
  bool cancelled_ = false;
  bool taken_up_ = false;  ///< from another process
  bool leaves_ = false;
  std::string logged_message_;
  std::string alarmed_refusal_;
  bool progress_alarmed_ = false;
  std::chrono::nanoseconds now_{0};
  std::chrono::nanoseconds worked_{
      0};  ///< at the job in hand, without what it waited for
  std::chrono::nanoseconds turned_at_{0};  ///< when it was engraved last
  MotionView motion_view_;
  MotionClock motion_clock_;
  /// What the clock's stamps are of: it, the laser's power-up, and the lamp's rate.
  struct ClockPair {
    std::uint32_t motion = 0, laser = 0;
    double rate_hz = 0;
    bool operator==(const ClockPair&) const = default;
  };
  ClockPair clock_pair_;
  std::uint64_t clock_from_tick_ = 0;  ///< at this rate since then
  std::chrono::nanoseconds motion_at_{-1};
  std::chrono::nanoseconds permission_at_{-1};
  bool permission_granted_ = false;
  std::uint64_t permission_epoch_ = 0;
  Grant permission_grant_;
  std::uint32_t first_point_ = 0;
  bool fire_uncertain_ = false;
  std::string permission_job_;
  std::uint32_t speed_percent_ = 100;
  host::StopLatch stop_;
  bool stop_came_ = false;  ///< in this turn, though it may be released by now
  std::uint64_t stop_sent_session_ = 0;  ///< to the laser; 0: not
};

}  // namespace intaglio::synchronizer
