#pragma once

// A job as the job service knows it, between its threads, its database and the bus.

#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "idl/job.h"

namespace intaglio::job_service {

inline constexpr std::array kStages = {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT,
                                       intaglio_STAGE_ENGRAVE};

struct StageRecord {
  std::string worker;  ///< instance of the newest attempt; empty before the first
  bool done = false;
  std::uint64_t done_count = 0;
  std::uint64_t total_count = 0;
  double elapsed_s = 0;
};

struct JobRecord {
  std::uint32_t number = 0;  ///< for people, from 1
  std::string uid;           ///< <number>-<epoch in hex>
  std::string submission_uid;
  std::uint64_t epoch = 0;  ///< run of the job service that took it
  std::string name;
  std::string cell;
  double rate_hz = 0;
  std::string result_directory;
  std::string frozen_job;  ///< serialized FrozenJob

  intaglio_JobState state = intaglio_JOB_QUEUED;
  std::uint32_t attempt = 0;        ///< of the running chain; 0 before the first
  std::uint32_t lost_attempts = 0;  ///< chains that broke because a worker was lost
  std::string message;
  std::uint64_t estimate_ticks = 0;
  std::array<StageRecord, 3> stages;  ///< by intaglio_Stage
  std::uint64_t revision = 0;
  std::uint64_t last_command = 0;
  /// A permission was, or may have been, given: pulses may exist in the glass.
  bool ever_granted = false;

  // Not kept over a restart: an arm is a person's word about the machine as it is now.
  bool armed = false;
  std::uint32_t speed_percent = 100;  ///< override, 10..100
  std::uint64_t last_speed = 0;       ///< number of the override that was taken last
  std::string operator_name;
  std::string last_loss;  ///< why the attempt before this one broke
  std::chrono::nanoseconds withdrawn_at{0};
  std::chrono::nanoseconds armed_at{0};

  StageRecord& stage(intaglio_Stage s) { return stages[s]; }
  const StageRecord& stage(intaglio_Stage s) const { return stages[s]; }
  bool ended() const {
    return state == intaglio_JOB_DONE || state == intaglio_JOB_FAILED ||
           state == intaglio_JOB_CANCELLED;
  }
  /// Holds its cell: from the first task to the end.
  bool active() const { return !ended() && state != intaglio_JOB_QUEUED; }
};

}  // namespace intaglio::job_service
