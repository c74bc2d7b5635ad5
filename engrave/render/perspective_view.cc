#include <array>
#include <cmath>

#include "engrave/render/cloud_image.h"
#include "engrave/render/projection.h"
#include "engrave/render/text.h"
#include "engrave/render/view_parts.h"

namespace intaglio::render {
namespace {

constexpr double kAzimuthRad = 0.52;    // 30 degrees to the right: two sides are visible
constexpr double kElevationRad = 0.30;  // 17 degrees: the top is visible, but flat

/// A face of the block: axis 0..2, and its low or high side.
struct FaceOfBlock {
  int axis;
  bool high;
};
constexpr std::array<FaceOfBlock, 6> kFaces = {
    {{0, false}, {0, true}, {1, false}, {1, true}, {2, false}, {2, true}}};

class BlockDrawing {
 public:
  BlockDrawing(Canvas& canvas, const Rect& cell, const Vec3& block_size_mm)
      : canvas_(canvas),
        size_mm_(block_size_mm),
        projection_(Projection::Perspective(
            block_size_mm, kAzimuthRad, kElevationRad,
            {cell.x + 70, cell.y + 90, cell.width - 140, cell.height - 180})) {}

  const Projection& projection() const { return projection_; }

  void DrawBehind() {
    for (const FaceOfBlock& face : kFaces) {
      if (!Sees(face)) FillConvex(canvas_, Corners(face), {palette_.glass, 0.05F});
    }
    DrawFloorGrid();
    DrawEdges(false);
  }

  void DrawInFront() {
    // The top catches the most light, the front the least.
    constexpr std::array<float, 3> kSheen = {0.045F, 0.02F, 0.075F};
    for (const FaceOfBlock& face : kFaces) {
      if (!Sees(face)) continue;
      const float alpha = kSheen[static_cast<std::size_t>(face.axis)];
      FillConvex(canvas_, Corners(face), {palette_.glass, alpha});
    }
    DrawEdges(true);
  }

  void DrawNumbers() {
    // Along the lower front edge, the lower right edge, and the left front edge.
    DrawAxis(0, Vec3(0, 0, 0), "x, mm");
    DrawAxis(1, Vec3(size_mm_.x(), 0, 0), "y, mm");
    DrawAxis(2, Vec3(0, 0, 0), "z, mm");
  }

  /// Where the laser comes from.
  void DrawBeam() {
    const Vec3 top_mm(0.5 * size_mm_.x(), 0.5 * size_mm_.y(), size_mm_.z());
    const Vec2 tip_px = Place(top_mm);
    const Vec2 tail_px = tip_px - Vec2(0, 96);
    DrawLine(canvas_, tail_px, tip_px, 7.0, {palette_.beam, 0.05F});
    DrawLine(canvas_, tail_px, tip_px, 1.4, {palette_.beam, 0.7F});
    FillConvex(canvas_, {tip_px, tip_px + Vec2(-5, -13), tip_px + Vec2(5, -13)},
               {palette_.beam, 0.85F});
    DrawText(canvas_, tail_px + Vec2(10, 10), "beam",
             {.cap_height_px = 10.0, .color = palette_.beam, .alpha = 0.8F});
  }

 private:
  Vec2 Place(const Vec3& p_mm) const { return projection_(p_mm).at_px; }

  bool Sees(const FaceOfBlock& face) const {
    const Vec3 place_mm = face.high ? size_mm_ : Vec3(Vec3::Zero());
    const Vec3 normal = (face.high ? 1.0 : -1.0) * Vec3::Unit(face.axis);
    return projection_.Sees(normal, place_mm);
  }

  std::vector<Vec2> Corners(const FaceOfBlock& face) const {
    const int u = (face.axis + 1) % 3;
    const int v = (face.axis + 2) % 3;
    std::vector<Vec2> corners;
    constexpr std::array<std::array<int, 2>, 4> kRound = {
        {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    for (const auto& [along_u, along_v] : kRound) {
      Vec3 corner_mm = Vec3::Zero();
      corner_mm[face.axis] = face.high ? size_mm_[face.axis] : 0.0;
      corner_mm[u] = along_u * size_mm_[u];
      corner_mm[v] = along_v * size_mm_[v];
      corners.push_back(Place(corner_mm));
    }
    return corners;
  }

  /// The twelve edges; `front` selects those with a visible adjacent face.
  void DrawEdges(bool front) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3;
      const int v = (axis + 2) % 3;
      for (const bool high_u : {false, true}) {
        for (const bool high_v : {false, true}) {
          if ((Sees({u, high_u}) || Sees({v, high_v})) != front) continue;
          Vec3 from_mm = Vec3::Zero();
          from_mm[u] = high_u ? size_mm_[u] : 0.0;
          from_mm[v] = high_v ? size_mm_[v] : 0.0;
          DrawEdge(from_mm, from_mm + size_mm_[axis] * Vec3::Unit(axis), front);
        }
      }
    }
  }

