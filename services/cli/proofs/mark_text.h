#pragma once

#include <string>

#include "proto/report.pb.h"

namespace intaglio::cli {

/// The lines of a report of marks, above its verdict.
std::string MarkLines(const JobReport& report);

}  // namespace intaglio::cli
