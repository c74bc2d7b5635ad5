#pragma once

// Compares what a synchronizer reported in the recording with what it reports now for the
// same task.
//
// Compared, bit by bit: of every run its segments (where the stage is at their ends, how
// fast, how long they take, whether a pulse may be made there), and of every armed point
// the tick, counted from the run's start, and what became of it; which points were left
// out; the states of the task, and all that it reports when it ends.
//
// Fields that depend on timing are not compared: kSetAside. Where an event outside broke
// a run off, motion is compared as far as both planned it, and points as far as the
// machine decided them; where the speed override changed, points and their order alone.

#include <array>
#include <optional>

#include "proto/replay.pb.h"
#include "services/replayer/cell/cell_messages.h"

namespace intaglio::replayer {

/// Fields that are not compared: when a person armed, how quick a host or a machine was
/// (a run that came too late is begun again), what the laser had counted before.
inline constexpr std::array kSetAside = {"MotionSegmentBatch.run",
                                         "MotionSegmentBatch.sequence_number",
                                         "MotionSegmentBatch.start_tick",
                                         "MotionSegmentBatch.start_controller_ns",
                                         "MotionSegmentBatch.controller_ns",
                                         "PulseEventBatch.sequence_number",
                                         "TaskStatus.worker",
                                         "TaskStatus.elapsed_s",
                                         "StageOutcome.elapsed_s",
                                         "EngraveOutcome.first_tick",
                                         "EngraveOutcome.last_tick",
                                         "EngraveOutcome.controller_pulse_count",
                                         "EngraveOutcome.run_count"};

/// Leaves the runs before run `run`, counted from 0, on both sides, and no end: of a
/// synchronizer that did not go on in that run.
void KeepRunsBefore(std::size_t run, CellMessages& then, CellMessages& now);

/// The first difference; absent: none. `counts` gets what was compared. The end is not
/// compared when `then` has none.
std::optional<SampleDifference> CompareCells(const CellMessages& then,
                                             const CellMessages& now,
                                             TaskComparison& counts);

}  // namespace intaglio::replayer
