#pragma once

// The profile of a scan head over a block with what its test cube showed.

#include "engrave/calibrate/cube_fit.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"
#include "services/client/machine/corrected_profile.h"

namespace intaglio::client {

/// What the marks of a job were made with: the profile and the job's glass. Of a machine
/// with head_over_block.
calibrate::HeadState KnownHeadOf(const FrozenJob& job);

/// Shape of the field, distances of the pupil, scale of z, and the corner of the block
/// where they differ by more than their uncertainty. Tilt of the block, lean of z and the
/// index are remarks, for no profile corrects them; so is what was not determined.
CorrectedProfile CorrectHead(const FrozenJob& job, const calibrate::CubeFit& fit);

}  // namespace intaglio::client
