#pragma once

// Drives the stage to the taught sample position before a job and to the park position
// after it, and the stage that carries the block to the job's place, by CellMove, which
// the motion bridge executes as motion by hand (services/cell/manual/manual_control.h):
// within its limits, only while key, door and stops hold, and as long as this process
// repeats it. It ends when the place is reached, when the bridge refuses it, has ended it
// kAttempts times, or after its patience: a job never waits longer. A bridge that has
// no report of key and door yet, because it or the laser controller has just started, is
// asked again for kReportPatience: the arm that the drive is for holds meanwhile, or ends
// it.
//
// Nothing is driven during a run; no pulse is armed meanwhile. Used from one thread.

#include <chrono>
#include <cstdint>
#include <string>

#include "engrave/core/geometry.h"
#include "proto/machine.pb.h"
#include "services/platform/bus/bus.h"

namespace intaglio::synchronizer {

class CellDrive {
 public:
  static constexpr std::chrono::seconds kPatience{60};
  static constexpr double kSpeedMmS = 30;
  static constexpr int kAttempts = 3;
  static constexpr std::chrono::seconds kReportPatience{5};

  CellDrive(bus::Bus& bus, std::string cell, std::string sender);

  struct Place {
    std::string name;  ///< for people: "taught park position"
    intaglio_ManualCommandKind kind = intaglio_MANUAL_MOVE;
    Vec3 axes = Vec3::Zero();
    double speed_mm_s = kSpeedMmS;
    std::chrono::nanoseconds patience = kPatience;
  };

  /// From the next Turn on, instead of what was driven to; of the job with this uid.
  void Start(Place place, const std::string& job_uid, std::chrono::nanoseconds now);
  void Stop();
  /// Once a turn.
  void Turn(std::chrono::nanoseconds now);
  bool drives() const { return drives_; }
  /// Why the last place was not reached; empty: it was.
  const std::string& message() const { return message_; }
  /// The name of the last place.
  const std::string& name() const { return place_.name; }
  const std::string& job_uid() const { return job_uid_; }

 private:
  void Send();

  std::string cell_, sender_;
  Place place_;
  std::string job_uid_;
  bus::Reader<intaglio_ManualState> states_;
  bus::Writer<intaglio_ManualCommand> moves_;
  bool drives_ = false;
  int attempts_ = 0;
  std::uint64_t number_ = 0, seen_ = 0;
  std::chrono::nanoseconds ends_at_{0}, known_by_{0}, next_send_{0};
  std::string message_;
};

}  // namespace intaglio::synchronizer
