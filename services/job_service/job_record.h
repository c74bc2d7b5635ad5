#pragma once

// A job as the job service knows it, between its threads, its database and the bus.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "idl/job.h"
#include "services/job_service/task_id.h"

namespace intaglio::job_service {

inline constexpr std::array kStages = {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT,
                                       intaglio_STAGE_ENGRAVE};

struct StageRecord {
  /// Instance of the newest attempt; empty before the first, and always of the
  /// discretizing, whose parts have theirs.
  std::string worker;
  bool done = false;
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;
  double elapsed_s = 0;
};

/// A part of the discretizing of the newest attempt.
///
///   open --given--> at work --> done
///     ^-- lost, silent or failed by a neighbour's fault: attempt + 1 --|
///
/// Given ahead it waits at its worker until the one before has ended. To be lost there is
/// not its fault, so it is no loss of its own.
struct PartRecord {
  std::string worker;         ///< empty: open
  std::uint32_t attempt = 0;  ///< in this attempt of the job
  std::uint32_t losses = 0;   ///< while it was worked on
  bool done = false;
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;
  std::chrono::nanoseconds not_before{0};  ///< when it may be given again
};

/// A task that some worker has, or had when it is done.
struct GivenTask {
  std::string worker;
  intaglio_Stage stage;
  TaskId task;
  bool done;
};

struct JobRecord {
  std::uint32_t number = 0;  ///< for people, from 1
  std::string uid;           ///< <number>-<epoch in hex>
  std::string submission_uid;
  std::uint64_t epoch = 0;  ///< run of the job service that took it
  std::string name;
  std::string cell;
  std::string material;
  std::int32_t priority = 0;  ///< JobSpec.priority
  double rate_hz = 0;
  std::string result_directory;
  std::string frozen_job;  ///< serialized FrozenJob

  intaglio_JobState state = intaglio_JOB_QUEUED;
  intaglio_PauseReason pause_reason = intaglio_PAUSE_NONE;  ///< unless paused
  std::uint32_t attempt = 0;        ///< of the running chain; 0 before the first
  std::uint32_t lost_attempts = 0;  ///< chains that broke because a worker was lost
  std::string message;
  std::uint64_t estimate_ticks = 0;
  std::array<StageRecord, 3> stages;  ///< by intaglio_Stage
  std::vector<PartRecord> parts;      ///< of the discretizing; none before it
  std::uint64_t revision = 0;
  std::uint64_t last_command = 0;  ///< count of those taken; a speed is not counted
  /// Sender and number of the command that changed the job last: after a power failure
  /// it may come once more and be in no table of answers.
  std::string last_command_id;
  /// A permission was, or may have been, given: pulses may exist in the glass.
  bool ever_granted = false;

  /// After a loss it waits for the operator (JobSpec.ask_before_resume).
  bool asks_before_resume = false;
  /// An arm is a person's word about the machine as it is now: over a restart it is kept
  /// only if that was short.
  bool armed = false;
  /// Grows when a person pauses or stops the job, and when an arm is withdrawn or would
  /// have been: an ARM that was sent before it has no effect.
  std::uint64_t disarm_count = 0;
  std::string disarm_reason;  ///< of the last one
  std::string operator_name;
  std::uint32_t first_point = 0;  ///< as in Permission: for good
  bool fire_uncertain = false;    ///< as in Permission: of the newest command alone

  // Not kept over a restart.
  std::uint32_t speed_percent = 100;  ///< override, 10..100
  std::string last_loss;              ///< why the attempt before this one broke
  std::string part_loss;  ///< why a part of this one began again, the last time
  std::string arm_loss;   ///< why its arm was spent before it had a path
  std::chrono::nanoseconds discretizing_since{0};
  std::chrono::nanoseconds withdrawn_at{0};
  std::chrono::nanoseconds armed_at{0};
  std::uint64_t renewal = 0;  ///< of the arm, when it was let go on by itself
  bool taken_up = false;      ///< the newest engraving task: begun by another worker
  std::uint32_t losses = 0;   ///< without a point made between them
  std::uint64_t done_at_loss = 0;
  /// Since then nothing was received from its synchronizer; nullopt: it is there.
  std::optional<std::chrono::nanoseconds> absent_since;

  /// Over a restart nobody knows how long an absence has lasted by then.
  bool keeps_arm_over_restart() const { return armed && !absent_since; }
  StageRecord& stage(intaglio_Stage s) { return stages[s]; }
  const StageRecord& stage(intaglio_Stage s) const { return stages[s]; }
  TaskId TaskOf(intaglio_Stage s, std::uint32_t part = 0) const {
    const bool in_parts = s == intaglio_STAGE_DISCRETIZE;
    return {uid, attempt, part, in_parts ? parts.at(part).attempt : 0};
  }
  /// By stage and part.
  std::vector<GivenTask> GivenTasks() const {
    std::vector<GivenTask> given;
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
      if (parts[i].worker.empty()) continue;
      given.push_back({parts[i].worker, intaglio_STAGE_DISCRETIZE,
                       TaskOf(intaglio_STAGE_DISCRETIZE, i), parts[i].done});
    }
    for (const intaglio_Stage s : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
      if (stage(s).worker.empty()) continue;
      given.push_back({stage(s).worker, s, TaskOf(s), stage(s).done});
    }
    return given;
  }
  bool ended() const {
    return state == intaglio_JOB_DONE || state == intaglio_JOB_FAILED ||
           state == intaglio_JOB_CANCELLED;
  }
  /// Holds its cell: from the first task to the end.
  bool active() const { return !ended() && state != intaglio_JOB_QUEUED; }
};

}  // namespace intaglio::job_service
