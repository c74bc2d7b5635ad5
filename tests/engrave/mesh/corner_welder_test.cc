#include "engrave/mesh/files/corner_welder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/mesh/weld_vertices.h"

// VertexWelder, which has no batches, is the oracle.

namespace intaglio::mesh {
namespace {

using Corner = CornerWelder::Corner;

void ExpectAsOneByOne(const std::vector<Corner>& corners, std::size_t expected_count,
                      std::size_t corners_a_call) {
  CornerWelder welder(expected_count);
  std::vector<std::uint32_t> indices(corners.size());
  for (std::size_t i = 0; i < corners.size(); i += corners_a_call) {
    const std::size_t count = std::min(corners_a_call, corners.size() - i);
    welder.Add(std::span(corners).subspan(i, count),
               std::span(indices).subspan(i, count));
  }
  VertexWelder one_by_one;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Corner& c = corners[i];
    ASSERT_EQ(indices[i], one_by_one.Add(Vec3(c[0], c[1], c[2]))) << "corner " << i;
  }
  EXPECT_EQ(welder.TakePoints(), one_by_one.TakePoints());
}

TEST(CornerWelder, AgreesWithWeldingOneByOne) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> step(-20, 19);
  std::vector<Corner> corners(200'000);
  for (Corner& c : corners) {
    c = {0.1f * static_cast<float>(step(random)),
         -0.25f * static_cast<float>(step(random)),
         static_cast<float>(step(random)) / 3.0f};
  }
  for (const std::size_t a_call : {1u, 3u, 23u, 24u, 25u, 4096u, 5000u, 200'000u}) {
    ExpectAsOneByOne(corners, 64'000, a_call);
  }
}

TEST(CornerWelder, GrowsBeyondWhatWasExpected) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> place(-50, 50);
  std::vector<Corner> corners(100'000);
  for (Corner& c : corners) c = {place(random), place(random), place(random)};
  corners.insert(corners.end(), corners.begin(), corners.begin() + 50'000);
  ExpectAsOneByOne(corners, 0, 12'288);
}

TEST(CornerWelder, TakesMinusZeroForZeroAndKeepsNeighboursApart) {
  const float next = std::nextafter(1.0f, 2.0f);
  ExpectAsOneByOne({{-0.0f, 1, 0}, {0.0f, 1, -0.0f}, {0, next, 0}, {0, 0, 1}, {1, 0, 0}},
                   4, 5);
}

TEST(CornerWelder, IsEmptyAfterItsPointsWereTaken) {
  CornerWelder welder(5'000);
  const std::vector<Corner> corners = {{5, 0, 0}, {3, 0, 0}};
  std::vector<std::uint32_t> indices(2);
  welder.Add(corners, indices);
  EXPECT_EQ(welder.TakePoints(), (PointList{{5, 0, 0}, {3, 0, 0}}));
  welder.Add(std::span(corners).subspan(1), std::span(indices).subspan(1));
  EXPECT_EQ(indices[1], 0u);
  EXPECT_THROW(welder.Add(corners, std::span(indices).subspan(1)), PreconditionError);
}

}  // namespace
}  // namespace intaglio::mesh
