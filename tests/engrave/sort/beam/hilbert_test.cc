#include "engrave/sort/beam/hilbert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <numeric>

#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

TEST(Hilbert, ConsecutiveCellsAreNeighbours) {
  // The defining property, on the corner cube of 16^3 cells: the curve fills aligned
  // cubes one after another, so the cube's cells are consecutive.
  std::vector<std::pair<std::uint64_t, std::array<int, 3>>> cells;
  for (int x = 0; x < 16; ++x) {
    for (int y = 0; y < 16; ++y) {
      for (int z = 0; z < 16; ++z) {
        cells.push_back(
            {HilbertKey(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                        static_cast<std::uint32_t>(z)),
             {x, y, z}});
      }
    }
  }
  std::sort(cells.begin(), cells.end());
  for (std::size_t i = 1; i < cells.size(); ++i) {
    EXPECT_EQ(cells[i].first, cells[i - 1].first + 1);
    int distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      distance += std::abs(cells[i].second[axis] - cells[i - 1].second[axis]);
    }
    EXPECT_EQ(distance, 1);
  }
}

TEST(Hilbert, SortingKeepsEveryMember) {
  for (const auto& [name, points_mm] : Clouds(500)) {
    std::vector<std::uint32_t> members(points_mm.size());
    std::iota(members.begin(), members.end(), 0U);
    for (const bool flat : {false, true}) {
      auto sorted = AlongHilbertCurve(points_mm, members, flat);
      std::sort(sorted.begin(), sorted.end());
      EXPECT_EQ(sorted, members) << name;
    }
  }
}

}  // namespace
}  // namespace intaglio::sort
