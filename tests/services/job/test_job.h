#pragma once

// A job and a machine that are right in every field, for tests to break.

#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

JobSpec GoodJob();
MachineSpec GoodMachine();

}  // namespace intaglio
