#include "engrave/discretize/ray_caster.h"

#include <array>
#include <cmath>
#include <optional>

#include "engrave/discretize/candidate_limit.h"

// Ray p is taken as p + (e, e^2) with an infinitesimal e > 0. So it passes above a corner
// if p_v >= corner_v, which never depends on rounding: a row meets a side of a triangle
// if one of its ends is below it and the other is not, and then meets exactly one other
// side as well. Between the two lie the columns that the row has in the triangle. Ray p
// passes to the right of a side from l up to h if
//   E = (p_u - l_u) (h_v - l_v) - (h_u - l_u) (p_v - l_v) >= 0.
// The column where E changes its sign is computed in doubles, and where that is too near
// to a whole number to tell, E itself is, with 113 bits, which hold it exactly.
// Both triangles of an edge decide alike, so what one loses at it the other has.

namespace intaglio::discretize {
namespace {

// The column where E is 0 is computed to better than this.
constexpr double kUnsureColumns = 1e-6;
// Two products and their difference are rounded, by 2^-53 each.
constexpr double kErrorRatio = 0x1p-51;
// Twice the area of a triangle is good to 2^-51 of its sides' products: with no less than
// this share of them, slopes give crossings good to 2^-40 of the triangle's height.
constexpr double kSlenderRatio = 0x1p-11;

using Wide = __float128;

}  // namespace

/// A side of a triangle, from its end in the lower row to that in the higher.
class RayCaster::Side {
 public:
  Side(const RayGrid& grid, const Corner& low, const Corner& high)
      : grid_(grid),
        low_(low),
        du_(high.u - low.u),
        dv_(high.v - low.v),
        column_((low.u - grid.u0_mm) / grid.step_u_mm + 1),
        slope_(du_ / (dv_ * grid.step_u_mm)) {}

  /// The first column to the right of it in a row that meets it.
  std::uint32_t ColumnFrom(double pv) const {
    // One more than the column, so that cutting off is rounding down.
    const double at = column_ + slope_ * (pv - low_.v);
    const auto nearest = static_cast<std::int32_t>(at + 0.5);
    auto column = static_cast<std::int32_t>(at);
    if (std::abs(at - nearest) < kUnsureColumns) {
      column = IsRight(grid_.u0_mm + (nearest - 1) * grid_.step_u_mm, pv) ? nearest - 1
                                                                          : nearest;
    }
    const auto last = static_cast<std::int32_t>(grid_.column_count);
    return static_cast<std::uint32_t>(std::clamp(column, 0, last));
  }

 private:
  bool IsRight(double pu, double pv) const {
    const double first = (pu - low_.u) * dv_, second = du_ * (pv - low_.v);
    const double e = first - second;
    if (std::abs(e) > kErrorRatio * (std::abs(first) + std::abs(second))) return e > 0;
    return Wide(pu - low_.u) * dv_ - Wide(du_) * (pv - low_.v) >= 0;
  }

  const RayGrid& grid_;
  const Corner& low_;
  double du_, dv_, column_, slope_;
};

/// Heights in the plane of a triangle.
class RayCaster::Slope {
 public:
  Slope(const Corner& a, const Corner& b, const Corner& c) : a_(a), b_(b), c_(c) {
    const double bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v;
    const double area = bu * cv - bv * cu;
    slender_ = !(std::abs(area) > kSlenderRatio * (std::abs(bu) + std::abs(cu)) *
                                      (std::abs(bv) + std::abs(cv)));
    const double bw = b.w - a.w, cw = c.w - a.w;
    along_u_ = (bw * cv - bv * cw) / area;
    along_v_ = (bu * cw - bw * cu) / area;
    low_w_ = std::min({a.w, b.w, c.w});
    high_w_ = std::max({a.w, b.w, c.w});
  }

  double At(double pu, double pv) const {
    const double w = slender_ ? ByWeights(pu, pv)
                              : a_.w + along_u_ * (pu - a_.u) + along_v_ * (pv - a_.v);
    return std::clamp(w, low_w_, high_w_);
  }

