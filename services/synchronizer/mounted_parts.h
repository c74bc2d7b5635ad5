#pragma once

// What is known to be mounted in the machine: block, its glass, and lens. A job for other
// ones is not fired: its points would come at other depths, or beside the glass. What is
// not known is the responsibility of the person who arms the job.

#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/optics/focus.h"
#include "proto/task.pb.h"

namespace intaglio::synchronizer {

struct MountedParts {
  std::optional<Vec3> block_mm = {};
  std::optional<double> refractive_index =
      {};  ///< of the block, at the laser's wavelength
  std::optional<optics::Lens> lens = {};
};

/// `text`: the name of one of the machine's lenses, or "FOCAL_LENGTH,NA" (mm, -), of
/// which the focal length is one of the machine's. Empty: the machine's lens when it has
/// just one, else nullopt. kNotFound names the machine's lenses.
Result<std::optional<optics::Lens>> MountedLens(const std::string& text,
                                                const MachineSpec& machine);

/// How far below or above its place the deepest focus of the job comes to lie in a block
/// of `mounted_index` instead of the job's own glass, >= 0, mm. Precondition: a task that
/// CheckTask lets pass; index >= 1.
double DepthErrorMm(const FrozenJob& job, double mounted_index);

/// What differs and the remedy, for block, glass and lens; empty when the job may be
/// fired into what is mounted. Block: BlockMisfit. Lens: focal length and numerical
/// aperture are the same, within 1e-6. Glass: DepthErrorMm is at most a quarter of the
/// length of a crack. The depths of all points are wrong by the same share, so nothing is
/// seen of that; and it is as much as block heights and taught zeros differ.
/// Precondition: a task that CheckTask lets pass.
std::string MountMisfit(const FrozenJob& job, const MountedParts& mounted);

}  // namespace intaglio::synchronizer
