#include "services/cli/mounted.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "engrave/core/try.h"
#include "materials_db/material_store.h"
#include "services/job/machine/focus_offset.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVirtualGlass = "N-BK7";
const Vec3 kVirtualBlockMm = Vec3::Constant(100);

/// kNotFound: there is no such lens.
Status MountLens(const std::string& name, const MachineSpec& machine, Mounted& mounted) {
  const MachineLens* lens = FindLensNamed(machine, name);
  if (lens == nullptr) {
    std::vector<std::string> names;
    for (const MachineLens& other : machine.lenses()) names.push_back(other.name());
    return Fail(ErrorCode::kNotFound,
                fmt::format("--lens: \"{}\" is not a lens of {}; it has {}", name,
                            machine.name(), fmt::join(names, ", ")),
                name);
  }
  mounted.lens = name;
  mounted.description.lens =
      optics::Lens{lens->focal_length_mm(), lens->numerical_aperture()};
  return {};
}

/// kNotFound: the material base has no such glass; kInvalidValue: it has no index at the
/// laser's wavelength.
Status MountGlass(const std::string& name, const MachineSpec& machine,
                  const fs::path& materials_db, Mounted& mounted) {
  const auto store = INTAGLIO_TRY(materials_db::MaterialStore::Open(materials_db));
  const auto found = store.Find(name);
  if (!found) {
    return Fail(found.error().code, "--block-glass: " + found.error().message, name);
  }
  const materials_db::Material& material = *found;
  const auto values = INTAGLIO_TRY(materials_db::ComputeOptics(
      material, machine.laser().wavelength_nm(), machine.lenses(0).numerical_aperture()));
  mounted.glass = material.name;
  mounted.description.refractive_index = values.refractive_index;
  return {};
}

}  // namespace

void AddMountFlags(command_line::Command command, MountFlags& flags) {
  command
      .AddOption("--block", flags.block_mm,
                 "block in the machine, mm; a job for another one is not fired; default "
                 "of a virtual machine 100 100 100")
      .TakeValues(3)
      .Positive();
  const auto glass = command.AddOption(
      "--block-glass", flags.glass,
      "its glass, by its name in the material base; a job for a glass of another "
      "refractive index is not fired; default of a virtual machine N-BK7");
  command
      .AddOption("--index", flags.refractive_index,
                 "refractive index of its glass at the laser's wavelength, for a glass "
                 "without a name")
      .Within(1.0, 4.0)
      .Exclude(glass);
  command.AddOption("--lens", flags.lens,
                    "name of the mounted lens in the profile; a job for another one is "
                    "not fired; default the profile's mounted_lens, of a virtual "
                    "machine also the profile's first");
}

Result<Mounted> MountedOf(const MountFlags& flags, bool is_virtual,
                          const MachineSpec& machine, const fs::path& materials_db) {
  Mounted mounted;
  if (machine.has_mark_line()) return mounted;
  if (!flags.block_mm.empty()) {
    mounted.description.block_size_mm = Eigen::Map<const Vec3>(flags.block_mm.data());
  } else if (is_virtual) {
    mounted.description.block_size_mm = kVirtualBlockMm;
  }
  if (!flags.lens.empty() || is_virtual || !machine.mounted_lens().empty()) {
    const std::string name =
        flags.lens.empty() ? MountedLensOf(machine)->name() : flags.lens;
    if (auto lens = MountLens(name, machine, mounted); !lens)
      return tl::unexpected(lens.error());
  }
  if (flags.refractive_index > 0) {
    mounted.description.refractive_index = flags.refractive_index;
  } else if (!flags.glass.empty() || is_virtual) {
    const std::string name = flags.glass.empty() ? kVirtualGlass : flags.glass;
    if (auto glass = MountGlass(name, machine, materials_db, mounted); !glass)
      return tl::unexpected(glass.error());
  }
  return mounted;
}

std::string TextOf(const Mounted& mounted) {
  const client::MountedDescription& known = mounted.description;
  std::string text = "block in the machine: ";
  if (known.block_size_mm) {
    const Vec3& mm = *known.block_size_mm;
    text += fmt::format("{:g} x {:g} x {:g} mm (--block)", mm.x(), mm.y(), mm.z());
  } else {
    text += "its size is not known (--block)";
  }
  if (known.refractive_index) {
    text += fmt::format(", {} of index {:.6g} (--block-glass)",
                        mounted.glass.empty() ? "glass" : mounted.glass,
                        *known.refractive_index);
  } else {
    text += ", its glass is not known (--block-glass)";
  }
  if (known.lens) {
    text += fmt::format("; lens {}: f {:g} mm, NA {:.3g} (--lens)", mounted.lens,
                        known.lens->focal_length_mm, known.lens->numerical_aperture);
  } else {
    text += "; its lens is not known (--lens)";
  }
  return text;
}

}  // namespace intaglio::cli
