#pragma once

// What a person has mounted in the machine of a shop: block, glass, lens. The cell fires
// no job for anything else.

#include <filesystem>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/client/mounted_description.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// As it was typed.
struct MountFlags {
  std::vector<double> block_mm;
  std::string glass;
  double refractive_index = 0;  ///< 0: not given
  std::string lens;
};

/// --block, --block-glass, --index and --lens.
void AddMountFlags(command_line::Command command, MountFlags& flags);

struct Mounted {
  client::MountedDescription description;
  std::string glass;  ///< name; empty: known by its index, or not at all
  std::string lens;   ///< name; empty: not known
};

/// Of a virtual machine everything is known, by default 100 x 100 x 100 mm of N-BK7 and
/// the profile's first lens; of a real one what was given. kNotFound: no such lens in the
/// profile, or no such glass in the material base; the error of ComputeOptics when the
/// glass has no index at the laser's wavelength.
Result<Mounted> MountedOf(const MountFlags& flags, bool is_virtual,
                          const MachineSpec& machine,
                          const std::filesystem::path& materials_db);

/// For people, e.g. "block in the machine: 100 x 100 x 100 mm (--block), N-BK7 of index
/// 1.51947 (--block-glass); lens f43: f 43 mm, NA 0.2 (--lens)".
std::string TextOf(const Mounted& mounted);

}  // namespace intaglio::cli
