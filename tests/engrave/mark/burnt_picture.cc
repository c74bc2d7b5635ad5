#include "tests/engrave/mark/burnt_picture.h"

#include <algorithm>
#include <cmath>

namespace intaglio::mark {
namespace {

double DistanceToSegment(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 way = b - a;
  const double length2 = way.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(way) / length2, 0.0, 1.0) : 0;
  return (a + t * way - p).norm();
}

}  // namespace

BurntPicture Burn(const std::vector<Mark>& marks, double line_mm, const Vec2& low_mm,
                  const Vec2& high_mm, double pixel_mm) {
  BurntPicture picture;
  picture.width = static_cast<int>(std::ceil((high_mm - low_mm).x() / pixel_mm));
  picture.height = static_cast<int>(std::ceil((high_mm - low_mm).y() / pixel_mm));
  picture.pixels.assign(static_cast<std::size_t>(picture.width * picture.height), 255);
  const double reach = line_mm / 2;
  const auto burn = [&](const Vec2& a, const Vec2& b) {
    const Vec2 from = (a.cwiseMin(b) - low_mm - Vec2(reach, reach)) / pixel_mm;
    const Vec2 to = (a.cwiseMax(b) - low_mm + Vec2(reach, reach)) / pixel_mm;
    for (int y = std::max(0, static_cast<int>(from.y()));
         y <= std::min(picture.height - 1, static_cast<int>(to.y())); ++y) {
      for (int x = std::max(0, static_cast<int>(from.x()));
           x <= std::min(picture.width - 1, static_cast<int>(to.x())); ++x) {
        const Vec2 p = low_mm + pixel_mm * Vec2(x + 0.5, y + 0.5);
        if (DistanceToSegment(p, a, b) <= reach)
          picture.pixels[static_cast<std::size_t>(
              (picture.height - 1 - y) * picture.width + x)] = 0;
      }
    }
  };
  for (const Mark& mark : marks) {
    std::vector<Vec2> places = PlacesOf(mark, 0.001);
    if (mark.closed) places.push_back(places.front());
    for (std::size_t i = 0; i < places.size(); ++i)
      burn(places[i == 0 ? 0 : i - 1], places[i]);
  }
  return picture;
}

}  // namespace intaglio::mark
