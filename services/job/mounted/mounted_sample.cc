#include "services/job/mounted/mounted_sample.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "services/platform/bus/samples.h"

namespace intaglio {
namespace {

constexpr double kMaxBlockMm = 10000, kMaxIndex = 4;

bool IsIn(double value, double min, double max) {
  return std::isfinite(value) && value >= min && value <= max;
}

}  // namespace

intaglio_MountedParts SampleOf(const MountedParts& parts) {
  intaglio_MountedParts sample{};
  if (parts.block_mm) std::copy_n(parts.block_mm->data(), 3, sample.block_mm);
  sample.glass = bus::Borrow(parts.glass);
  sample.refractive_index = parts.refractive_index.value_or(0);
  sample.lens = bus::Borrow(parts.lens_name);
  if (parts.lens) {
    sample.focal_length_mm = parts.lens->focal_length_mm;
    sample.numerical_aperture = parts.lens->numerical_aperture;
  }
  sample.piece = bus::Borrow(parts.piece);
  return sample;
}

Result<MountedParts> PartsOf(const intaglio_MountedParts& sample) {
  MountedParts parts;
  const Vec3 block_mm = Eigen::Map<const Vec3>(sample.block_mm);
  if (block_mm != Vec3::Zero()) {
    for (const double size_mm : block_mm) {
      if (IsIn(size_mm, 1e-3, kMaxBlockMm)) continue;
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("mounted.block_mm: {} is outside 0.001..{}", size_mm, kMaxBlockMm));
    }
    parts.block_mm = block_mm;
  }
  if (sample.refractive_index != 0) {
    if (!IsIn(sample.refractive_index, 1, kMaxIndex)) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("mounted.refractive_index: {} is outside 1..{}",
                              sample.refractive_index, kMaxIndex));
    }
    parts.refractive_index = sample.refractive_index;
  }
  if (sample.focal_length_mm != 0) {
    if (!IsIn(sample.focal_length_mm, 0.1, kMaxBlockMm) ||
        !IsIn(sample.numerical_aperture, 1e-6, 1)) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("mounted lens: f {} mm and NA {} are no lens",
                              sample.focal_length_mm, sample.numerical_aperture));
    }
    parts.lens = optics::Lens{sample.focal_length_mm, sample.numerical_aperture};
  }
  parts.glass = bus::View(sample.glass);
  parts.lens_name = bus::View(sample.lens);
  parts.piece = bus::View(sample.piece);
  return parts;
}

}  // namespace intaglio
