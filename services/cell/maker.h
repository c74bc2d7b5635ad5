#pragma once

// What a kind of machine adds to the task of its cell (cell_task.h): the synchronizer
// makes points, the marker makes marks.

#include <chrono>
#include <cstdint>
#include <string>

#include "engrave/core/result.h"
#include "idl/job.h"
#include "proto/task.pb.h"
#include "services/cell/grant_inputs.h"
#include "services/cell/permission_chain.h"
#include "services/cell/work_states.h"

namespace intaglio::cell {

class Maker {
 public:
  virtual ~Maker() = default;

  /// The job that is made; null before it is prepared, and without one.
  virtual WorkStates* work() = 0;
  /// The controller that fires or marks answers.
  virtual bool line_up() const = 0;
  /// Why that controller is refused, or empty.
  virtual std::string Refusal() const = 0;
  /// Why every arm is spent while this lasts, be it that a line leads to another device
  /// than the profile's; or empty.
  virtual std::string WhyNoArmCounts() const = 0;
  /// Before a run: no shutter has to be open.
  virtual ChainLinks Links(const GrantInputs& inputs) const = 0;

  /// Checks the task and begins to receive what it makes, or, of a job that is taken up,
  /// to prepare what is on the disk. Nothing moves. `job` gets what the machine adds to
  /// it. An error ends the task.
  virtual Status Begin(FrozenJob& job, const intaglio_StageTask& task) = 0;
  /// One turn of work(), which is there.
  virtual void TurnWork(const GrantInputs& inputs) = 0;
  /// What a job that is made still waits for; empty: for nothing.
  virtual std::string PendingAtEnd() const { return {}; }
  /// Work is done, by itself or stopped; it is still there.
  virtual void NoteDone() {}
  virtual std::uint64_t estimate_ticks() const { return 0; }
  /// What this kind of machine knows besides.
  virtual void AddTo(EngraveOutcome& /*outcome*/) const {}
  /// Drops work and whatever was prepared. The journal's last records are on disk then.
  virtual void Drop() = 0;
  /// Behind Drop, before the end is published. `done`: not failed, not cancelled.
  virtual void NoteEnd(const std::string& /*job_uid*/, bool /*done*/) {}
};

}  // namespace intaglio::cell
