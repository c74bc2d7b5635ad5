#include "services/console/teach/machine_teaching.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "engrave/core/try.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/teach/profile_history.h"

namespace intaglio::console {
namespace {

void AddZeros(const MachineSpec& profile, MachineTeaching& teaching) {
  for (const MachineLens& lens : profile.lenses()) {
    for (std::uint32_t channel = 1; channel <= profile.laser().channels(); ++channel) {
      const Vec3 origin_mm = BlockOriginOf(profile, channel, lens.name());
      TeachZero& zero = *teaching.add_zeros();
      zero.set_channel(channel);
      zero.set_lens(lens.name());
      zero.set_x_mm(origin_mm.x());
      zero.set_y_mm(origin_mm.y());
      zero.set_z_mm(origin_mm.z());
      zero.set_taught(FindZero(profile, channel, lens.name()) != nullptr);
    }
  }
}

}  // namespace

Result<MachineTeaching> TeachingOf(const client::MachineView& machine) {
  MachineTeaching teaching;
  teaching.set_cell(machine.cell);
  teaching.set_profile(machine.profile);
  if (machine.profile.empty()) return teaching;
  std::error_code error;
  if (!std::filesystem::exists(machine.profile, error)) {
    return Fail(
        ErrorCode::kNotFound,
        fmt::format("{}: the profile of {} is on another computer: teach it there "
                    "(intaglio teach)",
                    machine.profile, machine.cell),
        machine.profile);
  }
  const MachineSpec profile = INTAGLIO_TRY(ReadMachineFile(machine.profile));
  teaching.set_machine(profile.name());
  teaching.set_channels(profile.laser().channels());
  for (const MachineLens& lens : profile.lenses()) {
    TeachLens& shown = *teaching.add_lenses();
    shown.set_name(lens.name());
    shown.set_focal_length_mm(lens.focal_length_mm());
  }
  if (const MachineLens* mounted = MountedLensOf(profile))
    teaching.set_mounted_lens(mounted->name());
  AddZeros(profile, teaching);
  teaching.set_taught_number(profile.taught().number());
  const auto versions = INTAGLIO_TRY(TaughtHistory(machine.profile));
  if (versions.empty()) return teaching;
  teaching.set_taught_change(versions.back().change());
  teaching.set_taught_by(versions.back().taught_by());
  teaching.set_taught_utc(versions.back().time_utc());
  return teaching;
}

}  // namespace intaglio::console
