#include "engrave/render/block_drawing.h"

#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

constexpr double kAzimuthRad = 0.52;  // 30 degrees to the right: two sides are visible
// The flattest first: forms are recognised from the front. A flat block is seen from
// higher up, where that costs no size.
constexpr std::array<double, 4> kElevationsRad = {0.30, 0.36, 0.42, 0.48};
constexpr double kEqualSize = 0.98;

}  // namespace

Projection GlassPerspective(const Box3& box_mm, const Rect& into) {
  const auto at = [&](double elevation_rad) {
    return Projection::Perspective(box_mm, kAzimuthRad, elevation_rad, into);
  };
  const double middle_mm = 3.0 * box_mm.size_mm().norm();
  Projection best = at(kElevationsRad[0]);
  const double min_px = kEqualSize * best.px_per_mm(middle_mm);
  for (const double elevation_rad : kElevationsRad) {
    const Projection higher = at(elevation_rad);
    if (higher.px_per_mm(middle_mm) >= min_px) best = higher;
  }
  return best;
}

void BlockDrawing::DrawBehind() {
  for (const Face& face : kFaces) {
    if (!Sees(face)) DrawFace(face, 0.05F);
  }
  DrawEdges(false);
}

void BlockDrawing::DrawInFront() {
  // The top catches the most light, the front the least.
  constexpr std::array<float, 3> kSheen = {0.045F, 0.02F, 0.075F};
  for (const Face& face : kFaces) {
    if (Sees(face)) DrawFace(face, kSheen[static_cast<std::size_t>(face.axis)]);
  }
  DrawEdges(true);
}

void BlockDrawing::DrawFace(const Face& face, float alpha) {
  FillConvex(canvas_, Corners(face), {Palette().glass, style_.faces * alpha});
}

bool BlockDrawing::Sees(const Face& face) const {
  const Vec3 normal = (face.high ? 1.0 : -1.0) * Vec3::Unit(face.axis);
  return projection_.Sees(normal, face.high ? box_mm_.max_mm : box_mm_.min_mm);
}

std::vector<Vec2> BlockDrawing::Corners(const Face& face) const {
  const int u = (face.axis + 1) % 3;
  const int v = (face.axis + 2) % 3;
  std::vector<Vec2> corners;
  constexpr std::array<std::array<bool, 2>, 4> kRound = {
      {{false, false}, {true, false}, {true, true}, {false, true}}};
  for (const auto& [high_u, high_v] : kRound) {
    Vec3 corner_mm = face.high ? box_mm_.max_mm : box_mm_.min_mm;
    corner_mm[u] = high_u ? box_mm_.max_mm[u] : box_mm_.min_mm[u];
    corner_mm[v] = high_v ? box_mm_.max_mm[v] : box_mm_.min_mm[v];
    corners.push_back(Place(corner_mm));
  }
  return corners;
}

void BlockDrawing::DrawEdges(bool front) {
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const bool high_u : {false, true}) {
      for (const bool high_v : {false, true}) {
        if ((Sees({u, high_u}) || Sees({v, high_v})) != front) continue;
        Vec3 from_mm = box_mm_.min_mm;
        if (high_u) from_mm[u] = box_mm_.max_mm[u];
        if (high_v) from_mm[v] = box_mm_.max_mm[v];
        Vec3 to_mm = from_mm;
        to_mm[axis] = box_mm_.max_mm[axis];
        DrawEdge(from_mm, to_mm, front);
      }
    }
  }
}

void BlockDrawing::DrawEdge(const Vec3& from_mm, const Vec3& to_mm, bool front) {
  const Color color = Palette().edge;
  const Vec2 from_px = Place(from_mm);
  const Vec2 to_px = Place(to_mm);
  const auto draw = [&](double width_px, float alpha) {
    DrawLine(canvas_, from_px, to_px, style_.edge_width * width_px,
             {color, style_.edges * alpha});
  };
  if (front) {
    draw(9.0, 0.03F);
    draw(4.0, 0.06F);
  }
  draw(front ? 1.5 : 1.0, front ? 0.80F : 0.20F);
}

}  // namespace intaglio::render