  void DrawEdge(const Vec3& from_mm, const Vec3& to_mm, bool front) {
    const Vec2 from_px = Place(from_mm);
    const Vec2 to_px = Place(to_mm);
    if (front) {
      DrawLine(canvas_, from_px, to_px, 9.0, {palette_.edge, 0.03F});
      DrawLine(canvas_, from_px, to_px, 4.0, {palette_.edge, 0.06F});
    }
    DrawLine(canvas_, from_px, to_px, front ? 1.5 : 1.0,
             {palette_.edge, front ? 0.80F : 0.20F});
  }

  void DrawFloorGrid() {
    const double fine_mm = NiceStep(size_mm_.maxCoeff(), 16);
    for (int axis = 0; axis < 2; ++axis) {
      const int other = 1 - axis;
      for (int i = 1; i * fine_mm < size_mm_[axis] * (1 - 1e-9); ++i) {
        Vec3 from_mm = Vec3::Zero();
        from_mm[axis] = i * fine_mm;
        const Vec3 to_mm = from_mm + size_mm_[other] * Vec3::Unit(other);
        DrawLine(canvas_, Place(from_mm), Place(to_mm), 1.0, {palette_.grid, 0.10F});
      }
    }
  }

  void DrawAxis(int axis, const Vec3& from_mm, const char* name) {
    const double step_mm = NiceStep(size_mm_.maxCoeff(), 8);
    const Vec2 middle_px = Place(0.5 * size_mm_);
    const Vec2 a_px = Place(from_mm);
    const Vec2 b_px = Place(from_mm + size_mm_[axis] * Vec3::Unit(axis));
    // Outwards: across the edge, away from the middle of the block.
    const Vec2 along = (b_px - a_px).normalized();
    Vec2 outward(-along.y(), along.x());
    if (outward.dot(0.5 * (a_px + b_px) - middle_px) < 0.0) outward = -outward;
    TextStyle style{.cap_height_px = 9.5, .color = palette_.dim_text};
    style.align = axis == 2 ? Align::kRight : Align::kCenter;
    const Vec2 drop(0.0, axis == 2 ? 5.0 : 6.0);
    for (int i = 0; i * step_mm <= size_mm_[axis] * (1 + 1e-9); ++i) {
      const Vec2 at_px = Place(from_mm + i * step_mm * Vec3::Unit(axis));
      DrawLine(canvas_, at_px + 2.0 * outward, at_px + 7.0 * outward, 1.0,
               {palette_.dim_text});
      // The corner belongs to both axes: one number is enough.
      if (i == 0 && axis == 1) continue;
      DrawText(canvas_, at_px + (axis == 2 ? 11.0 : 20.0) * outward + drop,
               ShortNumber(i * step_mm), style);
    }
    TextStyle title{.cap_height_px = 10.5, .color = palette_.text};
    title.align = Align::kCenter;
    const Vec2 name_px = 0.5 * (a_px + b_px) + (axis == 2 ? 58.0 : 44.0) * outward + drop;
    DrawText(canvas_, name_px, name, title);
  }

  Canvas& canvas_;
  Palette palette_;
  Vec3 size_mm_;
  Projection projection_;
};

}  // namespace

void DrawPerspectiveView(Canvas& canvas, const Rect& cell, const PointList& cracks_mm,
                         const Vec3& block_size_mm) {
  DrawCell(canvas, cell, "Block", "in perspective");
  BlockDrawing block(canvas, cell, block_size_mm);
  block.DrawBehind();
  DrawCloud(canvas, cell.Inset(1), block.projection(), cracks_mm);
  block.DrawInFront();
  block.DrawNumbers();
  block.DrawBeam();
}

}  // namespace intaglio::render
