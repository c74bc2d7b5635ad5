#include "services/cli/teach/mounted.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engrave/core/try.h"
#include "materials_db/material_store.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/machine/focus_offset.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVirtualGlass = "N-BK7";
// That of the supplied sample, so that it can be engraved in a new shop as it is.
const Vec3 kVirtualBlockMm(50, 50, 30);

/// kNotFound: there is no such lens.
Status MountLens(const std::string& name, const MachineSpec& machine,
                 MountedParts& mounted) {
  const MachineLens* lens = FindLensNamed(machine, name);
  if (lens == nullptr) {
    std::vector<std::string> names;
    for (const MachineLens& other : machine.lenses()) names.push_back(other.name());
    return Fail(ErrorCode::kNotFound,
                fmt::format("--lens: \"{}\" is not a lens of {}; it has {}", name,
                            machine.name(), fmt::join(names, ", ")),
                name);
  }
  mounted.lens_name = name;
  mounted.lens = optics::Lens{lens->focal_length_mm(), lens->numerical_aperture()};
  return {};
}

/// kNotFound: the material base has no such glass; kInvalidValue: it has no index at the
/// laser's wavelength.
Status MountGlass(const std::string& name, const MachineSpec& machine,
                  const fs::path& materials_db, MountedParts& mounted) {
  const auto store = INTAGLIO_TRY(materials_db::MaterialStore::Open(materials_db));
  const auto found = store.Find(name);
  if (!found) {
    return Fail(found.error().code, "glass: " + found.error().message, name);
  }
  const materials_db::Material& material = *found;
  const auto values = INTAGLIO_TRY(materials_db::ComputeOptics(
      material, machine.laser().wavelength_nm(), machine.lenses(0).numerical_aperture()));
  mounted.glass = material.name;
  mounted.refractive_index = values.refractive_index;
  return {};
}

/// A machine that marks, mills or cuts has neither a block of glass nor a lens over it.
Status CheckPieceAlone(const MountFlags& flags, const MachineSpec& machine) {
  const char* given = !flags.block_mm.empty()      ? "--block"
                      : !flags.lens.empty()        ? "--lens"
                      : !flags.glass.empty()       ? "the glass"
                      : flags.refractive_index > 0 ? "--index"
                                                   : nullptr;
  if (given == nullptr) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{} is not mounted in {}, which marks, mills or cuts a piece: "
                          "name the piece with --piece",
                          given, machine.name()));
}

void AddFlagsWith(command_line::Command command, const char* glass_option,
                  const char* default_text, MountFlags& flags) {
  command
      .AddOption("--block", flags.block_mm,
                 fmt::format("block in the machine, mm; no job is armed for another "
                             "one{}",
                             *default_text == 0 ? ""
                                                : "; default of a virtual machine "
                                                  "50 50 30"))
      .TakeValues(3)
      .Positive();
  const auto glass = command.AddOption(
      glass_option, flags.glass,
      fmt::format("its glass, by its name in the material base; no job is armed for a "
                  "glass of another refractive index{}",
                  *default_text == 0 ? "" : "; default of a virtual machine N-BK7"));
  command
      .AddOption("--index", flags.refractive_index,
                 "refractive index of its glass at the laser's wavelength, for a glass "
                 "without a name")
      .Within(1.0, 4.0)
      .Exclude(glass);
  command
      .AddOption("--wavelength", flags.wavelength_nm,
                 "the wavelength, nm, that a person has set the laser to, one of a "
                 "profile with several: the index of the glass is the one at it; default "
                 "the profile's laser.wavelength_nm")
      .Within(200.0, 2000.0);
  command.AddOption(
      "--lens", flags.lens,
      fmt::format("name of the mounted lens in the profile; no job is armed for another "
                  "one{}",
                  default_text));
  command.AddOption("--piece", flags.piece,
                    "piece and tool in words, of a machine that marks, mills or cuts: "
                    "\"FR4, 1.6 mm, 0.2 mm V-bit\"");
}

}  // namespace

void AddMountFlags(command_line::Command command, MountFlags& flags) {
  AddFlagsWith(command, "--block-glass",
               "; default the profile's mounted_lens, of a virtual machine also the "
               "profile's first",
               flags);
}

void AddNamedMountFlags(command_line::Command command, MountFlags& flags) {
  AddFlagsWith(command, "--glass", "", flags);
}

