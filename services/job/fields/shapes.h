#pragma once

// Messages of a job as the plain shapes of engrave/. All take jobs with every default
// filled in (services/job/convert/job_defaults.h); a broken precondition throws.

#include <optional>

#include "engrave/core/geometry.h"
#include "engrave/mesh/placement.h"
#include "engrave/optics/focus.h"
#include "proto/job.pb.h"

namespace intaglio {

Vec3 Vec3Of(const Vector3& v);

/// Width, depth, height, mm.
Vec3 BlockSizeOf(const JobSpec& job);

/// Where points may lie: the block minus its margin. Frame glass, mm.
Box3 PermittedBoxOf(const Block& block);

/// The way of a model into the job's block. `declared`: the up axis that its file
/// declares (mesh::UpAxisOfFile), for UP_AXIS_DECLARED. A placement without a unit has
/// that of its file, which is not known here: unit_mm is then 1.
mesh::Placement PlacementOf(const Placement& placement, const Block& block,
                            std::optional<mesh::UpAxis> declared = {});

optics::Lens LensOf(const JobSpec& job);

}  // namespace intaglio
