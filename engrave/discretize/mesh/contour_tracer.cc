#include "engrave/discretize/mesh/contour_tracer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/mesh/edge_neighbours.h"

// A vertex is above plane k if its rank, the number of planes up to its height, is above
// k. A triangle that has vertices on both sides is entered by one edge and left by
// another; its neighbour across an edge is cut, too, in the very same point. So a contour
// is walked from triangle to triangle until it comes back or meets an open edge. The
// planes are swept upward with the list of the triangles that they cut.

namespace intaglio::discretize {

std::uint32_t PlaneStack::RankOf(double height_mm) const {
  const double near = (height_mm - origin_mm) / pitch_mm - first_step + 1;
  auto rank =
      static_cast<std::uint32_t>(std::clamp(near, 0.0, static_cast<double>(count)));
  while (rank > 0 && HeightOf(rank - 1) > height_mm) --rank;
  while (rank < count && HeightOf(rank) <= height_mm) ++rank;
  return rank;
}

namespace {

constexpr std::uint32_t kNextSide[3] = {1, 2, 0};
constexpr std::uint32_t kSideBefore[3] = {2, 0, 1};

/// The planes that each triangle is cut by: those between its corners.
std::vector<Interval> CutPlanes(const mesh::TriangleMesh& mesh,
                                const std::vector<std::uint32_t>& rank,
                                std::uint64_t& crossing_count) {
  std::vector<Interval> cut;
  cut.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    if (a == b || b == c || c == a) {
      cut.push_back({});
      continue;
    }
    const auto [low, high] = std::minmax({rank[a], rank[b], rank[c]});
    cut.push_back({low, high});
    crossing_count += high - low;
  }
  return cut;
}

}  // namespace

ContourTracer::ContourTracer(const mesh::TriangleMesh& mesh,
                             std::vector<std::uint32_t> rank,
                             const std::vector<std::uint32_t>& neighbours,
                             const Mat3& frame, const PlaneStack& planes)
    : planes_(planes),
      u_axis_(frame.col(0)),
      v_axis_(frame.col(1)),
      level_(frame.col(2) == Vec3::UnitZ()),
      rank_(std::move(rank)),
      cut_planes_({}) {
  const Vec3 normal = frame.col(2);
  corners_.reserve(mesh.vertices.size());
  for (const Vec3& p : mesh.vertices) {
    corners_.push_back({p, p.dot(normal)});
  }
  facets_.resize(mesh.triangles.size());
  const std::uint32_t* across = neighbours.data();
  for (std::size_t t = 0; t < facets_.size(); ++t, across += 3) {
    for (std::size_t side = 0; side < 3; ++side) {
      facets_[t].corner[side] = mesh.triangles[t][side];
      const std::uint32_t n = across[side];
      facets_[t].across[side] = n == mesh::kNoNeighbour ? n : n + n / 3;
    }
  }
  cut_planes_ = IntervalIndex(CutPlanes(mesh, rank_, crossing_count_));
}

/// One call of Trace.
class ContourTracer::Sweep {
 public:
  Sweep(const ContourTracer& tracer, Contours& contours)
      : tracer_(tracer), contours_(contours), seen_(tracer.facets_.size(), 0) {}

  void FindTriangles(const Interval& planes);
  void Cut(std::uint32_t plane);

 private:
  struct Active {
    std::uint32_t triangle;
    std::uint32_t end;  // the first plane above it
  };
  /// The position of a walk: a triangle and the side by which it was entered.
  struct Step {
    std::uint32_t triangle, side;
    std::uint32_t above, below;  // the corners of that side
  };

  void Activate(std::uint32_t plane);
  Step StepInto(std::uint32_t triangle, std::uint32_t plane) const;
  Vec3 CrossingOf(const Step& step) const;
  std::uint32_t Walk(Step& step);
  std::size_t Foremost() const;
  void Keep(bool closed, std::uint32_t plane);

  const ContourTracer& tracer_;
  Contours& contours_;
  std::vector<IndexedInterval> coming_;  // by their first plane
  std::size_t next_ = 0;                 // of them
  std::vector<Active> active_;           // the triangles that the plane cuts
  std::vector<std::uint8_t> seen_;       // the newest stamp of each triangle
  std::uint8_t stamp_ = 0;
  std::uint32_t plane_ = 0;
  double height_mm_ = 0;
  PointList walked_;  // room for one contour
  std::size_t walked_count_ = 0;
};

// By counting sort; those of the same first plane in the order of their index. The order
// is the same for every range, and so are the contours' seeds.
void ContourTracer::Sweep::FindTriangles(const Interval& planes) {
  std::vector<IndexedInterval> found;
  tracer_.cut_planes_.Find(planes, found);
  if (found.empty()) return;
  std::uint32_t lowest = planes.end;
  for (const IndexedInterval& f : found) lowest = std::min(lowest, f.interval.first);
  std::vector<std::uint32_t> at(planes.end - lowest + 1, 0);
  for (const IndexedInterval& f : found) ++at[f.interval.first - lowest + 1];
  for (std::size_t i = 1; i < at.size(); ++i) at[i] += at[i - 1];
  coming_.resize(found.size());
  for (const IndexedInterval& f : found) coming_[at[f.interval.first - lowest]++] = f;
}

void ContourTracer::Sweep::Activate(std::uint32_t plane) {
  std::size_t kept = 0;
  for (const Active& a : active_) {
    active_[kept] = a;
    kept += a.end > plane ? 1 : 0;
  }
  active_.resize(kept);
  for (; next_ < coming_.size() && coming_[next_].interval.first <= plane; ++next_) {
    const IndexedInterval& c = coming_[next_];
    if (c.interval.end > plane) active_.push_back({c.item, c.interval.end});
  }
  if (walked_.size() < active_.size() + 1) walked_.resize(2 * active_.size() + 1);
}

