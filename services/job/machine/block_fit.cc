#include "services/job/machine/block_fit.h"

#include <fmt/format.h>

#include <cmath>

namespace intaglio {
namespace {

constexpr double kSameMm = 1e-3;

}  // namespace

std::string MountCommand(const std::string& machine) {
  return "intaglio mount --machine " + machine;
}

std::string BlockMisfit(const Vec3& job_size_mm, const Vec3& in_machine_mm,
                        const std::string& machine) {
  const Vec3 missing_mm = job_size_mm - in_machine_mm;
  if (missing_mm.x() <= kSameMm && missing_mm.y() <= kSameMm &&
      std::abs(missing_mm.z()) <= kSameMm) {
    return "";
  }
  return fmt::format(
      "the job is for a block of {0:g} x {1:g} x {2:g} mm, the one in the machine has "
      "{3:g} x {4:g} x {5:g} mm: no pulse is fired; insert one of the job's and report "
      "it: `{6} --block {0:g} {1:g} {2:g}`",
      job_size_mm.x(), job_size_mm.y(), job_size_mm.z(), in_machine_mm.x(),
      in_machine_mm.y(), in_machine_mm.z(), MountCommand(machine));
}

}  // namespace intaglio