Result<MachineSpec> MachineSetTo(const MountFlags& flags, const MachineSpec& machine) {
  if (flags.wavelength_nm == 0) return machine;
  const auto all_nm = WavelengthsOf(machine.laser());
  if (std::ranges::any_of(
          all_nm, [&](double nm) { return IsSameWavelength(nm, flags.wavelength_nm); }))
    return ForWavelength(flags.wavelength_nm, machine);
  return Fail(ErrorCode::kNotFound,
              fmt::format("--wavelength: {} is none of the wavelengths of {}: {}",
                          flags.wavelength_nm, machine.name(), fmt::join(all_nm, " ")),
              fmt::format("{}", flags.wavelength_nm));
}

Result<MountedParts> NamedParts(const MountFlags& flags, const MachineSpec& given,
                                const fs::path& materials_db) {
  const MachineSpec machine = INTAGLIO_TRY(MachineSetTo(flags, given));
  if (flags.wavelength_nm > 0 && flags.glass.empty()) {
    return Fail(ErrorCode::kInvalidValue,
                "--wavelength: the index of the glass follows from it; name the glass, "
                "too",
                fmt::format("{}", flags.wavelength_nm));
  }
  if (machine.has_mark_line()) INTAGLIO_TRY(CheckPieceAlone(flags, machine));
  MountedParts mounted;
  mounted.piece = flags.piece;
  if (!flags.block_mm.empty())
    mounted.block_mm = Eigen::Map<const Vec3>(flags.block_mm.data());
  if (!flags.lens.empty()) {
    if (auto lens = MountLens(flags.lens, machine, mounted); !lens)
      return tl::unexpected(lens.error());
  }
  if (flags.refractive_index > 0) {
    mounted.refractive_index = flags.refractive_index;
  } else if (!flags.glass.empty()) {
    if (auto glass = MountGlass(flags.glass, machine, materials_db, mounted); !glass)
      return tl::unexpected(glass.error());
  }
  return mounted;
}

Result<MountedParts> MountedOf(const MountFlags& given, bool is_virtual,
                               const MachineSpec& machine, const fs::path& materials_db) {
  MountFlags flags = given;
  if (machine.has_mark_line()) {
    INTAGLIO_TRY(CheckPieceAlone(flags, machine));
    if (flags.piece.empty() && is_virtual) flags.piece = "virtual piece";
    return MountedParts{.piece = flags.piece};
  }
  if (flags.block_mm.empty() && is_virtual) {
    flags.block_mm = {kVirtualBlockMm.x(), kVirtualBlockMm.y(), kVirtualBlockMm.z()};
  }
  const bool has_lens = is_virtual || !machine.mounted_lens().empty();
  if (flags.lens.empty() && has_lens) flags.lens = MountedLensOf(machine)->name();
  const bool has_glass = !flags.glass.empty() || flags.refractive_index > 0;
  if (!has_glass && is_virtual) flags.glass = kVirtualGlass;
  return NamedParts(flags, machine, materials_db);
}

std::string MountedText(const MountedParts& known, const MachineSpec& machine) {
  if (!known.piece.empty()) return "piece in the machine: " + known.piece;
  if (machine.has_mark_line()) return "piece in the machine: it is not known (--piece)";
  std::string text = "block in the machine: ";
  if (known.block_mm) {
    const Vec3& mm = *known.block_mm;
    text += fmt::format("{:g} x {:g} x {:g} mm (--block)", mm.x(), mm.y(), mm.z());
  } else {
    text += "its size is not known (--block)";
  }
  if (known.refractive_index) {
    text +=
        fmt::format(", {} of index {:.6g} (--block-glass)",
                    known.glass.empty() ? "glass" : known.glass, *known.refractive_index);
  } else {
    text += ", its glass is not known (--block-glass)";
  }
  if (known.lens) {
    text += fmt::format("; lens {}: f {:g} mm, NA {:.3g} (--lens)", known.lens_name,
                        known.lens->focal_length_mm, known.lens->numerical_aperture);
  } else if (machine.lenses_size() == 1) {
    text += "; lens " + machine.lenses(0).name();  // it has no other
  } else {
    text += "; its lens is not known (--lens)";
  }
  return text;
}

}  // namespace intaglio::cli
