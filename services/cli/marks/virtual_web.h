#pragma once

// How fast the web of a virtual scan head runs for a job: of a real machine a person sets
// it.

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio::cli {

/// Share of the largest speed, and time that a place of the web is in the field if that
/// is slower: room for a computer that is late.
inline constexpr double kVirtualWebShare = 0.9;
inline constexpr double kVirtualWebS = 0.5;

/// 0: the job has no web, or the machine has none. The job's web.speed_mm_s; where that
/// is "as fast as possible", kVirtualWebShare of the largest speed at which all its marks
/// can be made, or the field in kVirtualWebS. Errors as of MakeJobMarks, OrderJobMarks
/// and WebRunOf.
Result<double> VirtualWebSpeed(const JobSpec& job, const MachineSpec& machine,
                               double size_limits);

}  // namespace intaglio::cli
