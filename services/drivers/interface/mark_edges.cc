#include "services/drivers/interface/mark_edges.h"

#include <cmath>

namespace intaglio::drivers {
namespace {

constexpr double kFlatArc_mm = 1e-4, kShortestWay_mm = 1e-5;

/// From place to place with this bulge (mark.h): the sweep is 4 atan(bulge), and the
/// centre lies c / (2 tan(sweep / 2)) to the left of the middle of the chord c.
contour::Edge EdgeToPlace(const mark::Place& from, const Vec2& to_mm) {
  const Vec2 chord = to_mm - from.at_mm;
  const double sweep = 4 * std::atan(from.bulge);
  if (std::abs(from.bulge) * chord.norm() / 2 < kFlatArc_mm)
    return contour::MakeLine(from.at_mm, to_mm);
  const Vec2 left(-chord.y(), chord.x());
  const Vec2 center = (from.at_mm + to_mm) / 2 + left / (2 * std::tan(sweep / 2));
  const Vec2 out = from.at_mm - center;
  contour::Edge arc =
      contour::MakeArc(center, out.norm(), std::atan2(out.y(), out.x()), sweep);
  arc.begin_mm = from.at_mm;
  arc.end_mm = to_mm;
  return arc;
}

}  // namespace

contour::Edges EdgesOfMark(const mark::Mark& mark) {
  contour::Edges edges;
  const std::size_t ways = mark.places.size() - (mark.closed ? 0 : 1);
  for (std::size_t i = 0; i < ways; ++i) {
    const Vec2& to_mm = mark.places[(i + 1) % mark.places.size()].at_mm;
    if ((to_mm - mark.places[i].at_mm).norm() < kShortestWay_mm) continue;
    edges.push_back(EdgeToPlace(mark.places[i], to_mm));
  }
  return edges;
}

}  // namespace intaglio::drivers
