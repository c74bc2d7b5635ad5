#pragma once

#include "proto/report.pb.h"

namespace intaglio::client {

/// What is wrong with the marks of a report: a sentence for each kind of fault, with the
/// first marks that have it by number, item and place.
void AddMarkFaults(const JobReport& report, Verdict& verdict);

}  // namespace intaglio::client
