#pragma once

// Freezes a job: everything that its making depends on is resolved, checked and put into
// one message, so that no stage looks anything up.

#include <cstdint>
#include <string>

#include "engrave/core/result.h"
#include "engrave/optics/focus.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "proto/material.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// The optical values of a glass for a wavelength and a lens. Fails when the glass has no
/// index there (its dispersion formula says where).
Result<OpticalValuesRecord> OpticalValuesOf(const MaterialRecord& material,
                                            double wavelength_nm,
                                            double numerical_aperture);

struct JobIdentity {
  std::string uid;
  std::uint64_t epoch = 0;
  std::string result_directory;
  std::string software_version;
};

/// Defaults, checks (all errors in one message, one a line), optical values. The weight
/// of a step up of the order Kdz, when left open, becomes the least that never fires
/// through an earlier crack (the tangent of the beam's cone in the glass), but at least
/// kLeastUpRatio, where the stage moves least.
Result<FrozenJob> FreezeJob(const JobSpec& job, const MachineSpec& machine,
                            const MaterialRecord& material, const JobIdentity& identity);

/// Measured: from 0.6 to 1.2 the way is shortest.
inline constexpr double kLeastUpRatio = 0.6;

}  // namespace intaglio
