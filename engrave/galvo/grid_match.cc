#include "engrave/galvo/grid_match.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <optional>

#include "engrave/core/try.h"

namespace intaglio::galvo {
namespace {

constexpr double kReach = 0.25;  // of the pitch, around where a neighbour is expected
// Of the pitch, around the first neighbours: a turn of 20 degrees moves them by 0.35.
constexpr double kFirstReach = 0.4;

using Node = std::pair<int, int>;

/// Measured marks by cells of one pitch.
class MarkCells {
 public:
  MarkCells(std::span<const Vec2> marks_mm, double cell_mm)
      : marks_mm_(marks_mm), cell_mm_(cell_mm) {
    for (std::size_t i = 0; i < marks_mm.size(); ++i)
      cells_[CellOf(marks_mm[i])].push_back(i);
  }

  std::optional<std::size_t> Nearest(const Vec2& at_mm, double reach_mm) const {
    std::optional<std::size_t> nearest;
    const auto [x, y] = CellOf(at_mm);
    for (int j = y - 1; j <= y + 1; ++j) {
      for (int i = x - 1; i <= x + 1; ++i) {
        const auto cell = cells_.find({i, j});
        if (cell == cells_.end()) continue;
        for (const std::size_t mark : cell->second) {
          const double distance_mm = (marks_mm_[mark] - at_mm).norm();
          if (distance_mm >= reach_mm) continue;
          reach_mm = distance_mm;
          nearest = mark;
        }
      }
    }
    return nearest;
  }

 private:
  Node CellOf(const Vec2& at_mm) const {
    return {static_cast<int>(std::floor(at_mm.x() / cell_mm_)),
            static_cast<int>(std::floor(at_mm.y() / cell_mm_))};
  }

  std::span<const Vec2> marks_mm_;
  double cell_mm_;
  std::map<Node, std::vector<std::size_t>> cells_;
};

class Grower {
 public:
  Grower(std::span<const Vec2> marks_mm, double pitch_mm)
      : marks_mm_(marks_mm), pitch_mm_(pitch_mm), cells_(marks_mm, pitch_mm) {}

