// The stage goes D k(n) deep for a focus at the depth D, k = StagePerGlassRatio. In glass
// of index m the focus is then at D k(n) / k(m), so at the bottom of a block of height H
// it is off by H |k(n) / k(m) - 1|, about H |m - n| / n. With a crack of 0.135 mm (f 43
// mm) a quarter is 34 um: 100 mm of N-BK7 whose melts differ by 0.0005 (33 um) pass, and
// so do 5 mm of soda-lime glass in the place of N-BK7, but not 20 mm of it.

#include "services/job/machine/mounted_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "services/job/fields/job_kind.h"
#include "services/job/fields/shapes.h"
#include "services/job/machine/block_fit.h"
#include "services/job/machine/focus_offset.h"

namespace intaglio {
namespace {

constexpr double kSameLens = 1e-6;
constexpr double kCrackShare = 0.25;

optics::Lens OpticsOf(const MachineLens& lens) {
  return {lens.focal_length_mm(), lens.numerical_aperture()};
}

/// "FOCAL_LENGTH,NA"; nullopt when it is not of that form.
std::optional<optics::Lens> ParseLens(const std::string& text) {
  optics::Lens lens;
  const char* end = text.data() + text.size();
  const auto focal = std::from_chars(text.data(), end, lens.focal_length_mm);
  if (focal.ec != std::errc() || focal.ptr == end || *focal.ptr != ',')
    return std::nullopt;
  const auto aperture = std::from_chars(focal.ptr + 1, end, lens.numerical_aperture);
  if (aperture.ec != std::errc() || aperture.ptr != end) return std::nullopt;
  const bool possible = lens.numerical_aperture > 0 && lens.numerical_aperture < 1;
  return possible ? std::optional(lens) : std::nullopt;
}

bool AreSame(const optics::Lens& one, const optics::Lens& other) {
  return std::abs(one.focal_length_mm - other.focal_length_mm) <= kSameLens &&
         std::abs(one.numerical_aperture - other.numerical_aperture) <= kSameLens;
}

/// Empty for a lens that the profile does not have.
std::string NameOf(const optics::Lens& lens, const MachineSpec& machine) {
  for (const MachineLens& known : machine.lenses()) {
    if (AreSame(lens, OpticsOf(known))) return known.name();
  }
  return "";
}

std::string LensMisfit(const FrozenJob& job, const optics::Lens& mounted) {
  const optics::Lens wanted = LensOf(job.job());
  if (AreSame(wanted, mounted)) return "";
  const auto text = [&job](const optics::Lens& lens) {
    return fmt::format("the lens {} (f {:g} mm, NA {:.3g})", NameOf(lens, job.machine()),
                       lens.focal_length_mm, lens.numerical_aperture);
  };
  const std::string name = NameOf(wanted, job.machine());
  return fmt::format(
      "the job is for {}, but {} is mounted: no pulse is fired; {}", text(wanted),
      text(mounted),
      name.empty() ? "this machine does not have the job's lens: cancel the job and "
                     "submit it again with the mounted lens"
                   : fmt::format("mount it and report it: `{} --lens {}`",
                                 MountCommand(job.machine().name()), name));
}

/// Empty where the laser has one wavelength.
std::string WavelengthTextOf(const FrozenJob& job, const char* before,
                             const char* after = " nm") {
  if (job.machine().laser().further_wavelengths().empty()) return "";
  return fmt::format("{}{:g}{}", before, job.machine().laser().wavelength_nm(), after);
}

std::string GlassMisfit(const FrozenJob& job, double mounted_index) {
  const MachineLens* lens = FindLens(job.machine(), job.job().lens().focal_length_mm());
  const double allowed_mm = kCrackShare * (lens == nullptr ? 0 : lens->crack_length_mm());
  const double error_mm = DepthErrorMm(job, mounted_index);
  if (error_mm <= allowed_mm) return "";
  return fmt::format(
      "the job is for {} (refractive index {:.6g}{}), the block in the machine has the "
      "index {:.6g}: the deepest points would be off by {:.3f} mm, {:.3f} mm are "
      "allowed: no pulse is fired; insert a block of the job's glass{} and report it: "
      "`{} --glass {}{}`",
      job.job().glass(), job.optics().refractive_index(), WavelengthTextOf(job, " at "),
      mounted_index, error_mm, allowed_mm, WavelengthTextOf(job, ", set the laser to "),
      MountCommand(job.machine().name()), job.job().glass(),
      WavelengthTextOf(job, " --wavelength ", ""));
}

}  // namespace

Result<std::optional<optics::Lens>> MountedLens(const std::string& text,
                                                const MachineSpec& machine) {
  if (text.empty()) {
    if (const auto* own = FindLensNamed(machine, machine.mounted_lens())) {
      return OpticsOf(*own);
    }
    if (machine.lenses_size() != 1) return std::nullopt;
    return OpticsOf(machine.lenses(0));
  }
  std::vector<std::string> names;
  for (const MachineLens& lens : machine.lenses()) {
    if (lens.name() == text) return OpticsOf(lens);
    names.push_back(lens.name());
  }
  const auto numbers = ParseLens(text);
  if (numbers && FindLens(machine, numbers->focal_length_mm) != nullptr) return numbers;
  return Fail(ErrorCode::kNotFound,
              fmt::format("lens \"{}\" is not a lens of {}, which has {}; give one of "
                          "these, or focal length (mm) and numerical aperture: 43,0.2",
                          text, machine.name(), fmt::join(names, ", ")),
              text);
}

double DepthErrorMm(const FrozenJob& job, double mounted_index) {
  const double aperture = job.job().lens().numerical_aperture();
  const double wanted =
      optics::StagePerGlassRatio(job.optics().refractive_index(), aperture);
  const double found = optics::StagePerGlassRatio(mounted_index, aperture);
  return job.job().block().size_mm().z() * std::abs(wanted / found - 1);
}

std::string MountMisfit(const FrozenJob& job, const MountedParts& mounted) {
  std::vector<std::string> misfits;
  const auto add = [&misfits](std::string text) {
    if (!text.empty()) misfits.push_back(std::move(text));
  };
  if (mounted.block_mm) {
    add(BlockMisfit(BlockSizeOf(job.job()), *mounted.block_mm, job.machine().name()));
  }
  if (mounted.lens) add(LensMisfit(job, *mounted.lens));
  if (mounted.refractive_index) add(GlassMisfit(job, *mounted.refractive_index));
  return fmt::format("{}", fmt::join(misfits, "; and "));
}

bool MountedParts::operator==(const MountedParts& other) const {
  const auto numbers = [](const std::optional<optics::Lens>& of) {
    return of ? std::pair(of->focal_length_mm, of->numerical_aperture)
              : std::pair(0.0, 0.0);
  };
  return block_mm == other.block_mm && refractive_index == other.refractive_index &&
         numbers(lens) == numbers(other.lens) && glass == other.glass &&
         lens_name == other.lens_name && piece == other.piece;
}

std::string TextOf(const MountedParts& mounted) {
  std::string block;
  if (mounted.block_mm) {
    block = fmt::format("{:g} x {:g} x {:g}", mounted.block_mm->x(),
                        mounted.block_mm->y(), mounted.block_mm->z());
  }
  std::string glass = mounted.glass;
  if (glass.empty() && mounted.refractive_index)
    glass = fmt::format("glass of index {:.6g}", *mounted.refractive_index);
  if (!block.empty() && !glass.empty()) block += " ";
  block += glass;
  std::string lens = mounted.lens_name;
  if (lens.empty() && mounted.lens)
    lens = fmt::format("lens of f {:g} mm", mounted.lens->focal_length_mm);
  std::vector<std::string> texts;
  for (const std::string& text : {block, lens, mounted.piece}) {
    if (!text.empty()) texts.push_back(text);
  }
  return fmt::format("{}", fmt::join(texts, ", "));
}

MountedParts PartsOf(const FrozenJob& job) {
  if (ConcernsMarks(job.job(), job.machine())) return {};
  MountedParts parts;
  parts.block_mm = BlockSizeOf(job.job());
  parts.glass = job.job().glass();
  parts.refractive_index = job.optics().refractive_index();
  parts.lens = LensOf(job.job());
  parts.lens_name = NameOf(*parts.lens, job.machine());
  return parts;
}

std::string MountCommandFor(const FrozenJob& job) {
  const std::string command = MountCommand(job.machine().name());
  if (ConcernsMarks(job.job(), job.machine())) return command + " --piece TEXT";
  const MountedParts parts = PartsOf(job);
  return fmt::format("{} --block {:g} {:g} {:g} --glass {}{}{}", command,
                     parts.block_mm->x(), parts.block_mm->y(), parts.block_mm->z(),
                     parts.glass, WavelengthTextOf(job, " --wavelength ", ""),
                     parts.lens_name.empty() ? "" : " --lens " + parts.lens_name);
}

std::string WantedTextOf(const FrozenJob& job) {
  return TextOf(PartsOf(job)) + WavelengthTextOf(job, ", laser at ");
}

bool IsRealMachine(const MachineSpec& machine) {
  const auto is_real = [](const SerialLine& line) {
    return !line.protocol().empty() && !line.protocol().starts_with("virtual-");
  };
  if (machine.has_mark_line()) return is_real(machine.mark_line());
  return is_real(machine.motion_line());
}

std::vector<std::string> MissingParts(const FrozenJob& job, const MountedParts& mounted) {
  if (ConcernsMarks(job.job(), job.machine())) {
    if (mounted.empty()) return {"piece"};
    return {};
  }
  std::vector<std::string> missing;
  if (!mounted.block_mm) missing.emplace_back("block");
  if (!mounted.refractive_index) missing.emplace_back("glass");
  const auto lens = MountedLens("", job.machine());
  if (!mounted.lens && !(lens && *lens)) missing.emplace_back("lens");
  return missing;
}

}  // namespace intaglio
