// Every side between a dark and a bright module is an edge with the dark one to its left.
// At each corner as many edges begin as end: one, or two where dark modules touch at the
// corner alone. There the outline turns left, around its own module, and so keeps them
// apart.

#include <fmt/format.h>

#include <array>

#include "engrave/core/check.h"
#include "engrave/matrix_code/matrix_code.h"

namespace intaglio::matrix_code {
namespace {

enum Direction { kRight, kUp, kLeft, kDown };
constexpr std::array<int, 4> kStepX = {1, 0, -1, 0};
constexpr std::array<int, 4> kStepY = {0, 1, 0, -1};

class Tracer {
 public:
  explicit Tracer(const ModuleGrid& grid) : columns_(grid.columns), rows_(grid.rows) {
    edges_.resize(static_cast<std::size_t>((columns_ + 1) * (rows_ + 1)));
    for (int y = 0; y < rows_; ++y)
      for (int x = 0; x < columns_; ++x) AddSides(grid, x, y);
  }

  std::vector<std::vector<Vec2>> Trace() {
    std::vector<std::vector<Vec2>> outlines;
    for (int y = 0; y <= rows_; ++y)
      for (int x = 0; x <= columns_; ++x)
        for (int d = 0; d < 4; ++d)
          if (EdgesAt(x, y)[static_cast<std::size_t>(d)])
            outlines.push_back(TraceFrom(x, y, d));
    return outlines;
  }

 private:
  using Edges = std::array<bool, 4>;  // that begin at a corner, by their direction

  Edges& EdgesAt(int x, int y) {
    return edges_[static_cast<std::size_t>(y * (columns_ + 1) + x)];
  }

  void AddSides(const ModuleGrid& grid, int x, int y) {
    const auto dark = [&](int column, int up) {
      return grid.IsDark(column, rows_ - 1 - up);
    };
    if (!dark(x, y)) return;
    if (!dark(x, y - 1)) EdgesAt(x, y)[kRight] = true;
    if (!dark(x + 1, y)) EdgesAt(x + 1, y)[kUp] = true;
    if (!dark(x, y + 1)) EdgesAt(x + 1, y + 1)[kLeft] = true;
    if (!dark(x - 1, y)) EdgesAt(x, y + 1)[kDown] = true;
  }

  /// Left, straight on or right. `closing`: the direction in which the outline began at
  /// this corner, whose edge is taken already; -1 at other corners.
  int NextDirection(int x, int y, int before, int closing) {
    for (const int turn : {1, 0, 3}) {
      const int next = (before + turn) % 4;
      if (next == closing || EdgesAt(x, y)[static_cast<std::size_t>(next)]) return next;
    }
    throw PreconditionError(fmt::format("an outline ends at {}, {}", x, y));
  }

  /// Corners where it turns, alone.
  std::vector<Vec2> TraceFrom(int x, int y, int direction) {
    std::vector<Vec2> outline;
    const int first_x = x, first_y = y, first = direction;
    int before = -1;
    do {
      if (direction != before) outline.emplace_back(x, y);
      EdgesAt(x, y)[static_cast<std::size_t>(direction)] = false;
      x += kStepX[static_cast<std::size_t>(direction)];
      y += kStepY[static_cast<std::size_t>(direction)];
      before = direction;
      direction = NextDirection(x, y, before, first_x == x && first_y == y ? first : -1);
    } while (x != first_x || y != first_y || direction != first);
    // It began within a straight side.
    if (before == first) outline.erase(outline.begin());
    return outline;
  }

  int columns_, rows_;
  std::vector<Edges> edges_;
};

}  // namespace

std::vector<std::vector<Vec2>> ModuleOutlines(const ModuleGrid& grid) {
  Require(grid.dark.size() == static_cast<std::size_t>(grid.columns * grid.rows),
          "a grid of {} x {} has {} modules", grid.columns, grid.rows, grid.dark.size());
  return Tracer(grid).Trace();
}

}  // namespace intaglio::matrix_code
