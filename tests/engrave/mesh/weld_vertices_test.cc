#include "engrave/mesh/weld_vertices.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <tuple>

#include "engrave/core/check.h"

namespace intaglio::mesh {
namespace {

TEST(VertexWelder, NumbersPointsInTheOrderTheyFirstAppear) {
  VertexWelder welder;
  EXPECT_EQ(welder.Add(Vec3(5, 0, 0)), 0u);
  EXPECT_EQ(welder.Add(Vec3(1, 0, 0)), 1u);
  EXPECT_EQ(welder.Add(Vec3(5, 0, 0)), 0u);
  EXPECT_EQ(welder.Add(Vec3(3, 0, 0)), 2u);
  EXPECT_EQ(welder.size(), 3u);
  EXPECT_EQ(welder.TakePoints(), (PointList{{5, 0, 0}, {1, 0, 0}, {3, 0, 0}}));
  EXPECT_EQ(welder.Add(Vec3(3, 0, 0)), 0u) << "empty after its points were taken";
}

TEST(VertexWelder, TakesMinusZeroForZero) {
  VertexWelder welder;
  welder.Add(Vec3(-0.0, 1, -0.0));
  EXPECT_EQ(welder.Add(Vec3(0.0, 1, 0.0)), 0u);
  EXPECT_FALSE(std::signbit(welder.TakePoints()[0].x()));
}

TEST(VertexWelder, KeepsNeighbouringDoublesApart) {
  VertexWelder welder;
  const double next = std::nextafter(1.0, 2.0);
  EXPECT_EQ(welder.Add(Vec3(1, 1, 1)), 0u);
  EXPECT_EQ(welder.Add(Vec3(1, 1, next)), 1u);
  EXPECT_EQ(welder.Add(Vec3(next, 1, 1)), 2u);
}

TEST(VertexWelder, AgreesWithAnOrderedMapOnManyRepeatedPoints) {
  std::mt19937_64 random(1);
  // A lattice of floats, as in an STL: the low bits of the doubles are all zero, which
  // a poor hash would not survive. 40^3 places, 200 000 draws: most are repeated.
  std::uniform_int_distribution<int> step(-20, 19);
  VertexWelder welder;
  std::map<std::tuple<double, double, double>, std::uint32_t> oracle;
  for (int i = 0; i < 200'000; ++i) {
    const Vec3 p(0.1f * static_cast<float>(step(random)),
                 0.25f * static_cast<float>(step(random)),
                 static_cast<float>(step(random)) / 3.0f);
    const auto next = static_cast<std::uint32_t>(oracle.size());
    const auto expected =
        oracle.try_emplace({p.x() + 0.0, p.y() + 0.0, p.z() + 0.0}, next).first->second;
    ASSERT_EQ(welder.Add(p), expected);
  }
  EXPECT_EQ(welder.size(), oracle.size());
}

TEST(VertexWelder, RefusesWhatIsNotAPlace) {
  VertexWelder welder;
  EXPECT_THROW(welder.Add(Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0)),
               PreconditionError);
}

}  // namespace
}  // namespace intaglio::mesh
