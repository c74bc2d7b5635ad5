#pragma once

// From the bytes of a JobSubmission to a frozen job, or to all that is wrong with it.

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "engrave/core/result.h"
#include "materials_db/material.h"
#include "proto/freeze.h"
#include "proto/task.pb.h"

namespace intaglio::job_service {

using FindMaterial =
    std::function<Result<materials_db::Material>(const std::string& name)>;

/// Reads the machine file, looks the glass up, checks and freezes. The error's message
/// holds every mistake, one a line, also when machine or glass are not to be had.
Result<FrozenJob> FreezeSubmission(std::span<const std::uint8_t> job_bytes,
                                   const FindMaterial& find_material,
                                   const JobIdentity& identity);

}  // namespace intaglio::job_service
