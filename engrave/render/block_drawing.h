#pragma once

// A box of glass in a picture: faint faces, and edges of which those behind are fainter.
// What is in the glass is drawn between DrawBehind and DrawInFront.

#include <array>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"
#include "engrave/render/projection.h"

namespace intaglio::render {

/// Shares of the usual visibility of faces and edges, and of the width of edges.
struct GlassStyle {
  float faces = 1.0F;
  float edges = 1.0F;
  double edge_width = 1.0;
};

class BlockDrawing {
 public:
  BlockDrawing(Canvas& canvas, const Box3& box_mm, const Projection& projection,
               const GlassStyle& style = {})
      : canvas_(canvas), box_mm_(box_mm), projection_(projection), style_(style) {}

  /// The faces and edges turned away from the viewer.
  void DrawBehind();
  /// Those turned to the viewer.
  void DrawInFront();

 private:
  /// A face of the box: axis 0..2, and its low or high side.
  struct Face {
    int axis;
    bool high;
  };
  static constexpr std::array<Face, 6> kFaces = {
      {{0, false}, {0, true}, {1, false}, {1, true}, {2, false}, {2, true}}};

  Vec2 Place(const Vec3& p_mm) const { return projection_(p_mm).at_px; }
  bool Sees(const Face& face) const;
  std::vector<Vec2> Corners(const Face& face) const;
  void DrawFace(const Face& face, float alpha);
  /// The twelve edges; `front` selects those with a visible adjacent face.
  void DrawEdges(bool front);
  void DrawEdge(const Vec3& from_mm, const Vec3& to_mm, bool front);

  Canvas& canvas_;
  Box3 box_mm_;
  const Projection& projection_;
  GlassStyle style_;
};

/// A view in perspective for every picture: two sides and the top are visible. Of the
/// elevations 17..28 degrees the one that fills `into` best.
Projection GlassPerspective(const Box3& box_mm, const Rect& into);

}  // namespace intaglio::render