  /// Nodes and their marks, from this one outwards.
  std::map<Node, std::size_t> From(std::size_t first) {
    nodes_ = {{{0, 0}, first}};
    std::deque<Node> open = {{0, 0}};
    for (; !open.empty(); open.pop_front()) {
      for (const auto& [dx, dy] : {Node{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const Node node{open.front().first + dx, open.front().second + dy};
        if (nodes_.contains(node)) continue;
        const auto mark = MarkAt(open.front(), {dx, dy});
        if (!mark) continue;
        nodes_[node] = *mark;
        open.push_back(node);
      }
    }
    return nodes_;
  }

 private:
  std::optional<Vec2> PlaceOf(int x, int y) const {
    const auto found = nodes_.find({x, y});
    if (found == nodes_.end()) return std::nullopt;
    return marks_mm_[found->second];
  }

  /// The way of a step there: as the opposite one, else as a parallel one beside it, else
  /// by a step across, turned, else one pitch.
  std::pair<Vec2, double> StepFrom(const Node& at, const Node& by) const {
    const auto [x, y] = at;
    const auto [dx, dy] = by;
    const Vec2 here = *PlaceOf(x, y);
    if (const auto back = PlaceOf(x - dx, y - dy)) return {here - *back, kReach};
    for (const int side : {1, -1}) {
      const auto beside = PlaceOf(x + side * dy, y + side * dx);
      const auto ahead = PlaceOf(x + side * dy + dx, y + side * dx + dy);
      if (beside && ahead) return {*ahead - *beside, kReach};
    }
    for (const int side : {1, -1}) {
      const auto beside = PlaceOf(x + side * dy, y + side * dx);
      if (!beside) continue;
      const Vec2 across = side * (*beside - here);  // along (dy, dx)
      return {dx != 0 ? Vec2(dx * Vec2(across.y(), -across.x()))
                      : Vec2(dy * Vec2(-across.y(), across.x())),
              kReach};
    }
    return {pitch_mm_ * Vec2(dx, dy), kFirstReach};
  }

  std::optional<std::size_t> MarkAt(const Node& from, const Node& by) const {
    const auto [step_mm, reach] = StepFrom(from, by);
    return cells_.Nearest(*PlaceOf(from.first, from.second) + step_mm, reach * pitch_mm_);
  }

  std::span<const Vec2> marks_mm_;
  double pitch_mm_;
  MarkCells cells_;
  std::map<Node, std::size_t> nodes_;
};

/// Turns the measured places back by the angle against their commands, by least squares.
void TurnUpright(std::vector<GridMark>& marks) {
  double across = 0, along = 0;
  for (const GridMark& mark : marks) {
    const Vec2 &c = mark.command_mm, &m = mark.measured_mm;
    across += c.x() * m.y() - c.y() * m.x();
    along += c.dot(m);
  }
  const Eigen::Rotation2Dd back(-std::atan2(across, along));
  for (GridMark& mark : marks) mark.measured_mm = back * mark.measured_mm;
}

Status CheckGridNumbers(std::span<const Vec2> measured_mm, int nodes, double pitch_mm) {
  if (nodes < 5 || nodes > 65 || nodes % 2 == 0) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a grid of {} nodes a side; give an odd number of 5..65", nodes),
        fmt::format("{}", nodes));
  }
  if (!(pitch_mm > 0) || !std::isfinite(pitch_mm))
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a pitch of {} mm; give more than 0", pitch_mm));
  if (measured_mm.empty())
    return Fail(ErrorCode::kMissing, "no mark was measured; check the measurement");
  for (const Vec2& mark : measured_mm) {
    if (mark.allFinite() && mark.cwiseAbs().maxCoeff() < 1e6 * pitch_mm) continue;
    return Fail(ErrorCode::kInvalidValue,
                "a measured mark has a coordinate that is no number, or far off");
  }
  return {};
}

}  // namespace

Result<GridMatch> MatchGrid(std::span<const Vec2> measured_mm, int nodes,
                            double pitch_mm) {
  INTAGLIO_TRY(CheckGridNumbers(measured_mm, nodes, pitch_mm));
  Vec2 low = measured_mm[0], high = low;
  for (const Vec2& mark : measured_mm)
    low = low.cwiseMin(mark), high = high.cwiseMax(mark);
  const Vec2 middle_mm = (low + high) / 2;
  const auto first = std::min_element(
      measured_mm.begin(), measured_mm.end(), [&](const Vec2& a, const Vec2& b) {
        return (a - middle_mm).norm() < (b - middle_mm).norm();
      });
  const auto found = Grower(measured_mm, pitch_mm)
                         .From(static_cast<std::size_t>(first - measured_mm.begin()));
  Node min{0, 0}, max{0, 0};
  for (const auto& [node, mark] : found) {
    min = {std::min(min.first, node.first), std::min(min.second, node.second)};
    max = {std::max(max.first, node.first), std::max(max.second, node.second)};
  }
  const int columns = max.first - min.first + 1, rows = max.second - min.second + 1;
  if (columns != nodes || rows != nodes) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} columns and {} rows of marks are connected, {} are "
                            "expected; check nodes, pitch and the scale of the picture",
                            columns, rows, nodes),
                fmt::format("{} x {}", columns, rows));
  }
  const int half = (nodes - 1) / 2;
  GridMatch match;
  match.left_out_count = measured_mm.size() - found.size();
  match.not_found_count =
      static_cast<std::size_t>(nodes) * static_cast<std::size_t>(nodes) - found.size();
  const auto centre = found.find({min.first + half, min.second + half});
  const Vec2 origin_mm = centre == found.end() ? middle_mm : measured_mm[centre->second];
  for (const auto& [node, mark] : found) {
    match.marks.push_back(
        {pitch_mm * Vec2(node.first - min.first - half, node.second - min.second - half),
         measured_mm[mark] - origin_mm});
  }
  TurnUpright(match.marks);
  return match;
}

}  // namespace intaglio::galvo
