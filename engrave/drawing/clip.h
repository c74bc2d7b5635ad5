#pragma once

// Cuts curves by areas of any form: clip paths and viewports of SVG, XCLIP of DXF. Frame:
// drawing, mm; z is not looked at.

#include <cstdint>
#include <optional>
#include <vector>

#include "engrave/contour/edge_tree.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

/// One shape of a clip. Its curves are flattened to 1 um, count as closed, and may cross
/// themselves and each other.
struct ClipShape {
  std::vector<Curve> outlines;
  /// Inside is what they run around an odd number of times, else what they do not run
  /// around as often in one direction as in the other.
  bool even_odd = false;
};

/// What clips of one file may still compare, in pairs of edges: 10 million take about two
/// seconds. Where nothing is left curves are not cut.
struct ClipWork {
  std::uint64_t pairs_left = 10'000'000;
};

/// Const and without a state once made.
class ClipArea {
 public:
  /// What is in at least one of the shapes. Nothing: their edges nearly touch and cannot
  /// be told apart, or the work is too much.
  static std::optional<ClipArea> OfShapes(const std::vector<ClipShape>& shapes,
                                          ClipWork& work);
  /// What is in both areas; nothing as above.
  static std::optional<ClipArea> OfBoth(const ClipArea& a, const ClipArea& b,
                                        ClipWork& work);

  /// Its outlines; they do not cross.
  ClipShape AsShape() const;

  /// Appends the part of the curve within the area; its border, to 2 um, is within. A
  /// curve that lies within as a whole stays as it is, exactly. Of another that is
  /// `filled` the area is cut, and its outline then follows that of the clip, running
  /// around every point within as often as before; of one that is not the line is cut,
  /// into several. False, and nothing is appended: as above, or the curve is filled and
  /// not level, or farther than 1e9 mm from the origin.
  bool Cut(const Curve& curve, bool filled, ClipWork& work,
           std::vector<Curve>& inside) const;

 private:
  explicit ClipArea(std::vector<contour::Edges> loops);

  struct Lines {
    std::vector<PointList> lines;
    bool whole = true;      ///< nothing of the curve is outside
    bool too_much = false;  ///< of work: there are none
  };

  bool IsInside(const Vec2& point_mm) const;
  bool IsWithin(const Vec2& point_mm) const;  ///< or on the border
  std::vector<double> CutsOf(const Vec3& from, const Vec3& to, ClipWork& work) const;
  Lines LinesWithin(const PointList& points, bool closed, ClipWork& work) const;
  bool ReachesInto(const contour::EdgeTree& polygon,
                   const std::vector<std::uint32_t>& edges) const;
  bool CutFilled(const Curve& curve, const PointList& points,
                 const std::vector<std::uint32_t>& near, ClipWork& work,
                 std::vector<Curve>& inside) const;

  std::vector<contour::Edges> loops_;
  contour::Edges edges_;                   ///< of all loops
  std::optional<contour::EdgeTree> tree_;  ///< none: nothing is inside
};

}  // namespace intaglio::drawing
