#pragma once

// Models made by the tests themselves, as the bytes of their files.

#include <fmt/format.h>

#include <array>
#include <string>

namespace intaglio::test {

/// An axis-parallel box from the origin, ASCII STL, faces outward.
inline std::string BoxStl(double x, double y, double z) {
  using Corner = std::array<double, 3>;
  constexpr int kFaces[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                 {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                 {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::string text = "solid box\n";
  for (const auto& face : kFaces) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int i : face) {
      const Corner c = {(i & 1) ? x : 0, (i & 2) ? y : 0, (i & 4) ? z : 0};
      text += fmt::format("vertex {} {} {}\n", c[0], c[1], c[2]);
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

}  // namespace intaglio::test
