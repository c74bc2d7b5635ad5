#include "services/job/quality/focus_spread.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/optics/focus.h"
#include "services/job/machine/focus_offset.h"

namespace intaglio {

Warnings FocusSpreadOf(const FrozenJob& job, const PointList& points_mm) {
  const MachineLens* lens = FindLens(job.machine(), job.job().lens().focal_length_mm());
  const OpticalValuesRecord& values = job.optics();
  const bool is_known =
      lens != nullptr && lens->crack_length_mm() > 0 && values.refractive_index() >= 1 &&
      values.numerical_aperture() > 0 && values.numerical_aperture() < 1;
  if (points_mm.empty() || !is_known) return {};
  const auto lowest =
      std::ranges::min_element(points_mm, {}, [](const Vec3& p) { return p.z(); });
  const double depth_mm = job.job().block().size_mm().z() - lowest->z();
  if (depth_mm <= 0) return {};
  const double spread_per_mm =
      optics::FocusSpreadMm(values.refractive_index(), values.numerical_aperture(), 1);
  const double spread_mm = spread_per_mm * depth_mm;
  if (spread_mm <= lens->crack_length_mm()) return {};
  return {MakeWarning(
      WarningCode::kFocusSpread,
      fmt::format(
          "the focus of lens {} is spread over {:.2f} mm at the deepest point, "
          "{:.1f} mm below the top; a crack is {:.3f} mm long, which holds down "
          "to {:.1f} mm: expect longer or fainter points below, or take a lens of "
          "a smaller numerical aperture",
          lens->name(), spread_mm, depth_mm, lens->crack_length_mm(),
          lens->crack_length_mm() / spread_per_mm))};
}

}  // namespace intaglio
