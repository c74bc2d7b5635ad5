#pragma once

// How far the work in hand is, and how long it takes yet: the one computation, for
// `status`, the bars of `run` and `watch`, and the lines of `list` and `show`.

#include <chrono>
#include <string>

#include "services/client/job_view.h"

namespace intaglio::client {

struct WorkLeft {
  double share = 0;   ///< of the work that is done, 0..1
  double left_s = 0;  ///< 0: not known
};

/// `elapsed_s`: since the work began. `expected_s`: the whole time as planned, 0: not
/// known; it decides until the pace is known from a twentieth of the work. Not known
/// where nothing or all is done.
WorkLeft WorkLeftOf(double share, double elapsed_s, double expected_s);

/// The time of a job's engraving by its plan and the speed that was set, s; 0: not known.
/// `machine_speed`: multiple of real time; 0: as fast as it can.
double EngravingSeconds(const JobView& job, double machine_speed = 1);

/// Describes the stage at work; nothing where none is at work: before the first point,
/// paused, ended.
WorkLeft WorkLeftOf(const JobView& job);

/// When work that takes `left_s` yet ends: UTC, ISO 8601, ms.
std::string EndUtc(std::chrono::system_clock::time_point now, double left_s);

}  // namespace intaglio::client
