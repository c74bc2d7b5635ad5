#pragma once

#include <string>

#include "proto/report.pb.h"

namespace intaglio::cli {

/// The report of a block in a few lines for the terminal; the last are the verdict and
/// its reasons. Without a line end behind it.
std::string SummaryOf(const JobReport& report);

}  // namespace intaglio::cli
