#pragma once

// Jobs of a shop for people: what `intaglio list` and `intaglio show` print.

#include <ctime>
#include <string>
#include <vector>

#include "services/client/job_view.h"

namespace intaglio::cli {

/// A line for each job, by number, and below it how long the work in hand takes yet, and
/// why it is not going on or not good.
std::string ListText(std::vector<client::JobView> jobs,
                     std::time_t now = std::time(nullptr));
/// All about one.
std::string ShowText(const client::JobView& job, std::time_t now = std::time(nullptr));
/// The planned machining time; "-" while it is not known.
std::string TimeOf(const client::JobView& job);
/// Why a job is paused, failed, cancelled or not good, or what it waits for; empty:
/// nothing of that.
std::string ReasonOf(const client::JobView& job);

}  // namespace intaglio::cli
