#pragma once

// What a synchronizer reports for one task: the motion that it commands, what became of
// the points, how the task ended. Read from a recording, or live.
//
// A run is a pass from rest to rest (MotionSegmentBatch.run). How its segments and its
// pulses are cut into batches depends on timing, so neither is kept.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "idl/job.h"
#include "idl/laser.h"
#include "idl/motion.h"
#include "proto/task.pb.h"
#include "services/platform/recording/cdr_value.h"

namespace intaglio::replayer {

/// A MotionSegmentBatch.
struct SegmentMessages {
  std::string job_uid;
  std::uint32_t run = 0;
  std::uint64_t number = 0, start_tick = 0;
  bool abort = false, last = false;
  std::array<std::vector<double>, 6> columns;  ///< x y z vx vy vz; mm, mm/s
  std::vector<std::uint32_t> duration_subticks;
  std::vector<std::uint8_t> pulse;
};
/// A PulseEventBatch.
struct PulseMessages {
  std::string job_uid;
  std::vector<std::uint64_t> tick;
  std::vector<std::uint32_t> point;
  std::vector<std::uint8_t> outcome, reason;  ///< intaglio_PulseOutcome, _SkipReason
  std::uint64_t number = 0;                   ///< from 0 in each job, without gaps
};
/// A TaskStatus of the engraving stage.
struct StatusMessage {
  std::string job_uid;
  std::uint32_t attempt = 0;
  std::string stage, state, message;  ///< enums by name
  std::string error_code;             ///< ErrorCodeName; empty: none
  std::uint64_t done_count = 0, total_count = 0, estimate_ticks = 0;
  std::string outcome;  ///< intaglio.StageOutcome, serialized
  bool ended() const { return state == "TASK_DONE" || state == "TASK_FAILED"; }
};

// Nothing for a value that has not all the members, or columns of several lengths.
std::optional<SegmentMessages> ReadSegments(const recording::Value& value);
std::optional<PulseMessages> ReadPulses(const recording::Value& value);
std::optional<StatusMessage> ReadStatus(const recording::Value& value);
SegmentMessages MessageOf(const intaglio_MotionSegmentBatch& sample);
PulseMessages MessageOf(const intaglio_PulseEventBatch& sample);
StatusMessage MessageOf(const intaglio_TaskStatus& sample);

struct RunPulse {
  std::uint64_t tick = 0;
  std::uint32_t point = 0;
  std::uint8_t outcome = 0, reason = 0;
  bool fired() const { return outcome == intaglio_PULSE_MADE || missed(); }
  bool missed() const { return outcome == intaglio_PULSE_MISSED; }
};

struct CellRun {
  std::uint32_t number = 0;
  std::uint64_t start_tick = 0;
  std::uint64_t begun_ns = 0, ended_ns = 0;  ///< first batch; abort or last batch
  bool aborted = false, whole = false;
  std::uint64_t next_number = 0;  ///< of the batches of its segments
  bool respeeded = false;  ///< of a recording: the speed override changed meanwhile
  /// The recording ends before the run does, or has a gap there.
  bool open = false;
  std::array<std::vector<double>, 6> columns;
  std::vector<std::uint32_t> duration_subticks;
  std::vector<std::uint8_t> pulse;
  /// Armed points by tick, up to the last one that fired. Those behind it were taken back
  /// when the run was broken off; their number depends on timing.
  std::vector<RunPulse> pulses;

  /// It ended as planned, with all its points fired.
  bool undisturbed() const;
};

struct CellMessages {
  std::vector<CellRun> runs;
  std::vector<std::uint32_t> left_out;  ///< points, by the operator's decision
  std::vector<std::string> states;      ///< of the task, each once in a row
  std::optional<StatusMessage> end;
  std::size_t given_up_count = 0;   ///< runs of which nothing had fired
  std::uint32_t uncertain_run = 0;  ///< first run with a pulse of unknown result; 0: none
  /// First run of which batches are missing, by their numbers; 0: none.
  std::uint32_t incomplete_run = 0;
  bool disturbed() const;
  std::size_t broken_count() const;  ///< runs that were broken off
};

/// Gathers the reports in the order of their publication.
class CellListener {
 public:
  explicit CellListener(std::string job_uid) : job_uid_(std::move(job_uid)) {}
  /// `at_ns`: when it was published. True when it begins a run.
  bool Receive(const SegmentMessages& messages, std::uint64_t at_ns);
  void Receive(const PulseMessages& messages, std::uint64_t at_ns);
  void Receive(const StatusMessage& messages);
  const std::vector<CellRun>& runs() const { return messages_.runs; }
  /// Pulses of all runs.
  std::size_t fired_count() const { return fired_count_; }
  const std::string& message() const { return message_; }  ///< of the newest status
  const std::optional<StatusMessage>& end() const { return messages_.end; }
  /// With the pulses in their runs, and without the runs that were given up before
  /// anything of them had fired: they come and go with the speed of a host.
  CellMessages Messages() const;

 private:
  struct ReportedPulse {
    RunPulse pulse;
    std::uint64_t at_ns = 0;
  };
  bool MayBeOf(const CellRun& run, const ReportedPulse& sent) const;
  void NoteGap(std::uint32_t run);
  std::uint32_t RunAt(std::uint64_t at_ns) const;

  std::string job_uid_;
  CellMessages messages_;
  std::vector<ReportedPulse> pulses_;
  std::uint64_t next_pulses_ = 0;  // number of the next batch
  std::size_t fired_count_ = 0;
  std::string message_;
};

}  // namespace intaglio::replayer
