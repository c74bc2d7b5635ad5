#pragma once

// What is known to be mounted in the machine: block, its glass, and lens; of a machine
// that makes marks the piece and the tool, in words. A job for another block, glass or
// lens is not fired: its points would come at other depths, or beside the glass. What is
// not known is not compared; which parts a person has to name before a job is armed,
// MissingParts says.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/optics/focus.h"
#include "proto/task.pb.h"

namespace intaglio {

struct MountedParts {
  std::optional<Vec3> block_mm = {};
  std::optional<double> refractive_index =
      {};  ///< of the block, at the laser's wavelength
  std::optional<optics::Lens> lens = {};
  std::string glass = {};      ///< its name; empty: known by its index, or not at all
  std::string lens_name = {};  ///< in the profile; empty: known by its numbers, or not
  std::string piece = {};      ///< in words, of what is no block

  bool operator==(const MountedParts&) const;
  bool empty() const { return *this == MountedParts(); }
};

/// For people: "60 x 30 x 20 N-BK7, f70"; what is not known is left out.
std::string TextOf(const MountedParts& mounted);

/// What the job is for: its own block, glass and lens; of a job of marks nothing.
MountedParts PartsOf(const FrozenJob& job);

/// For people: TextOf its parts, and of a laser with several wavelengths which of them it
/// has to be set to.
std::string WantedTextOf(const FrozenJob& job);

/// "intaglio mount --machine els-03 --block 60 30 20 --glass N-BK7 --lens f70": what a
/// person types when the job's own parts are mounted.
std::string MountCommandFor(const FrozenJob& job);

/// What a person puts into the machine for a job: "block", or "piece" where it makes
/// marks or contours. `makes`: what its counts count, "points" or "marks".
constexpr const char* WorkpieceOf(std::string_view makes) {
  return makes == "points" ? "block" : "piece";
}

/// The machine has real controllers, as far as its profile says.
bool IsRealMachine(const MachineSpec& machine);

/// Which of "block", "glass" and "lens" the job needs and nobody has named; the lens is
/// known where the profile has just one, or names the mounted one.
std::vector<std::string> MissingParts(const FrozenJob& job, const MountedParts& mounted);

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

}  // namespace intaglio
