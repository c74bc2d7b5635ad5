#pragma once

// Passes the motion of one cell to its controller, and the controller's position back to
// the bus.
//
//            batch 0 of a newer run               at rest, no fault
//   kIdle ------------------------> kBeginning ----------------------> kFeeding
//     ^                                  | abort batch                    | abort batch,
//     |                                  v                                | last segment
//     +--------------------------------------------------------------- <-+  appended
//
// kBeginning clears a fault and brakes an old run first. A batch of an older run is
// dropped. Motion by hand (services/cell/manual/manual_control.h) is executed in kIdle
// alone; a run that comes ends it, and begins when the stage is at rest. Flow: batch 0
// opens the run's Credit stream (MotionStream in the header of the synchronizer's side),
// a batch is consumed once the controller has all of it.

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/cell/manual/manual_desk.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/motion_bridge/profile_teacher.h"
#include "services/platform/bus/flow.h"
#include "services/platform/host/peers/machine_reporter.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/safety/stop_latch.h"

namespace intaglio::motion_bridge {

class Bridge {
 public:
  /// `machine`: the profile, read from `profile`, in which taught positions are saved.
  Bridge(host::ServiceHost& host, const MachineSpec& machine, std::string profile,
         std::unique_ptr<drivers::MotionDriver> driver);

  /// One turn: serial line, batches, controller, publications. Never blocks. Does and
  /// sends nothing more once state().taken_over.
  void Turn(std::chrono::nanoseconds now);

  bus::Reader<intaglio_MotionSegmentBatch>& batches() { return batches_; }
  bus::Reader<intaglio_EmergencyStop>& stops() { return stops_; }
  cell::ManualDesk& manual() { return manual_; }
  int fd() const { return driver_->fd(); }
  /// The longest time until the next turn, if no sample and nothing on the line comes
  /// before: of a stage that rests what its driver allows, else 10 ms.
  std::chrono::milliseconds wait() const;
  /// The laser of the controller; null: it only moves.
  drivers::LaserController* laser() { return driver_->laser(); }
  const drivers::DriverState& state() const { return driver_->state(); }
  /// The fault, or what a person should know of the controller; empty: all is well.
  std::string message() const;

 private:
  enum class Phase { kIdle, kBeginning, kFeeding };
  struct Batch {
    std::uint64_t number = 0;
    std::vector<motion::Segment> segments;
    std::vector<std::uint64_t> controller_ns;  // of their ends, or empty
    std::size_t appended = 0;
    bool last = false;
  };

  void TakeBatches();
  void Accept(const intaglio_MotionSegmentBatch& sample);
  void StartRun(const intaglio_MotionSegmentBatch& sample);
  void EndRun();
  /// Ends the run and commands the stage to end it, now or as soon as its line takes it.
  void AbortRun();
  void AlarmRefusal();
  void AlarmTolerance();
  void PublishAll(std::chrono::nanoseconds now);
  void TakeStops();
  void Begin(std::chrono::nanoseconds now);
  void Feed();
  void PublishState(std::chrono::nanoseconds now);
  void PublishPositions();

  host::ServiceHost& host_;
  std::string cell_;
  double position_tolerance_um_;
  std::unique_ptr<drivers::MotionDriver> driver_;
  bus::Reader<intaglio_MotionSegmentBatch> batches_;
  bus::Reader<intaglio_EmergencyStop> stops_;
  bus::Writer<intaglio_MotionState> states_;
  bus::Writer<intaglio_PositionReport> positions_;
  host::MachineReporter reporter_;
  bus::CreditGrantor credit_;

  ProfileTeacher teacher_;
  cell::ManualDesk manual_;
  bool abort_owed_ = false;
  Phase phase_ = Phase::kIdle;
  std::uint32_t run_ = 0;
  std::uint64_t start_tick_ = 0;
  std::uint64_t start_controller_ns_ = 0;
  Vec2 block_mm_ = Vec2::Zero();  ///< where the run needs the block's stage
  std::uint64_t expected_batch_ = 0;
  std::string stream_;
  std::deque<Batch> queue_;
  std::chrono::nanoseconds next_preparation_{0};
  /// What the newest MotionState was made of.
  struct PublishedState {
    drivers::DriverState driver;
    std::uint32_t run = 0;
    std::uint64_t stops = 0;
    bool operator==(const PublishedState&) const = default;
  };
  PublishedState published_;
  std::chrono::nanoseconds next_state_{0};
  std::uint64_t position_number_ = 0;
  host::StopLatch stop_;
  std::string alarmed_refusal_, tolerance_mismatch_;
};

}  // namespace intaglio::motion_bridge
