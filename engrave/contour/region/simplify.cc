#include "engrave/contour/region/simplify.h"

#include <algorithm>
#include <cmath>

#include "engrave/contour/region/bays.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kNoChord_mm = 1e-6;
// A stage is at most as wide as so many edges reach, and at least this part of the whole.
constexpr std::size_t kStageEdges = 16;
constexpr double kMinStage = 1.0 / 64;
constexpr double kMinStage_mm = 0.002;
// Of the tolerance, what the outline is simplified by before and after its bays are cut
// off, and by that.
constexpr double kFirstShare = 0.125;
constexpr double kBayShare = 0.25;
// The pairs of so many edges are few, whatever their lengths.
constexpr std::size_t kFewEdges = 256;

double DistanceToLine(const Vec2& begin, const Vec2& along, const Vec2& place) {
  const double way = std::clamp(along.dot(place - begin) / along.squaredNorm(), 0.0, 1.0);
  return (begin + way * along - place).norm();
}

/// The same loop in lines from its own points, those of arcs within tolerance_mm.
Edges InLines(const Edges& loop, double tolerance_mm) {
  Edges lines;
  for (const Edge& edge : loop) {
    // The chord of an angle a is radius (1 - cos(a / 2)) from its arc.
    const double cosine = 1 - tolerance_mm / std::max(edge.radius_mm, tolerance_mm);
    const double chords = std::ceil(std::abs(edge.sweep_rad) / (2 * std::acos(cosine)));
    const int count = edge.is_arc() ? std::max(static_cast<int>(chords), 1) : 1;
    Vec2 begin = edge.begin_mm;
    for (int k = 1; k <= count; ++k) {
      const Vec2 end =
          k == count ? edge.end_mm : PointAt(edge, k * edge.length_mm / count);
      if ((end - begin).norm() > kNoChord_mm || k == count)
        lines.push_back(MakeLine(begin, end));
      begin = lines.back().end_mm;
    }
  }
  return lines;
}

/// Whether the edges first .. last are within the tolerance of the line from the begin of
/// the first to the end of the last. That line is within it of them as well: they go from
/// one of its ends to the other.
bool IsLine(const Edges& loop, std::size_t first, std::size_t last, double tolerance_mm) {
  const Vec2& begin = loop[first].begin_mm;
  const Vec2 along = loop[last].end_mm - begin;
  if (along.norm() < kNoChord_mm) return false;
  for (std::size_t k = first; k < last; ++k) {
    if (DistanceToLine(begin, along, loop[k].end_mm) > tolerance_mm) return false;
  }
  return true;
}

/// The last edge of the run from `first` on: by twice as many edges while they are a
/// line, then by halves. So the edges that are looked at are some of the run, times its
/// logarithm.
std::size_t EndOfRun(const Edges& loop, std::size_t first, double tolerance_mm) {
  std::size_t is_line = first;
  std::size_t is_none = loop.size();
  for (std::size_t count = 2; first + count <= loop.size(); count *= 2) {
    if (!IsLine(loop, first, first + count - 1, tolerance_mm)) {
      is_none = first + count - 1;
      break;
    }
    is_line = first + count - 1;
  }
  while (is_none - is_line > 1) {
    const std::size_t middle = is_line + (is_none - is_line) / 2;
    (IsLine(loop, first, middle, tolerance_mm) ? is_line : is_none) = middle;
  }
  return is_line;
}

Edges SimplifiedLoop(const Edges& edges, double whole_mm) {
  const double tolerance_mm = whole_mm / 2;  // half of it is that of arcs
  const Edges loop = InLines(edges, tolerance_mm);
  Edges simple;
  for (std::size_t first = 0; first < loop.size();) {
    const std::size_t last = EndOfRun(loop, first, tolerance_mm);
    simple.push_back(last == first ? loop[first]
                                   : MakeLine(loop[first].begin_mm, loop[last].end_mm));
    first = last + 1;
  }
  return simple;
}

std::size_t EdgeCount(const Region& region) {
  std::size_t count = 0;
  for (const Edges& loop : region.loops) count += loop.size();
  return count;
}

/// An inset by it has few pairs of edges, also where an outline goes to and fro.
double Stage_mm(const Region& region) {
  double chords_mm = 0;
  for (const Edges& loop : region.loops) {
    const std::size_t count = std::min(kStageEdges, (loop.size() + 1) / 2);
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Edge& last = loop[(k + count - 1) % loop.size()];
      chords_mm += (last.end_mm - loop[k].begin_mm).norm();
    }
  }
  return chords_mm / static_cast<double>(std::max<std::size_t>(EdgeCount(region), 1));
}

/// An inset by stage_mm of what is left, or by less where its proof fails or too many
/// edges meet.
Result<Region> Stage(const Region& region, double left_mm, double& stage_mm) {
  const double whole_mm = stage_mm;
  auto inset = Inset(region, whole_mm);
  for (const double part : {0.9, 0.7, 0.5, 0.1}) {
    if (inset || (inset.error().code != ErrorCode::kUnsupported &&
                  inset.error().code != ErrorCode::kTooLarge))
      break;
    if (left_mm - part * whole_mm < kMinStage_mm || part * whole_mm < kMinStage_mm) break;
    auto shorter = Inset(region, part * whole_mm);
    if (!shorter) continue;
    stage_mm = part * whole_mm;
    inset = std::move(shorter);
  }
  return inset;
}

}  // namespace

Region Simplified(const Region& region, double tolerance_mm) {
  Region simple;
  for (const Edges& loop : region.loops)
    simple.loops.push_back(SimplifiedLoop(loop, tolerance_mm));
  return simple;
}

bool HasManyEdges(const Region& region) { return EdgeCount(region) > kFewEdges; }

Result<Region> InsetInStages(const Region& region, double distance_mm,
                             double tolerance_mm) {
  const double neck_mm =
      std::min(std::sqrt(8 * distance_mm * kBayShare * tolerance_mm), distance_mm / 2);
  const Region lines = Simplified(region, kFirstShare * tolerance_mm);
  Region inset = Simplified(WithoutNarrowBays(lines, distance_mm, neck_mm),
                            kFirstShare * tolerance_mm);
  double stage_mm = std::max({Stage_mm(inset), kMinStage * distance_mm, kMinStage_mm});
  // Stages double, and have equal shares of the tolerance: smaller ones would leave edges
  // too short for the union of their discs.
  const double stages = 1 + std::ceil(std::max(std::log2(distance_mm / stage_mm), 0.0));
  const double share_mm = (1 - 2 * kFirstShare - kBayShare) / stages * tolerance_mm;
  double left_mm = distance_mm;
  while (left_mm > 0 && !inset.loops.empty()) {
    // No stage is left that is far shorter than the others.
    if (stage_mm > 0.75 * left_mm) stage_mm = left_mm;
    double made_mm = stage_mm;
    inset = Simplified(INTAGLIO_TRY(Stage(inset, left_mm, made_mm)), share_mm);
    left_mm -= made_mm;
    stage_mm *= 2;
  }
  return inset;
}

}  // namespace intaglio::contour