 private:
  // The E of the three sides are the weights of the opposite corners. None is negative
  // when the area is not, or all are: no digits cancel.
  double ByWeights(double pu, double pv) const {
    const auto weight = [&](const Corner& from, const Corner& to) {
      return static_cast<double>(Wide(to.u - from.u) * (pv - from.v) -
                                 Wide(to.v - from.v) * (pu - from.u));
    };
    const double for_c = weight(a_, b_), for_a = weight(b_, c_), for_b = weight(c_, a_);
    return (for_a * a_.w + for_b * b_.w + for_c * c_.w) / (for_a + for_b + for_c);
  }

  const Corner &a_, &b_, &c_;
  double along_u_, along_v_, low_w_, high_w_;
  bool slender_;
};

RayCaster::RayCaster(const RayGrid& grid, const PointList& vertices) : grid_(grid) {
  corners_.reserve(vertices.size());
  for (const Vec3& v : vertices) {
    Corner corner = {grid.Rounded(v.x()), grid.Rounded(v.y()), v.z(), 0, 0};
    corner.column = grid.ColumnFrom(corner.u);
    corner.row = grid.RowFrom(corner.v);
    corners_.push_back(corner);
  }
}

bool RayCaster::Misses(const mesh::Triangle& t) const {
  const Corner &a = corners_[t[0]], &b = corners_[t[1]], &c = corners_[t[2]];
  return (a.row == b.row && b.row == c.row) ||
         (a.column == b.column && b.column == c.column);
}

Result<RaySpans> RayCaster::Cast(std::span<const mesh::Triangle> triangles) const {
  RaySpans spans;
  spans.column_count_ = grid_.column_count;
  // Rows that begin and end, and so their spans.
  std::vector<std::int64_t> change(grid_.row_count + 1, 0);
  for (const mesh::Triangle& t : triangles) {
    if (Misses(t)) continue;
    const auto [low, high] =
        std::minmax({corners_[t[0]].row, corners_[t[1]].row, corners_[t[2]].row});
    ++change[low];
    --change[high];
  }
  std::int64_t in_row = 0, total = 0;
  spans.row_begin_.reserve(grid_.row_count);
  for (std::uint32_t row = 0; row < grid_.row_count; ++row) {
    spans.row_begin_.push_back(static_cast<std::uint32_t>(total));
    in_row += change[row];
    total += in_row;
    const Status few = CheckCandidateCount(static_cast<double>(total));
    if (!few) return tl::unexpected(few.error());
  }
  spans.row_end_ = spans.row_begin_;
  spans.spans_.resize(static_cast<std::size_t>(total));
  for (const mesh::Triangle& t : triangles) {
    if (!Misses(t)) CastOne(t, spans);
  }
  const Status few = CheckCandidateCount(static_cast<double>(spans.crossing_count_));
  if (!few) return tl::unexpected(few.error());
  return spans;
}

void RayCaster::CastOne(const mesh::Triangle& t, RaySpans& spans) const {
  const Corner *low = &corners_[t[0]], *middle = &corners_[t[1]], *high = &corners_[t[2]];
  if (low->row > middle->row) std::swap(low, middle);
  if (middle->row > high->row) std::swap(middle, high);
  if (low->row > middle->row) std::swap(low, middle);
  const Side whole(grid_, *low, *high), lower(grid_, *low, *middle),
      upper(grid_, *middle, *high);
  std::optional<Slope> slope;  // of many small triangles nobody asks for it
  for (std::uint32_t row = low->row; row < high->row; ++row) {
    const double pv = grid_.V(row);
    const Side& other = row < middle->row ? lower : upper;
    const auto [begin, end] = std::minmax({whole.ColumnFrom(pv), other.ColumnFrom(pv)});
    if (begin == end) continue;
    if (!slope) slope.emplace(corners_[t[0]], corners_[t[1]], corners_[t[2]]);
    RaySpan& span = spans.spans_[spans.row_end_[row]++];
    span.begin = begin;
    span.end = end;
    span.w_mm = slope->At(grid_.U(begin), pv);
    if (end - begin > 1) {
      span.step_w_mm = (slope->At(grid_.U(end - 1), pv) - span.w_mm) / (end - begin - 1);
    }
    spans.crossing_count_ += end - begin;
  }
}

}  // namespace intaglio::discretize