// By the side that passes from above to below, in the sense of the triangle.
ContourTracer::Sweep::Step ContourTracer::Sweep::StepInto(std::uint32_t triangle,
                                                          std::uint32_t plane) const {
  const std::uint32_t* corner = tracer_.facets_[triangle].corner;
  const auto above = [&](std::uint32_t side) {
    return tracer_.rank_[corner[side]] > plane;
  };
  std::uint32_t side = 0;
  while (!above(side) || above(kNextSide[side])) ++side;
  return {triangle, side, corner[side], corner[kNextSide[side]]};
}

Vec3 ContourTracer::Sweep::CrossingOf(const Step& step) const {
  const Corner& low = tracer_.corners_[step.below];
  const Corner& high = tracer_.corners_[step.above];
  const double part = (height_mm_ - low.height_mm) / (high.height_mm - low.height_mm);
  Vec3 p = low.p_mm + part * (high.p_mm - low.p_mm);
  if (tracer_.level_) p.z() = height_mm_;
  return p;
}

// Walks through the triangles until it is back in the first one or has left the last by
// an open edge. Returns that edge, or kNoNeighbour. The step is the last one.
std::uint32_t ContourTracer::Sweep::Walk(Step& step) {
  const std::uint32_t begin = step.triangle;
  const Facet* facets = tracer_.facets_.data();
  const std::uint32_t* rank = tracer_.rank_.data();
  for (;;) {
    seen_[step.triangle] = stamp_;
    const Facet& facet = facets[step.triangle];
    const std::uint32_t third = facet.corner[kSideBefore[step.side]];
    const bool third_above = rank[third] > plane_;
    const bool first_above = facet.corner[step.side] == step.above;
    // It leaves by the side that joins the third corner to the one across the plane.
    const std::uint32_t out =
        first_above != third_above ? kSideBefore[step.side] : kNextSide[step.side];
    step.above = third_above ? third : step.above;
    step.below = third_above ? step.below : third;
    walked_[walked_count_++] = CrossingOf(step);
    const std::uint32_t across = facet.across[out];
    if (across == mesh::kNoNeighbour) {
      step.side = out;
      return 4 * step.triangle + out;
    }
    step.triangle = across >> 2;
    step.side = across & 3;
    if (step.triangle == begin) return mesh::kNoNeighbour;
  }
}

std::size_t ContourTracer::Sweep::Foremost() const {
  std::size_t first = 0;
  double u_mm = walked_[0].dot(tracer_.u_axis_);
  for (std::size_t i = 1; i < walked_count_; ++i) {
    const double ahead_mm = walked_[i].dot(tracer_.u_axis_) - u_mm;
    if (ahead_mm < 0) continue;
    if (ahead_mm == 0 && (walked_[i] - walked_[first]).dot(tracer_.v_axis_) <= 0) {
      continue;
    }
    first = i;
    u_mm = walked_[i].dot(tracer_.u_axis_);
  }
  return first;
}

// Appends the walked contour, with its arc.
void ContourTracer::Sweep::Keep(bool closed, std::uint32_t plane) {
  const std::size_t n = walked_count_;
  const std::size_t first = closed ? Foremost() : 0;
  const std::size_t begin = contours_.points_mm.size(), count = n + (closed ? 1 : 0);
  contours_.points_mm.resize(begin + count);
  contours_.arc_mm.resize(begin + count);
  Vec3* points = contours_.points_mm.data() + begin;
  points = std::copy(walked_.data() + first, walked_.data() + n, points);
  points = std::copy(walked_.data(), walked_.data() + first, points);
  if (closed) *points = walked_[first];
  points = contours_.points_mm.data() + begin;
  double* arc_mm = contours_.arc_mm.data() + begin;
  double length_mm = 0;
  arc_mm[0] = 0;
  for (std::size_t i = 1; i < count; ++i) {
    length_mm += (points[i] - points[i - 1]).norm();
    arc_mm[i] = length_mm;
  }
  contours_.list.push_back({begin, begin + count, plane, closed});
}

void ContourTracer::Sweep::Cut(std::uint32_t plane) {
  plane_ = plane;
  height_mm_ = tracer_.planes_.HeightOf(plane);
  if (++stamp_ == 0) {
    std::fill(seen_.begin(), seen_.end(), std::uint8_t{0});
    stamp_ = 1;
  }
  Activate(plane);
  for (const Active& a : active_) {
    if (seen_[a.triangle] == stamp_) continue;
    Step step = StepInto(a.triangle, plane);
    walked_count_ = 0;
    const std::uint32_t open = Walk(step);
    if (open != mesh::kNoNeighbour) {
      // It met an open edge: the whole contour lies between that and the other open edge.
      walked_[0] = CrossingOf(step);
      walked_count_ = 1;
      Walk(step);
      std::reverse(walked_.begin(),
                   walked_.begin() + static_cast<std::ptrdiff_t>(walked_count_));
    }
    Keep(open == mesh::kNoNeighbour, plane);
  }
}

void ContourTracer::Trace(const Interval& planes, Contours& contours,
                          const std::function<bool(std::uint32_t)>& visit) const {
  if (planes.first >= planes.end) return;
  Sweep sweep(*this, contours);
  sweep.FindTriangles(planes);
  for (std::uint32_t plane = planes.first; plane < planes.end; ++plane) {
    sweep.Cut(plane);
    if (!visit(plane)) return;
  }
}

}  // namespace intaglio::discretize
