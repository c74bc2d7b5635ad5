#pragma once

// What goes into the queue and what comes out of it: the samples of the bus as plain
// values.

#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/warning.h"
#include "idl/job.h"
#include "services/job/machine/mounted_parts.h"
#include "services/job_service/records/task_id.h"

namespace intaglio::job_service {

/// A task for a worker, or its revocation.
struct TaskOrder {
  std::string worker;
  intaglio_Stage stage = intaglio_STAGE_DISCRETIZE;
  TaskId task;
  std::string consumer;  ///< instance that takes the output; empty: none
  bool revoked = false;
  /// What another worker began: path and journal are on disk. Of a revocation: it will
  /// be taken up again.
  bool take_up = false;
};

/// JobCommand.
struct CommandView {
  std::string sender;
  std::uint64_t number = 0;
  std::string job_uid;
  std::uint64_t epoch = 0;
  intaglio_JobCommandKind kind = intaglio_COMMAND_ARM;
  std::string operator_name;
  std::uint64_t disarm_count = 0;
  std::uint32_t from_point = 0;
  bool fire_uncertain = false;
  std::uint32_t speed_percent = 100;
  bool accept_breakage = false;
  intaglio_ArmBasis basis = intaglio_ARM_BY_PROGRAM;
  std::string block_id;
  std::string cell;  ///< mount: the machine, and what is in it
  MountedParts mounted;
  std::string before_job_uid;  ///< move: empty: behind all that wait
  std::string worker;          ///< admit: its instance
  std::string mount_error;     ///< why `mounted` cannot be read; empty: it can
};
/// Range of the speed override, % of the job's speed limits (Trochimczuk 2008, 6.4.2).
inline constexpr std::uint32_t kMinSpeedPercent = 1, kMaxSpeedPercent = 140;

/// JobCommandAnswer.
struct CommandAnswer {
  intaglio_CommandAnswerCode code = intaglio_ANSWER_TAKEN;
  std::string message;  ///< one sentence a person can act on; empty when taken
  bool taken() const { return code == intaglio_ANSWER_TAKEN; }
};

/// TaskStatus, without its outcome.
struct TaskView {
  TaskId task;
  intaglio_Stage stage = intaglio_STAGE_DISCRETIZE;
  std::string worker;
  intaglio_TaskState state = intaglio_TASK_ACCEPTED;
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;
  double elapsed_s = 0;
  std::uint64_t estimate_ticks = 0;
  intaglio_ErrorCode error_code = intaglio_ERROR_NONE;
  intaglio_PauseReason pause_reason = intaglio_PAUSE_NONE;
  std::string message;
  /// Its job's warnings, as far as they are known with this report; nullopt: as before.
  std::optional<Warnings> warnings;
  intaglio_PointCounts counts{};
  std::string alarm;
  std::string checksum;  ///< discretize, when done: of the part

  /// Failed of what a neighbour's death causes as well: worth another attempt.
  bool failed_by_neighbour() const {
    return error_code == intaglio_ERROR_LINK_LOST ||
           error_code == intaglio_ERROR_TIMED_OUT ||
           error_code == intaglio_ERROR_CANCELLED;
  }
  bool ended() const {
    return state == intaglio_TASK_DONE || state == intaglio_TASK_FAILED;
  }
};

/// Permission of one cell; a cell without an armed job has none.
struct PermissionView {
  std::string cell;
  std::string job_uid;
  std::uint64_t epoch = 0;
  bool granted = false;
  std::string operator_name;
  std::uint32_t speed_percent = 100;
  std::uint64_t grant = 0, renewal = 0;
  std::uint32_t first_point = 0;
  bool fire_uncertain = false;
};

}  // namespace intaglio::job_service
