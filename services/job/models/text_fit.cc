#include "services/job/models/text_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/drawing/flatten.h"
#include "engrave/mesh/placement.h"
#include "services/job/fields/channels.h"
#include "services/job/fields/shapes.h"
#include "services/job/models/model_sources.h"

// A text is scaled about the origin of its drawing. Its placement is affine in the
// points, and where it regards their extent (centre, pivot), linear in it: so each bound
// of the placed text is a + b s in the scale s, known from its values at 1 and 1/2.

namespace intaglio {
namespace {

// Coordinates are known to 1e-9 mm; what is engraved, to micrometres.
constexpr double kToleranceMm = 1e-6;

/// The text at one scale.
struct Placed {
  Box3 box_mm;  ///< glass frame
  double width_mm = 0, height_mm = 0;
};

Result<Placed> Place(const PointList& points_mm, double scale,
                     const mesh::Placement& placement, const Vec3& block_mm) {
  PointList scaled;
  scaled.reserve(points_mm.size());
  Box3 flat;
  for (const Vec3& p : points_mm) {
    scaled.push_back(scale * p);
    flat.Extend(scaled.back());
  }
  const auto glass = INTAGLIO_TRY(mesh::GlassFromModelOf(scaled, placement, block_mm));
  Placed placed;
  for (const Vec3& p : scaled) placed.box_mm.Extend(glass.Apply(p));
  placed.width_mm = flat.size_mm().x() * glass.linear.col(0).norm();
  placed.height_mm = flat.size_mm().y() * glass.linear.col(1).norm();
  return placed;
}

/// Narrows the fit by one bound: its values at the scales 1 and 1/2 may not be above.
class Fitting {
 public:
  /// Whether it is above at scale 1.
  bool Limit(double whole_mm, double half_mm, double max_mm) {
    if (whole_mm <= max_mm + kToleranceMm) return false;
    const double slope = 2 * (whole_mm - half_mm);
    const double at_zero = whole_mm - slope;
    const double scale = slope > 0 ? (max_mm - at_zero) / slope : 0;
    fit_.scale_ratio = std::min(fit_.scale_ratio, std::max(0.0, scale));
    return true;
  }
  void Explain(std::string obstacle) {
    if (fit_.obstacle.empty()) fit_.obstacle = std::move(obstacle);
  }
  TextFit& fit() { return fit_; }

 private:
  TextFit fit_;
};

void FitBox(const Box3& whole, const Box3& half, const Box3& permitted,
            const Vec3& offset_mm, Fitting& fitting) {
  for (int axis = 0; axis < 3; ++axis) {
    const double offset = offset_mm[axis];
    const bool above = fitting.Limit(whole.max_mm[axis] + offset,
                                     half.max_mm[axis] + offset, permitted.max_mm[axis]);
    const bool below =
        fitting.Limit(-whole.min_mm[axis] - offset, -half.min_mm[axis] - offset,
                      -permitted.min_mm[axis]);
    if (!above && !below) continue;
    fitting.Explain(fmt::format(
        "reaches from {} = {:.2f} to {:.2f} mm, and the block leaves {:g} to {:g} mm "
        "between its margins",
        "xyz"[axis], whole.min_mm[axis] + offset, whole.max_mm[axis] + offset,
        permitted.min_mm[axis], permitted.max_mm[axis]));
  }
}

void FitSides(const Placed& whole, const Placed& half, const Text& text,
              Fitting& fitting) {
  if (text.has_max_width_mm() &&
      fitting.Limit(whole.width_mm, half.width_mm, text.max_width_mm())) {
    fitting.Explain(fmt::format("is {:.2f} mm wide, more than max_width_mm, {:g}",
                                whole.width_mm, text.max_width_mm()));
  }
  if (text.has_max_height_mm() &&
      fitting.Limit(whole.height_mm, half.height_mm, text.max_height_mm())) {
    fitting.Explain(fmt::format("is {:.2f} mm high, more than max_height_mm, {:g}",
                                whole.height_mm, text.max_height_mm()));
  }
}

}  // namespace

Result<TextFit> FitText(const JobSpec& job, const Model& model,
                        const drawing::Drawing& outline, int copy) {
  const auto flat = INTAGLIO_TRY(drawing::Flatten(outline));
  PointList points_mm;
  for (const drawing::FlatCurve& curve : flat.curves) {
    points_mm.insert(points_mm.end(), curve.points_mm.begin(), curve.points_mm.end());
  }
  if (points_mm.empty()) return TextFit{};
  const Block block = BlockOf(job, model);
  const mesh::Placement placement = PlacementOf(model.placement(), block);
  const Vec3 block_mm = Vec3Of(block.size_mm());
  const auto whole = INTAGLIO_TRY(Place(points_mm, 1, placement, block_mm));
  const auto half = INTAGLIO_TRY(Place(points_mm, 0.5, placement, block_mm));
  Fitting fitting;
  FitSides(whole, half, model.text(), fitting);
  if (job.block().clip()) return fitting.fit();
  const Box3 permitted = PermittedBoxOf(block);
  const PointList offsets_mm = CopyOffsetsOf(model, job.block());
  for (std::size_t i = 0; i < offsets_mm.size(); ++i) {
    if (copy >= 0 && i != static_cast<std::size_t>(copy)) continue;
    FitBox(whole.box_mm, half.box_mm, permitted, offsets_mm[i], fitting);
  }
  return fitting.fit();
}

}  // namespace intaglio
