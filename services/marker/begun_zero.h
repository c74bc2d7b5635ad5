#pragma once

// The work zero that a job is made with, on a machine whose controller keeps one (G54 of
// a mill or a laser cutter): in job.json beside the journal before the first run, and
// compared with the controller's before each run, also by the process that takes the job
// up. What is cut with another zero would not fit to what is cut already.
//
//   not begun         each grant takes the zero that is set now
//   begun             every arm is refused while the controller's zero is another one
//   axes lost (K10)   of a machine without switches: the zero that a person has set
//                     since is the one; the axes count from another place, so there is
//                     nothing to compare it with
//
// The zero is a place in the axes of the controller, mm. Used from one thread.

#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/drivers/interface/mark_driver.h"

namespace intaglio::marker {

class BegunZero {
 public:
  /// Controllers report three decimals.
  static constexpr double kSameZero_mm = 0.002;

  /// Another job. `taken_up`: its zero is in its folder. kIo, kUnreadable.
  Status Begin(const FrozenJob& job, bool taken_up);

  struct Sight {
    bool started = false;    ///< something of the job may have been made
    bool has_grant = false;  ///< by which a run may begin
  };
  /// Once a turn, before a run can begin. At rest it may write job.json.
  void Turn(const FrozenJob& job, const drivers::MarkDeviceState& state, Sight sight);

  /// Why every arm is refused, and what to do; empty: arms count.
  const std::string& refusal() const { return refusal_; }

 private:
  void Record(const FrozenJob& job, const drivers::MarkDeviceState& state);

  std::string job_uid_;
  std::optional<Vec3> zero_mm_;
  /// The number for zero_mm_; 0 for a job that was begun before the driver was there.
  std::uint32_t axes_number_ = 0;
  bool taken_up_ = false;
  std::string refusal_;
};

}  // namespace intaglio::marker
