#include "engrave/render/canvas.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/segment.h"

// Coverage of a pixel by a shape is taken as clamp(0.5 - signed distance of the pixel's
// centre to the shape's edge): exact for straight edges along the axes, and within a
// few per cent for others.

namespace intaglio::render {
namespace {

float Coverage(double inside_px) {
  return static_cast<float>(std::clamp(inside_px + 0.5, 0.0, 1.0));
}

Vec2 CenterOf(int x, int y) { return {x + 0.5, y + 0.5}; }

/// Pixels whose centres may lie in low..high, clipped to the canvas.
struct PixelRange {
  int first;
  int last;
};
PixelRange Covering(double low, double high, int size) {
  const double first = std::clamp(std::floor(low), 0.0, static_cast<double>(size));
  const double last = std::clamp(std::floor(high), -1.0, size - 1.0);
  return {static_cast<int>(first), static_cast<int>(last)};
}

constexpr int kRowsPerPixel = 4;

struct Crossing {
  double x = 0;
  int turn = 0;  ///< +1 where the loop goes down, -1 where it goes up

  bool operator<(const Crossing& other) const { return x < other.x; }
};

/// Columns first .. first + size of one row of pixels.
struct Row {
  int first = 0;
  std::vector<float> covered;

  void Cover(double begin, double end) {
    begin = std::max(begin - first, 0.0);
    end = std::min(end - first, static_cast<double>(covered.size()));
    for (int x = static_cast<int>(begin); x < end; ++x) {
      covered[static_cast<std::size_t>(x)] += static_cast<float>(
          std::min(end, x + 1.0) - std::max(begin, static_cast<double>(x)));
    }
  }
};

void CoverAt(const std::vector<std::vector<Vec2>>& loops, double y, Row& row) {
  std::vector<Crossing> crossings;
  for (const std::vector<Vec2>& loop : loops) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vec2 &a = loop[k], &b = loop[(k + 1) % loop.size()];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double x = a.x() + (b.x() - a.x()) * (y - a.y()) / (b.y() - a.y());
      crossings.push_back({x, a.y() <= y ? 1 : -1});
    }
  }
  std::sort(crossings.begin(), crossings.end());
  int winding = 0;
  for (std::size_t k = 0; k + 1 < crossings.size(); ++k) {
    winding += crossings[k].turn;
    if (winding != 0) row.Cover(crossings[k].x, crossings[k + 1].x);
  }
}

}  // namespace

Color Srgb(std::uint32_t rgb) {
  const auto linear = [](std::uint32_t byte) {
    const double s = static_cast<double>(byte & 0xFFU) / 255.0;
    return static_cast<float>(s <= 0.04045 ? s / 12.92
                                           : std::pow((s + 0.055) / 1.055, 2.4));
  };
  return {linear(rgb >> 16U), linear(rgb >> 8U), linear(rgb)};
}

