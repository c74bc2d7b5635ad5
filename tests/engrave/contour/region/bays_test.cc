// Insets of outlines that no tool can follow: teeth, spikes, arms of a fractal. The
// oracle is the distance to the border as it was drawn, at places of a raster.

#include "engrave/contour/region/bays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <ctime>
#include <functional>
#include <numbers>
#include <random>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/region/simplify.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using Points = std::vector<Vec2>;

Edges Loop(const Points& points) {
  Edges edges;
  for (std::size_t k = 0; k < points.size(); ++k)
    edges.push_back(MakeLine(points[k], points[(k + 1) % points.size()]));
  return edges;
}

/// Around a circle by polar coordinates: radius_mm(k) of `count` corners.
Points Around(int count, const std::function<double(int)>& radius_mm) {
  Points points;
  for (int k = 0; k < count; ++k)
    points.push_back(radius_mm(k) *
                     Vec2(std::cos(2 * pi * k / count), std::sin(2 * pi * k / count)));
  return points;
}

/// Teeth along the upper side of a plate, corner by corner: up, along, down, along.
Points Comb(int teeth, double pitch_mm, double width_mm, double height_mm) {
  Points points;
  for (int k = teeth; k-- > 0;) {
    const double x = k * pitch_mm;
    for (const Vec2& corner : {Vec2(x + width_mm, 0), Vec2(x + width_mm, height_mm),
                               Vec2(x, height_mm), Vec2(x, 0)})
      points.push_back(corner);
  }
  points.emplace_back(0, -3);
  points.emplace_back(teeth * pitch_mm, -3);
  return points;
}

Points Saw(int teeth, double tooth_mm) {
  Points points;
  for (int k = teeth; k-- > 0;) {
    points.emplace_back((k + 1) * tooth_mm, 0);
    points.emplace_back((k + 0.5) * tooth_mm, tooth_mm);
  }
  points.emplace_back(0, 0);
  points.emplace_back(0, -3);
  points.emplace_back(teeth * tooth_mm, -3);
  return points;
}

Points Koch(int depth, double radius_mm) {
  using Complex = std::complex<double>;
  std::vector<Complex> corners;
  for (int k = 0; k < 3; ++k) corners.push_back(std::polar(radius_mm, 2 * pi * k / 3));
  for (; depth > 0; --depth) {
    std::vector<Complex> finer;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Complex a = corners[k], third = (corners[(k + 1) % corners.size()] - a) / 3.0;
      finer.insert(
          finer.end(),
          {a, a + third, a + third + third * std::polar(1.0, -pi / 3), a + 2.0 * third});
    }
    corners = finer;
  }
  Points points;
  for (const Complex& corner : corners) points.emplace_back(corner.real(), corner.imag());
  return points;
}

Points Turned(Points points) { return {points.rbegin(), points.rend()}; }

/// Places of a raster that are on the wrong side of the inset's border.
int CountWrong(const Region& drawn, double distance_mm, double tolerance_mm) {
  const auto inset = InsetInStages(drawn, distance_mm, tolerance_mm);
  EXPECT_TRUE(inset) << inset.error().message;
  if (!inset) return -1;
  Edges all;
  for (const Edges& loop : drawn.loops) all.insert(all.end(), loop.begin(), loop.end());
  const EdgeTree border(all);
  FlatBox box{Vec2::Constant(1e9), Vec2::Constant(-1e9)};
  for (const Edge& edge : all) {
    box.min_mm = box.min_mm.cwiseMin(edge.begin_mm);
    box.max_mm = box.max_mm.cwiseMax(edge.begin_mm);
  }
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0, 1);
  int wrong = 0;
  for (int k = 0; k < 20'000; ++k) {
    const Vec2 place =
        box.min_mm +
        Vec2(part(random), part(random)).cwiseProduct(box.max_mm - box.min_mm);
    const double free_mm = border.IsInside(place) ? border.DistanceTo(place) : -1;
    if (std::abs(free_mm - distance_mm) < tolerance_mm) continue;
    wrong += IsInside(*inset, place) == (free_mm > distance_mm) ? 0 : 1;
  }
  return wrong;
}

TEST(NarrowBays, InsetsAreThoseOfTheBorderAsDrawn) {
  std::mt19937 random(7);
  const auto spikes = [&](double mm) {
    return Around(3000, [&](int) {
      return 4 + mm * (static_cast<double>(random() % 2001) / 1000 - 1);
    });
  };
  const Points star = Around(2000, [](int k) { return k % 2 == 0 ? 3.0 : 5.0; });
  const std::vector<Region> shapes = {
      {{Loop(Saw(1500, 0.008))}},
      {{Loop(Comb(500, 0.02, 0.01, 2))}},
      {{Loop(Comb(100, 0.1, 0.05, 2))}},
      {{Loop(Comb(20, 1.2, 0.6, 2))}},  // the tool goes into these
      {{Loop(star)}},
      {{Loop(Koch(5, 5))}},
      {{Loop(spikes(0.05))}},
      {{Loop(spikes(0.7))}},
      // Around an island with teeth, with an island in a gap of a comb.
      {{Loop(Around(600, [](int) { return 6.0; })), Loop(Turned(star))}},
      {{Loop(Comb(50, 0.2, 0.12, 2)),
        Loop({{0.25, 1}, {0.25, 1.1}, {0.28, 1.1}, {0.28, 1}})}},
      // A ring that is nearly closed, thinner than the tool and much larger.
      {{Loop([] {
        Points ring;
        for (int k = 0; k < 400; ++k)
          ring.push_back(5 * Vec2(std::cos(6.28 * k / 399), std::sin(6.28 * k / 399)));
        for (int k = 400; k-- > 0;)
          ring.push_back(4.98 * Vec2(std::cos(6.28 * k / 399), std::sin(6.28 * k / 399)));
        return ring;
      }())}}};
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    for (const double distance_mm : {0.05, 0.25, 0.6})
      EXPECT_EQ(CountWrong(shapes[k], distance_mm, 0.004), 0)
          << "shape " << k << " at " << distance_mm;
  }
}

// Each of these needed gigabytes, or minutes: some hundred teeth lie below one tool.
TEST(NarrowBays, EightyThousandTeethTakeSecondsAndFewEdges) {
  const std::vector<std::pair<const char*, Points>> shapes = {
      {"saw", Saw(80'000, 0.008)},
      {"comb", Comb(20'000, 0.02, 0.01, 10)},
      {"star", Around(20'000, [](int k) { return k % 2 == 0 ? 20.0 : 21.0; })}};
  for (const auto& [name, points] : shapes) {
    const std::clock_t begin = std::clock();
    const Region drawn{{Loop(points)}};
    const Region cut = WithoutNarrowBays(drawn, 0.25, 0.03);
    EXPECT_LT(cut.loops[0].size(), points.size() / 2) << name;
    const auto inset = InsetInStages(drawn, 0.25, 0.002);
    ASSERT_TRUE(inset) << name << ": " << inset.error().message;
    EXPECT_FALSE(inset->loops.empty()) << name;
    // Some tenths of a second on an idle machine.
    EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 8) << name;
  }
}

}  // namespace
}  // namespace intaglio::contour
