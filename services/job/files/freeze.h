#pragma once

// Freezes a job: everything that its making depends on is resolved, checked and put into
// one message, so that no stage has to resolve anything.

#include <cstdint>
#include <string>

#include "engrave/core/result.h"
#include "materials_db/material.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

struct JobIdentity {
  std::string uid;
  std::uint64_t epoch = 0;
  std::string result_directory;
  std::string software_version;
};

/// Defaults, checks (all errors in one message, one a line), optical values. The weight
/// of a step up of the order Kdz, when left open, follows from the beam's cone in the
/// glass (sort::DefaultUpRatio), and the direction of rows from the machine
/// (DefaultRowTurnDeg).
Result<FrozenJob> FreezeJob(const JobSpec& job, const MachineSpec& machine,
                            const materials_db::Material& material,
                            const JobIdentity& identity);

/// The same of a job of marks, which has no glass. A job of points on a machine that
/// marks, and a job of marks on one that engraves, are refused by name.
Result<FrozenJob> FreezeMarkJob(const JobSpec& job, const MachineSpec& machine,
                                const JobIdentity& identity);

}  // namespace intaglio