Canvas::Canvas(int width, int height) : width_(width), height_(height) {
  Require(width >= 1 && height >= 1 && width <= 16384 && height <= 16384,
          "a canvas of {} x {} pixels", width, height);
  pixels_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void DrawLine(Canvas& canvas, const Vec2& from_px, const Vec2& to_px, double width_px,
              const Paint& paint) {
  const double half_px = 0.5 * std::max(width_px, 1.0);
  const float alpha = paint.alpha * static_cast<float>(std::min(width_px, 1.0));
  // Step along the longer direction; across it only the pixels near the line count.
  const Vec2 along = to_px - from_px;
  const int major = std::abs(along.x()) >= std::abs(along.y()) ? 0 : 1;
  const int minor = 1 - major;
  const double slope = along[major] == 0.0 ? 0.0 : along[minor] / along[major];
  const double reach_px = (half_px + 1.0) * std::hypot(1.0, slope) + 1.0;
  const int major_size = major == 0 ? canvas.width() : canvas.height();
  const int minor_size = major == 0 ? canvas.height() : canvas.width();
  const auto range =
      Covering(std::min(from_px[major], to_px[major]) - half_px - 1.0,
               std::max(from_px[major], to_px[major]) + half_px + 1.0, major_size);
  for (int i = range.first; i <= range.last; ++i) {
    const double at = from_px[minor] + slope * (i + 0.5 - from_px[major]);
    const auto across = Covering(at - reach_px, at + reach_px, minor_size);
    for (int j = across.first; j <= across.last; ++j) {
      const int x = major == 0 ? i : j;
      const int y = major == 0 ? j : i;
      const double distance =
          std::sqrt(SquaredDistanceFromSegment(CenterOf(x, y), from_px, to_px));
      canvas.Blend(x, y, paint.color, alpha * Coverage(half_px - distance));
    }
  }
}

void DrawDisc(Canvas& canvas, const Vec2& center_px, double radius_px,
              const Paint& paint) {
  const auto xs = Covering(center_px.x() - radius_px - 1.0,
                           center_px.x() + radius_px + 1.0, canvas.width());
  const auto ys = Covering(center_px.y() - radius_px - 1.0,
                           center_px.y() + radius_px + 1.0, canvas.height());
  for (int y = ys.first; y <= ys.last; ++y) {
    for (int x = xs.first; x <= xs.last; ++x) {
      const double distance = (CenterOf(x, y) - center_px).norm();
      canvas.Blend(x, y, paint.color, paint.alpha * Coverage(radius_px - distance));
    }
  }
}

void FillConvex(Canvas& canvas, const std::vector<Vec2>& corners_px, const Paint& paint) {
  Require(corners_px.size() >= 3, "a polygon of {} corners", corners_px.size());
  Vec2 low = corners_px.front();
  Vec2 high = low;
  double twice_area = 0.0;
  struct Edge {
    Vec2 from, along;
    double length;
  };
  std::vector<Edge> edges;
  for (std::size_t i = 0; i < corners_px.size(); ++i) {
    const Vec2& a = corners_px[i];
    const Vec2& b = corners_px[(i + 1) % corners_px.size()];
    low = low.cwiseMin(a);
    high = high.cwiseMax(a);
    twice_area += a.x() * b.y() - a.y() * b.x();
    edges.push_back({a, b - a, std::max((b - a).norm(), 1e-9)});
  }
  const double sense = twice_area < 0.0 ? -1.0 : 1.0;
  const auto xs = Covering(low.x() - 1.0, high.x() + 1.0, canvas.width());
  const auto ys = Covering(low.y() - 1.0, high.y() + 1.0, canvas.height());
  for (int y = ys.first; y <= ys.last; ++y) {
    for (int x = xs.first; x <= xs.last; ++x) {
      double inside = 1.0;
      for (std::size_t i = 0; i < edges.size() && inside > -0.5; ++i) {
        const auto& [a, edge, length] = edges[i];
        const Vec2 to = CenterOf(x, y) - a;
        inside =
            std::min(inside, sense * (edge.x() * to.y() - edge.y() * to.x()) / length);
      }
      canvas.Blend(x, y, paint.color, paint.alpha * Coverage(inside));
    }
  }
}

void FillRect(Canvas& canvas, const Rect& rect, const Paint& paint) {
  for (int y = std::max(rect.y, 0); y < std::min(rect.bottom(), canvas.height()); ++y) {
    for (int x = std::max(rect.x, 0); x < std::min(rect.right(), canvas.width()); ++x) {
      canvas.Blend(x, y, paint.color, paint.alpha);
    }
  }
}

void FrameRect(Canvas& canvas, const Rect& rect, const Paint& paint) {
  FillRect(canvas, {rect.x, rect.y, rect.width, 1}, paint);
  FillRect(canvas, {rect.x, rect.bottom() - 1, rect.width, 1}, paint);
  FillRect(canvas, {rect.x, rect.y + 1, 1, rect.height - 2}, paint);
  FillRect(canvas, {rect.right() - 1, rect.y + 1, 1, rect.height - 2}, paint);
}

void FillLoops(Canvas& canvas, const std::vector<std::vector<Vec2>>& loops_px,
               const Paint& paint) {
  Vec2 low(canvas.width(), canvas.height()), high = Vec2::Zero();
  for (const std::vector<Vec2>& loop : loops_px) {
    for (const Vec2& p : loop) low = low.cwiseMin(p), high = high.cwiseMax(p);
  }
  low = low.cwiseMax(0.0);
  high = high.cwiseMin(Vec2(canvas.width(), canvas.height()));
  if (low.x() >= high.x() || low.y() >= high.y()) return;
  const int right = std::min(canvas.width(), static_cast<int>(std::ceil(high.x())));
  Row row{static_cast<int>(low.x()), {}};
  for (int y = static_cast<int>(low.y()); y < high.y(); ++y) {
    row.covered.assign(static_cast<std::size_t>(right - row.first), 0.0F);
    for (int k = 0; k < kRowsPerPixel; ++k)
      CoverAt(loops_px, y + (k + 0.5) / kRowsPerPixel, row);
    for (int x = row.first; x < right; ++x) {
      const float share =
          row.covered[static_cast<std::size_t>(x - row.first)] / kRowsPerPixel;
      if (share > 0) canvas.Blend(x, y, paint.color, paint.alpha * std::min(share, 1.0F));
    }
  }
}

}  // namespace intaglio::render
