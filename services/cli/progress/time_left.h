#pragma once

// How long work in hand takes yet, as people read it: the same for the bar of `run` and
// `watch` and for the lines of `list` and `show`.

#include <ctime>
#include <string>

#include "services/client/job_view.h"

namespace intaglio::cli {

struct TimeLeft {
  std::string left;  ///< "7 min 02 s left"; empty: not known
  std::string
      ends;  ///< from a minute on "ends 14:32", by this computer's clock; else empty
};

/// `share`: of the work that is done, 0 to 1. `elapsed_s`: since it began. `expected_s`:
/// the whole time as planned, 0: not known; it decides until the pace is known from a
/// twentieth of the work. Nothing where nothing or all is done.
TimeLeft TimeLeftOf(double share, double elapsed_s, double expected_s, std::time_t now);

/// The time of a job's engraving by its plan and the speed that was set, s; 0: not known.
/// `machine_speed`: multiple of real time; 0: as fast as it can.
double EngravingSeconds(const client::JobView& job, double machine_speed = 1);

/// Describes the stage at work: "52 %, 7 min 02 s left, ends 14:32"; empty where
/// nothing is at work: before the first point, paused, ended.
std::string TimeLeftText(const client::JobView& job, std::time_t now);

}  // namespace intaglio::cli
