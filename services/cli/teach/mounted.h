#pragma once

// What a person has mounted in the machine of a shop: block, glass, lens. The cell fires
// no job for anything else.

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/job/machine/mounted_parts.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// As it was typed.
struct MountFlags {
  std::vector<double> block_mm;
  std::string glass;
  double refractive_index = 0;  ///< 0: not given
  std::string lens;
  std::string piece;
  double wavelength_nm = 0;  ///< to which the laser is set; 0: not given
};

/// --block, --block-glass, --index, --wavelength, --lens and --piece, of a shop that is
/// opened.
void AddMountFlags(command_line::Command command, MountFlags& flags);
/// The same with --glass, of a person at the machine.
void AddNamedMountFlags(command_line::Command command, MountFlags& flags);

/// The machine with its laser at --wavelength. kNotFound: it has no such wavelength.
Result<MachineSpec> MachineSetTo(const MountFlags& flags, const MachineSpec& machine);

/// Only what was named; errors as MountedOf.
Result<MountedParts> NamedParts(const MountFlags& flags, const MachineSpec& machine,
                                const std::filesystem::path& materials_db);

/// Everything is known of a virtual machine, by default 50 x 50 x 30 mm of N-BK7 and
/// the profile's first lens; of a real one what was given, and the profile's
/// mounted_lens. A machine that makes marks has a piece, in words. kNotFound: no such
/// lens in the profile, or no such glass in the material base; the error of ComputeOptics
/// when the glass has no index at the laser's wavelength.
Result<MountedParts> MountedOf(const MountFlags& flags, bool is_virtual,
                               const MachineSpec& machine,
                               const std::filesystem::path& materials_db);

/// For people, e.g. "block in the machine: 50 x 50 x 30 mm (--block), N-BK7 of index
/// 1.51947 (--block-glass); lens f43: f 43 mm, NA 0.2 (--lens)".
std::string MountedText(const MountedParts& mounted, const MachineSpec& machine);

}  // namespace intaglio::cli
