#include "engrave/galvo/grid_match.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/calibration_grid.h"

namespace intaglio::galvo {
namespace {

constexpr double kReach = 0.25;  // of the pitch, around where a neighbour is expected
// Share of the pitch around the first neighbours: a turn of 20 degrees moves them by
// 0.35.
constexpr double kFirstReach = 0.4;
// Share of the pitch around where the disc that shows the direction may be.
constexpr double kDirectionReach = 0.12;
// Marks in the middle that are tried as the first node: one may be dust.
constexpr std::size_t kFirstMarks = 8;

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

  /// Nodes and their marks, from this one outwards. Each mark is one node at most.
  std::map<Node, std::size_t> From(std::size_t first) {
    nodes_ = {{{0, 0}, first}};
    std::vector<bool> is_node(marks_mm_.size(), false);
    is_node[first] = true;
    std::deque<Node> open = {{0, 0}};
    for (; !open.empty(); open.pop_front()) {
      for (const auto& [dx, dy] : {Node{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        const Node node{open.front().first + dx, open.front().second + dy};
        if (nodes_.contains(node)) continue;
        const auto mark = MarkAt(open.front(), {dx, dy});
        if (!mark || is_node[*mark]) continue;
        is_node[*mark] = true;
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

/// Turns the measured places back by the angle against their commands, by least squares,
/// and what is no node with them.
void TurnUpright(std::vector<GridMark>& marks, std::vector<Vec2>& others_mm) {
  double across = 0, along = 0;
  for (const GridMark& mark : marks) {
    const Vec2 &c = mark.command_mm, &m = mark.measured_mm;
    across += c.x() * m.y() - c.y() * m.x();
    along += c.dot(m);
  }
  const Eigen::Rotation2Dd back(-std::atan2(across, along));
  for (GridMark& mark : marks) mark.measured_mm = back * mark.measured_mm;
  for (Vec2& other_mm : others_mm) other_mm = back * other_mm;
}

Vec2 TurnedByQuarters(const Vec2& v, int quarters) {
  switch ((quarters % 4 + 4) % 4) {
    case 1:
      return {-v.y(), v.x()};
    case 2:
      return -v;
    case 3:
      return {v.y(), -v.x()};
    default:
      return v;
  }
}

/// One of the eight ways in which a piece may lie.
struct Lay {
  int quarters = 0;
  bool mirrored = false;
};

/// By the mark between the nodes that is nearest to where one of them has the disc.
std::optional<Lay> LayOf(const std::vector<Vec2>& others_mm, double pitch_mm) {
  std::optional<Lay> lay;
  double nearest_mm = kDirectionReach * pitch_mm;
  for (const bool mirrored : {false, true}) {
    const Vec2 disc_mm = DirectionDisc(pitch_mm);
    const Vec2 seen_mm = mirrored ? Vec2(-disc_mm.x(), disc_mm.y()) : disc_mm;
    for (int quarters = 0; quarters < 4; ++quarters) {
      for (const Vec2& other_mm : others_mm) {
        const double away_mm = (other_mm - TurnedByQuarters(seen_mm, quarters)).norm();
        if (away_mm >= nearest_mm) continue;
        nearest_mm = away_mm;
        lay = Lay{quarters, mirrored};
      }
    }
  }
  return lay;
}

/// Turns marks back by whole quarters.
Status TurnByDirection(std::vector<Vec2>& others_mm, double pitch_mm, GridMatch& match) {
  TurnUpright(match.marks, others_mm);
  const auto lay = LayOf(others_mm, pitch_mm);
  if (!lay) return {};
  if (lay->mirrored) {
    return Fail(ErrorCode::kInvalidValue,
                "the marks are a mirror image of the grid; measure from the side that "
                "the beam came from, or mirror the picture");
  }
  match.quarter_turns = lay->quarters;
  --match.left_out_count;
  for (GridMark& mark : match.marks) {
    mark.command_mm = TurnedByQuarters(mark.command_mm, -lay->quarters);
    mark.measured_mm = TurnedByQuarters(mark.measured_mm, -lay->quarters);
  }
  return {};
}

Status CheckMeasured(std::span<const Vec2> measured_mm, double pitch_mm) {
  if (measured_mm.empty())
    return Fail(ErrorCode::kMissing, "no mark was measured; check the measurement");
  for (const Vec2& mark : measured_mm) {
    if (mark.allFinite() && mark.cwiseAbs().maxCoeff() < 1e6 * pitch_mm) continue;
    return Fail(ErrorCode::kInvalidValue,
                "a measured mark has a coordinate that is no number, or far off");
  }
  return {};
}

/// Nodes that are connected, by column and row from the lowest.
struct Connected {
  std::map<Node, std::size_t> marks;
  int columns = 0, rows = 0;
};

Connected ConnectedFrom(Grower& grower, std::size_t first) {
  const auto found = grower.From(first);
  Node min{0, 0}, max{0, 0};
  for (const auto& [node, mark] : found) {
    min = {std::min(min.first, node.first), std::min(min.second, node.second)};
    max = {std::max(max.first, node.first), std::max(max.second, node.second)};
  }
  Connected connected{{}, max.first - min.first + 1, max.second - min.second + 1};
  for (const auto& [node, mark] : found)
    connected.marks[{node.first - min.first, node.second - min.second}] = mark;
  return connected;
}

/// From each of the marks that are nearest to the middle, until one has the whole grid;
/// else what is connected to the nearest.
Connected ConnectMarks(std::span<const Vec2> measured_mm, const Vec2& middle_mm,
                       int nodes, double pitch_mm) {
  std::vector<std::size_t> nearest(measured_mm.size());
  std::iota(nearest.begin(), nearest.end(), std::size_t{0});
  const std::size_t tried = std::min(kFirstMarks, nearest.size());
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(tried),
                    nearest.end(), [&](std::size_t a, std::size_t b) {
                      return (measured_mm[a] - middle_mm).norm() <
                             (measured_mm[b] - middle_mm).norm();
                    });
  Grower grower(measured_mm, pitch_mm);
  Connected largest;
  for (std::size_t i = 0; i < tried; ++i) {
    Connected connected = ConnectedFrom(grower, nearest[i]);
    if (connected.columns == nodes && connected.rows == nodes) return connected;
    if (connected.marks.size() > largest.marks.size()) largest = std::move(connected);
  }
  return largest;
}

}  // namespace

Result<GridMatch> MatchGrid(std::span<const Vec2> measured_mm, int nodes,
                            double pitch_mm) {
  INTAGLIO_TRY(CheckCalibrationGrid(nodes, pitch_mm));
  INTAGLIO_TRY(CheckMeasured(measured_mm, pitch_mm));
  Vec2 low = measured_mm[0], high = low;
  for (const Vec2& mark : measured_mm)
    low = low.cwiseMin(mark), high = high.cwiseMax(mark);
  const Vec2 middle_mm = (low + high) / 2;
  const Connected found = ConnectMarks(measured_mm, middle_mm, nodes, pitch_mm);
  if (found.columns != nodes || found.rows != nodes) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("{} and {} of marks are connected, {} are "
                    "expected; check nodes, pitch and the scale of the picture",
                    Counted(static_cast<std::uint64_t>(found.columns), "column"),
                    Counted(static_cast<std::uint64_t>(found.rows), "row"), nodes),
        fmt::format("{} x {}", found.columns, found.rows));
  }
  const int half = (nodes - 1) / 2;
  GridMatch match;
  match.left_out_count = measured_mm.size() - found.marks.size();
  match.not_found_count =
      static_cast<std::size_t>(nodes) * static_cast<std::size_t>(nodes) -
      found.marks.size();
  const auto centre = found.marks.find({half, half});
  const Vec2 origin_mm =
      centre == found.marks.end() ? middle_mm : measured_mm[centre->second];
  std::vector<bool> is_node(measured_mm.size(), false);
  for (const auto& [node, mark] : found.marks) {
    match.marks.push_back({pitch_mm * Vec2(node.first - half, node.second - half),
                           measured_mm[mark] - origin_mm});
    is_node[mark] = true;
  }
  std::vector<Vec2> others_mm;
  for (std::size_t i = 0; i < measured_mm.size(); ++i)
    if (!is_node[i]) others_mm.push_back(measured_mm[i] - origin_mm);
  INTAGLIO_TRY(TurnByDirection(others_mm, pitch_mm, match));
  return match;
}

}  // namespace intaglio::galvo
