#pragma once

// The glass that a job names, found in the material base, and what it does to the beam.

#include <string>

#include "engrave/core/result.h"
#include "materials_db/material.h"
#include "materials_db/material_store.h"
#include "proto/task.pb.h"
#include "services/cli/job/job_options.h"

namespace intaglio::cli {

/// Found by its name, another spelling or an alias; the job gets its name in the base,
/// and a note if that is another one. kNotFound names the field and similar glasses.
Result<materials_db::Material> FindGlass(JobAndMachine& job,
                                         const materials_db::MaterialStore& store);

/// The same in the base of that file; empty: the user's.
Result<materials_db::Material> FindGlass(JobAndMachine& job,
                                         const std::string& materials_db);

/// At the wavelength and the numerical aperture of the job. Errors as of FindGlass
/// and of ComputeOptics.
Result<materials_db::OpticalValues> FindOptics(JobAndMachine& job,
                                               const std::string& materials_db);

/// The job with everything resolved, in no shop: without a uid, an attempt and a folder.
/// Errors as of FindGlass and of FreezeJob.
Result<FrozenJob> FreezeWithGlass(JobAndMachine& job, const std::string& materials_db);

}  // namespace intaglio::cli
