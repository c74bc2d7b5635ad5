#pragma once

// A job as the job service knows it, between its threads, its database and the bus.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/warning.h"
#include "idl/job.h"
#include "services/job/machine/mounted_parts.h"
#include "services/job_service/records/job_arm.h"
#include "services/job_service/records/job_parts.h"
#include "services/job_service/records/part_comparison.h"
#include "services/job_service/records/task_id.h"

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

/// A task that some worker has, or had when it is done.
struct GivenTask {
  std::string worker;
  intaglio_Stage stage;
  TaskId task;
  bool done;
};

/// Where in its machine a job is made.
struct JobPlace {
  std::uint32_t station = 0;  ///< of a machine with a loading, from 1; else 0
  std::string block;          ///< its size, to be compared; empty: none
};

struct JobRecord {
  std::uint32_t number = 0;  ///< for people, from 1
  std::string uid;           ///< <number>-<epoch in hex>
  std::string submission_uid;
  std::uint64_t epoch = 0;  ///< run of the job service that took it
  std::string name;
  std::string cell;
  std::string material;
  std::string makes = "points";  ///< what its counts count, or "marks"
  std::int32_t priority = 0;     ///< JobSpec.priority, or that of where it was moved to
  std::int64_t turn = 0;         ///< among equal priorities, the least first (job_book.h)
  double rate_hz = 0;
  std::string result_directory;
  std::string frozen_job;  ///< serialized FrozenJob

  intaglio_JobState state = intaglio_JOB_QUEUED;
  intaglio_PauseReason pause_reason = intaglio_PAUSE_NONE;  ///< unless paused
  std::uint32_t attempt = 0;        ///< of the running chain; 0 before the first
  std::uint32_t lost_attempts = 0;  ///< chains that broke because a worker was lost
  std::string message;
  std::uint64_t estimate_ticks = 0;        ///< machining time, the newest estimate
  std::uint64_t first_estimate_ticks = 0;  ///< that of the sorter, before the order
  std::array<StageRecord, 3> stages;       ///< by intaglio_Stage
  JobParts parts;                          ///< of the discretizing; none before it
  JobArm arm;
  Warnings warnings;  ///< of the running attempt, once its points are made
  std::uint64_t revision = 0;

  // Not kept over a restart.
  std::string at_work;  ///< what the machine of a paused job still does; empty: it rests
  JobPlace place;       ///< made of the frozen job
  std::uint32_t queue_place = 0;      ///< queued: 1 is the next one of its machine
  bool awaits_block = false;          ///< no program arms it: piece_book.h
  std::string mount_misfit;           ///< of what is mounted, as of
  std::uint64_t mount_revision = 0;   ///< this MountBook::revision; 0: not compared
  std::uint32_t speed_percent = 100;  ///< override, 1..140
  std::optional<Nanoseconds> first_handout;  ///< when its workers were first asked for
  std::string last_loss;                     ///< why the attempt before this one broke
  std::string arm_loss;           ///< why its arm was spent before it had a path
  intaglio_PointCounts counts{};  ///< of the newest engraving
  std::string alarm;              ///< why that makes no progress; empty: it does
  std::optional<PartComparison> comparison;  ///< of one of its parts; empty: none
  std::string suspicion;  ///< of a discretizer that made one of them; empty: none
  bool taken_up = false;  ///< the newest engraving task: begun by another worker

  static constexpr const char* kAwaitsReport = "waits for the report about ";

  StageRecord& stage(intaglio_Stage s) { return stages[s]; }
  const StageRecord& stage(intaglio_Stage s) const { return stages[s]; }
  TaskId TaskOf(intaglio_Stage s, std::uint32_t part = 0) const {
    const bool in_parts = s == intaglio_STAGE_DISCRETIZE;
    return {uid, attempt, part, in_parts ? parts.at(part).attempt : 0};
  }
  /// Only while somebody is at its comparison.
  TaskId ComparisonTask() const {
    return {uid, attempt, comparison->part, comparison->part_attempt()};
  }
  /// By stage and part.
  std::vector<GivenTask> GivenTasks() const {
    std::vector<GivenTask> given;
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
      if (parts[i].worker.empty()) continue;
      given.push_back({parts[i].worker, intaglio_STAGE_DISCRETIZE,
                       TaskOf(intaglio_STAGE_DISCRETIZE, i), parts[i].done});
    }
    if (comparison && comparison->at_work()) {
      given.push_back(
          {comparison->worker, intaglio_STAGE_DISCRETIZE, ComparisonTask(), false});
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
  /// The service of its machine, as people are told.
  std::string_view maker() const { return makes == "marks" ? "marker" : "synchronizer"; }
  /// What a person puts into its machine.
  const char* workpiece() const { return WorkpieceOf(makes); }
  /// The warning that a person has to accept before the arm; nullptr: none.
  const Warning* open_consent() const {
    return arm.kept().breakage_accepted_by.empty() ? FindConsent(warnings) : nullptr;
  }
  /// All its points are ordered: no stage takes points of a discretizer any more.
  bool has_path() const {
    return stage(intaglio_STAGE_SORT).done ||
           stage(intaglio_STAGE_ENGRAVE).total_count > 0;
  }
  /// Whose reports, with the warnings about points and path, have not come yet, for
  /// people; empty: all warnings are known.
  std::string AwaitedReport() const {
    if (arm.ever_granted()) return "";
    for (std::uint32_t i = 0; i < parts.size(); ++i)
      if (!parts[i].done) return kAwaitsReport + parts.NameOf(i);
    return stage(intaglio_STAGE_SORT).done ? ""
                                           : kAwaitsReport + std::string("the order");
  }
  /// Its message is one of AwaitedReport.
  bool shows_awaited_report() const { return message.starts_with(kAwaitsReport); }
  /// All its warnings are known, and a person has accepted those that need it.
  bool warnings_are_settled() const {
    return AwaitedReport().empty() && open_consent() == nullptr;
  }
  /// Why nothing may be granted yet for want of a comparison of its points, for people;
  /// empty: they are settled.
  std::string WhyNotSettled() const {
    if (arm.ever_granted()) return "";
    if (!suspicion.empty() || !comparison) return suspicion;
    return "waits until " + parts.NameOf(comparison->part) +
           " is made by another discretizer and compared";
  }
  /// Its machine has the whole path, or is at it: it may be granted a permission.
  bool may_be_granted() const {
    return warnings_are_settled() && WhyNotSettled().empty() &&
           (state == intaglio_JOB_WAITING_FOR_ARM || state == intaglio_JOB_ENGRAVING ||
            state == intaglio_JOB_PAUSED);
  }
  /// Holds its cell: from the first task to the end.
  bool active() const { return !ended() && state != intaglio_JOB_QUEUED; }
};

}  // namespace intaglio::job_service
