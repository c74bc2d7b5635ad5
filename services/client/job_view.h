#pragma once

// What a client sees of a shop: samples of the bus as plain values, and their names for
// people and programs.

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/warning.h"
#include "idl/job.h"
#include "idl/service.h"
#include "services/job/machine/mounted_parts.h"
#include "services/platform/bus/samples.h"

namespace intaglio::client {

/// A JobStatus, copied.
struct JobView {
  std::string uid, submission_uid, name, message, result_directory, cell;
  std::uint64_t epoch = 0;
  std::uint32_t number = 0;
  std::uint32_t attempt = 0;
  intaglio_JobState state = intaglio_JOB_QUEUED;
  intaglio_PauseReason pause_reason = intaglio_PAUSE_NONE;  ///< unless paused
  struct Progress {
    intaglio_Stage stage;
    std::uint64_t done_count = 0, total_count = 0;
    double elapsed_s = 0;

    bool ended() const { return total_count > 0 && done_count >= total_count; }
  };
  std::vector<Progress> progress;
  std::uint64_t estimate_ticks = 0;
  double rate_hz = 0;
  std::uint64_t revision = 0;
  std::uint32_t speed_percent = 100;
  bool armed = false;  ///< by an operator: what is paused goes on by itself
  std::uint64_t disarm_count = 0;
  std::string disarm_reason;         ///< of the last one
  Warnings warnings;                 ///< of the running attempt, once its points are made
  std::string breakage_accepted_by;  ///< empty: nobody
  std::string makes = "points";      ///< what its counts count, or "marks"
  intaglio_PointCounts counts{};     ///< of the newest engraving; all 0 before its path
  std::string verdict;               ///< of an ended job, as in the history; else empty
  std::string alarm;  ///< why its engraving makes no progress; empty: it does
  /// Its machine was not opened and closed again since the last piece: no program arms
  /// it.
  bool awaits_block = false;
  std::string block_id;  ///< of the loader that armed it; empty: no loader did
  /// Place of a job that waits for its machine: 1 is the next one; else 0.
  std::uint32_t queue_place = 0;

  /// Done, failed or cancelled.
  bool ended() const;
  /// What a person puts into the machine for it.
  const char* workpiece() const { return WorkpieceOf(makes); }
  /// The warning that a person has to accept before the arm; nullptr: none.
  const Warning* open_consent() const {
    return breakage_accepted_by.empty() ? FindConsent(warnings) : nullptr;
  }
  /// A person paused it, and no person has resumed it.
  bool paused_by_operator() const {
    return pause_reason == intaglio_PAUSE_OPERATOR && !armed;
  }
};

/// For people: "queued", "waiting for arm", ...
std::string NameOf(intaglio_JobState state);
/// The same, with "armed" where a person has armed it and it does not fire yet:
/// "discretizing, armed"; "armed" instead of "waiting for arm", and what keeps it from
/// firing: "armed, the lamp warms up".
std::string StateOf(const JobView& job);
/// The same from what programs read: `state` is "waiting_for_arm", ...
/// (history::StateName).
std::string StateOf(std::string_view state, bool armed, std::string_view message);
/// "at 50 % speed"; empty at 100 %.
std::string SpeedNote(std::uint32_t speed_percent);
/// "discretize", "order", "engrave".
const char* NameOf(intaglio_Stage stage);

/// "intaglio arm 3", with the option that accepts a warning where one is needed.
std::string ArmCommandOf(const JobView& job);

/// The stage at work, or null while none is.
const JobView::Progress* StageAtWork(const JobView& job);

struct ServiceView {
  std::string instance, host, cell, message;
  std::string version;  ///< of its software
  intaglio_ServiceRole role = intaglio_ROLE_JOB_SERVICE;
  intaglio_HealthState state = intaglio_HEALTH_STARTING;
  int pid = 0;
  std::chrono::steady_clock::time_point reported_at;  ///< its newest health, received
  /// Why the job service gives it nothing more; empty: it does, or it is not known.
  std::string left_out = {};
  /// It has the role of a synchronizer, and makes marks or contours by one line to one
  /// controller: its machine has neither a motion bridge nor a lamp.
  bool is_marker() const {
    return role == intaglio_ROLE_SYNCHRONIZER && instance.starts_with("marker-");
  }
};

/// From a service's own health, or from what the job service knows of it.
template <typename Sample>
ServiceView ServiceViewOf(const Sample& sample,
                          std::chrono::steady_clock::time_point reported_at) {
  using bus::View;
  return {std::string(View(sample.instance)),
          std::string(View(sample.host)),
          std::string(View(sample.cell)),
          std::string(View(sample.message)),
          std::string(View(sample.version)),
          sample.role,
          sample.state,
          sample.pid,
          reported_at};
}

/// What a person asks of a job.
struct JobOrder {
  intaglio_JobCommandKind kind = intaglio_COMMAND_ARM;
  std::uint32_t from_point = 0;  ///< resume: open points before that place are left out
  bool fire_uncertain = false;   ///< resume: uncertain points are fired again
  std::uint32_t speed_percent = 100;  ///< speed: 1..140
  bool accept_breakage = false;       ///< arm, resume: the glass may break
  /// Arm, resume: what it is based on.
  intaglio_ArmBasis basis = intaglio_ARM_BY_PROGRAM;
  std::string block_id = {};  ///< arm by a loader: the block that it has put in
  /// Move: the waiting job that it is to precede; empty: behind all that wait.
  std::string before_job_uid = {};
};

/// A CellMount, copied.
struct MountView {
  MountedParts parts;
  std::string operator_name, mounted_utc;
};

/// A DiskSpace, copied.
struct DiskView {
  std::string instance, folder;
  std::uint64_t free_bytes = 0, total_bytes = 0;
};

/// "taken", "stop_pressed", ...
const char* NameOf(intaglio_CommandAnswerCode code);

/// A JobCommandAnswer, copied.
struct CommandReply {
  intaglio_CommandAnswerCode code = intaglio_ANSWER_TAKEN;
  std::string message;  ///< one sentence a person can act on; empty when taken
  bool taken() const { return code == intaglio_ANSWER_TAKEN; }
};

/// user@host, for people.
std::string OperatorName();

}  // namespace intaglio::client
