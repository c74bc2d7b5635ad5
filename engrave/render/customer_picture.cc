#include "engrave/render/customer_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/render/block_drawing.h"
#include "engrave/render/cloud_image.h"
#include "engrave/render/png_file.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

// Work that takes less of its block is shown larger, and the edges of the block may lie
// outside the picture.
constexpr double kMinWorkRatio = 0.35;
constexpr double kMarginRatio = 0.05;  // of the longer side
constexpr double kNameRatio = 0.075;   // room for the name, of the longer side
constexpr double kMinAspect = 0.5;     // of the shorter side to the longer one

/// How the work is seen, with the shown part of the block in `into`.
Projection ProjectionFor(const Box3& shown_mm, std::optional<int> flat_axis,
                         const Rect& into) {
  if (!flat_axis) return GlassPerspective(shown_mm, into);
  const OrthographicView& view = *flat_axis == 0   ? kFromRight
                                 : *flat_axis == 1 ? kFromFront
                                                   : kFromAbove;
  const Vec3 size_mm = shown_mm.size_mm();
  const double px_per_mm = std::min(into.width / size_mm[view.right_axis],
                                    into.height / size_mm[view.up_axis]);
  return Projection::Parallel(
      Vec3::Unit(view.right_axis), Vec3::Unit(view.up_axis), shown_mm.center_mm(),
      Vec2(into.x + 0.5 * into.width, into.y + 0.5 * into.height), px_per_mm);
}

/// Width by height of the shown part, as it appears.
double AspectOf(const Box3& shown_mm, std::optional<int> flat_axis) {
  const Projection projection = ProjectionFor(shown_mm, flat_axis, {0, 0, 1000, 1000});
  Vec2 low = Vec2::Constant(1e300);
  Vec2 high = -low;
  for (const Vec3& corner : CornersOf(shown_mm)) {
    const Vec2 at_px = projection(corner).at_px;
    low = low.cwiseMin(at_px);
    high = high.cwiseMax(at_px);
  }
  const Vec2 span = high - low;
  return std::clamp(span.x() / span.y(), kMinAspect, 1.0 / kMinAspect);
}

void DrawDarkGround(Canvas& canvas) {
  // Dark blue, a little lighter behind the block.
  const Color middle = Srgb(0x101B2C);
  const Color rim = Srgb(0x05080E);
  for (int y = 0; y < canvas.height(); ++y) {
    for (int x = 0; x < canvas.width(); ++x) {
      const double dx = 2.0 * (x + 0.5) / canvas.width() - 1.0;
      const double dy = 2.0 * (y + 0.5) / canvas.height() - 1.0;
      const double away = std::min(1.0, (dx * dx + dy * dy) / 1.6);
      canvas.at(x, y) = Mix(middle, rim, static_cast<float>(away));
    }
  }
}

}  // namespace

Canvas RenderCustomerPicture(const PointList& cracks_mm, const Vec3& block_size_mm,
                             const CustomerPicture& picture) {
  Require((block_size_mm.array() > 0.0).all() && block_size_mm.allFinite(),
          "a block of {} x {} x {} mm", block_size_mm.x(), block_size_mm.y(),
          block_size_mm.z());
  Require(picture.longer_side_px >= kMinCustomerPicturePx &&
              picture.longer_side_px <= kMaxCustomerPicturePx,
          "a picture of {} pixels, of {} .. {}", picture.longer_side_px,
          kMinCustomerPicturePx, kMaxCustomerPicturePx);
  const auto flat_axis = FlatAxis(cracks_mm);
  const Box3 shown_mm = ShownPart(cracks_mm, block_size_mm, kMinWorkRatio, flat_axis);
  const double side = picture.longer_side_px;
  const int margin = static_cast<int>(kMarginRatio * side);
  const int name_px = picture.name.empty() ? 0 : static_cast<int>(kNameRatio * side);
  const double aspect = AspectOf(shown_mm, flat_axis);
  // The shown part with its margins and the name has to fit the longer side.
  const double height =
      std::min(side - 2 * margin - name_px, (side - 2 * margin) / aspect);
  const Rect inner{margin, margin, static_cast<int>(height * aspect),
                   static_cast<int>(height)};
  Canvas canvas(inner.width + 2 * margin, inner.height + 2 * margin + name_px);
  if (picture.ground == Ground::kDark) DrawDarkGround(canvas);
  const Projection projection = ProjectionFor(shown_mm, flat_axis, inner);
  // Faces would cover what a transparent picture lies on, or the ground of a part.
  const bool has_faces =
      picture.ground == Ground::kDark && shown_mm.size_mm() == block_size_mm;
  BlockDrawing block(
      canvas, {Vec3::Zero(), block_size_mm}, projection,
      {.faces = has_faces ? 0.4F : 0.0F, .edges = 0.3F, .edge_width = side / 1200.0});
  block.DrawBehind();
  DrawCloud(canvas, {0, 0, canvas.width(), canvas.height()}, projection, cracks_mm,
            {.max_sigma_px = static_cast<float>(side / 600.0),
             .is_flat = flat_axis.has_value()});
  block.DrawInFront();
  if (!picture.name.empty()) {
    const TextStyle style{
        .cap_height_px = 0.4 * name_px, .color = Palette().text, .align = Align::kCenter};
    DrawText(canvas,
             {0.5 * canvas.width(), inner.bottom() + 0.5 * margin + 0.7 * name_px},
             picture.name, FittingStyle(picture.name, style, inner.width));
  }
  return canvas;
}

Status WriteCustomerPicture(const std::filesystem::path& file, const PointList& cracks_mm,
                            const Vec3& block_size_mm, const CustomerPicture& picture) {
  return WritePng(
      file, RenderCustomerPicture(cracks_mm, block_size_mm, picture),
      picture.ground == Ground::kTransparent ? Opacity::kOfLight : Opacity::kFull);
}

}  // namespace intaglio::render
