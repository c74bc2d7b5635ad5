#include "engrave/discretize/mesh/ray_sweep.h"

#include <algorithm>
#include <cmath>

// Ray p is treated as p + (e, e^2) with an infinitesimal e > 0. So it passes above a
// corner if p_v >= corner_v, which never depends on rounding: a row meets a side of a
// triangle if one of its ends is below it and the other is not, and then meets exactly
// one other side as well. Between the two lie the columns of the row that are in the
// triangle. Ray p passes to the right of a side from l up to h if
//   E = (p_u - l_u) (h_v - l_v) - (h_u - l_u) (p_v - l_v) >= 0.
// The column where E changes its sign is computed in doubles, and where that is too near
// to a whole number to decide, E itself is computed with 113 bits, which hold it exactly.
// Both triangles of an edge decide alike, so no crossing at an edge is lost or counted
// twice.
//
// The crossings of a row with a triangle are computed without unpredictable branches: one
// misprediction costs as much as all the rest.

namespace intaglio::discretize {
namespace {

// The column where E is 0 is computed to better than this.
constexpr double kUnsureColumns = 1e-6;
// Two products and their difference are rounded, by 2^-53 each.
constexpr double kErrorRatio = 0x1p-51;
// Twice the area of a triangle is good to 2^-51 of its sides' products: with no less than
// this share of them, slopes give crossings good to 2^-40 of the triangle's height.
constexpr double kSlenderRatio = 0x1p-11;
constexpr auto kNoRow = static_cast<std::uint32_t>(-1);
// The corners of triangles are prefetched this many triangles ahead, the triangles
// themselves twice as many.
constexpr std::size_t kFetchAhead = 8;

using Wide = __float128;

bool Misses(const RayCorner& a, const RayCorner& b, const RayCorner& c) {
  return (a.row == b.row && b.row == c.row) ||
         (a.column == b.column && b.column == c.column);
}

/// Whether the ray passes to the right of the side.
bool IsRight(const RayCorner& low, const RayCorner& high, double pu, double pv) {
  const double du = high.u - low.u, dv = high.v - low.v;
  const double first = (pu - low.u) * dv, second = du * (pv - low.v);
  const double e = first - second;
  if (std::abs(e) > kErrorRatio * (std::abs(first) + std::abs(second))) return e > 0;
  return Wide(pu - low.u) * dv - Wide(du) * (pv - low.v) >= 0;
}

}  // namespace

/// A triangle's corners by rows.
struct RaySweep::Corners {
  const RayCorner &low, &middle, &high;
};

/// A side of a triangle as a line: the column where a row meets it.
struct RaySweep::Line {
  Line(const RayGrid& grid, double columns_per_mm, const RayCorner& low,
       const RayCorner& high)
      : v(low.v),
        column((low.u - grid.u0_mm) * columns_per_mm + 1),
        slope((high.u - low.u) * columns_per_mm / (high.v - low.v)) {}

  /// One more than the column, so that truncation rounds down.
  double At(double pv) const { return column + slope * (pv - v); }

  double v, column, slope;
};

/// A triangle that the row meets: lines from the lowest corner to the highest, to the
/// middle one and from that on, and the slope of its plane from the lowest corner on.
struct alignas(64) RaySweep::Met {
  Line whole, parts[2];
  double u, w, along_u, along_v;
  std::uint32_t middle_row, end_row, triangle;
  bool slender;
};

RaySweep::RaySweep(const RayGrid& grid, std::span<const RayCorner> corners,
                   std::span<const mesh::Triangle> triangles)
    : grid_(grid),
      columns_per_mm_(1 / grid.step_u_mm),
      corners_(corners),
      triangles_(triangles) {
  std::vector<std::uint32_t> lowest;
  lowest.reserve(triangles.size());
  // By counting sort: until all are stored, the next entry holds the beginning of a row.
  first_.assign(grid.row_count + 2, 0);
  for (const mesh::Triangle& t : triangles) {
    const RayCorner &a = corners[t[0]], &b = corners[t[1]], &c = corners[t[2]];
    if (Misses(a, b, c)) {
      lowest.push_back(kNoRow);
      continue;
    }
    const std::uint32_t low = std::min({a.row, b.row, c.row});
    reached_row_count_ += std::max({a.row, b.row, c.row}) - low;
    ++first_[low + 2];
    lowest.push_back(low);
  }
  for (std::size_t row = 2; row < first_.size(); ++row) first_[row] += first_[row - 1];
  by_row_.resize(first_.back());
  for (std::uint32_t i = 0; i < lowest.size(); ++i) {
    if (lowest[i] != kNoRow) by_row_[first_[lowest[i] + 1]++] = i;
  }
}

RaySweep::~RaySweep() = default;

RaySweep::Corners RaySweep::CornersOf(std::uint32_t triangle) const {
  const mesh::Triangle& t = triangles_[triangle];
  // Rows, with the index of the corner in the two lowest bits.
  const auto key = [&](std::uint64_t i) {
    return std::uint64_t{corners_[t[i]].row} << 2 | i;
  };
  const std::uint64_t a = key(0), b = key(1), c = key(2);
  const std::uint64_t low = std::min({a, b, c}), high = std::max({a, b, c});
  const std::uint64_t middle = a ^ b ^ c ^ low ^ high;
  return {corners_[t[low & 3]], corners_[t[middle & 3]], corners_[t[high & 3]]};
}

void RaySweep::Meet(std::uint32_t triangle) {
  const auto& [a, b, c] = CornersOf(triangle);
  const double bu = b.u - a.u, bv = b.v - a.v, cu = c.u - a.u, cv = c.v - a.v;
  const double bw = b.w - a.w, cw = c.w - a.w;
  const double area = bu * cv - bv * cu, share = 1 / area;
  const bool slender = !(std::abs(area) > kSlenderRatio * (std::abs(bu) + std::abs(cu)) *
                                              (std::abs(bv) + std::abs(cv)));
  const Met met = {
      .whole = Line(grid_, columns_per_mm_, a, c),
      .parts = {Line(grid_, columns_per_mm_, a, b), Line(grid_, columns_per_mm_, b, c)},
      .u = a.u,
      .w = a.w,
      .along_u = (bw * cv - bv * cw) * share,
      .along_v = (bu * cw - bw * cu) * share,
      .middle_row = b.row,
      .end_row = c.row,
      .triangle = triangle,
      .slender = slender};
  if (free_.empty()) {
    in_row_.push_back(static_cast<std::uint32_t>(met_.size()));
    met_.push_back(met);
  } else {
    in_row_.push_back(free_.back());
    met_[free_.back()] = met;
    free_.pop_back();
  }
}

void RaySweep::MeetTrianglesOf(std::uint32_t row) {
  for (std::size_t i = first_[row]; i < first_[row + 1]; ++i) {
    if (i + 2 * kFetchAhead < by_row_.size()) {
      __builtin_prefetch(&triangles_[by_row_[i + 2 * kFetchAhead]]);
      for (const std::uint32_t corner : triangles_[by_row_[i + kFetchAhead]]) {
        __builtin_prefetch(&corners_[corner]);
      }
    }
    Meet(by_row_[i]);
  }
}

bool RaySweep::Next() {
  for (; next_row_ < grid_.row_count; ++next_row_) {
    MeetTrianglesOf(next_row_);
    if (in_row_.empty()) continue;
    row_ = next_row_++;
    SetSpans();
    return true;
  }
  return false;
}

inline std::uint32_t RaySweep::ColumnFrom(double at, const Met& met, SideOf side,
                                          double pv) const {
  auto column = static_cast<std::int32_t>(at);
  if (std::abs(at - column - 0.5) > 0.5 - kUnsureColumns) [[unlikely]] {
    column = ExactColumn(at, met, side, pv);
  }
  const auto last = static_cast<std::int32_t>(grid_.column_count);
  return static_cast<std::uint32_t>(std::clamp(column, 0, last));
}

void RaySweep::SetSpans() {
  const double pv = grid_.V(row_);
  spans_.resize(std::max(spans_.size(), in_row_.size()));
  std::size_t span_count = 0, going_on = 0, free = free_.size();
  free_.resize(free + in_row_.size());
  for (const std::uint32_t i : in_row_) {
    const Met& met = met_[i];
    const bool upper = row_ >= met.middle_row;
    const std::uint32_t one = ColumnFrom(met.whole.At(pv), met, kWhole, pv);
    const std::uint32_t other =
        ColumnFrom(met.parts[upper ? 1 : 0].At(pv), met, upper ? kUpper : kLower, pv);
    RaySpan& span = spans_[span_count];
    const std::uint32_t change = one > other ? one ^ other : 0;
    span.begin = one ^ change;
    span.end = other ^ change;
    span.w_mm = met.w + met.along_u * (grid_.U(span.begin) - met.u) +
                met.along_v * (pv - met.whole.v);
    span.step_w_mm = met.along_u * grid_.step_u_mm;
    if (met.slender) [[unlikely]]
      SetSlender(met, pv, span);
    span_count += span.begin < span.end ? 1 : 0;
    const bool ends = met.end_row == next_row_;
    in_row_[going_on] = free_[free] = i;
    going_on += ends ? 0 : 1;
    free += ends ? 1 : 0;
  }
  in_row_.resize(going_on);
  free_.resize(free);
  span_count_ = span_count;
}

[[gnu::noinline]] std::int32_t RaySweep::ExactColumn(double at, const Met& met,
                                                     SideOf side, double pv) const {
  const auto nearest = static_cast<std::int32_t>(at + 0.5);
  const double pu = grid_.u0_mm + (nearest - 1) * grid_.step_u_mm;
  const Corners c = CornersOf(met.triangle);
  const bool right = IsRight(side == kUpper ? c.middle : c.low,
                             side == kLower ? c.middle : c.high, pu, pv);
  return right ? nearest - 1 : nearest;
}

// The E of the three sides are the weights of the opposite corners. All have the sign of
// the area, so no digits cancel.
[[gnu::noinline]] void RaySweep::SetSlender(const Met& met, double pv,
                                            RaySpan& span) const {
  if (span.begin == span.end) return;
  const Corners corners = CornersOf(met.triangle);
  const RayCorner &a = corners.low, &b = corners.middle, &c = corners.high;
  const auto height = [&](std::uint32_t column) {
    const double pu = grid_.U(column);
    const auto weight = [&](const RayCorner& from, const RayCorner& to) {
      return static_cast<double>(Wide(to.u - from.u) * (pv - from.v) -
                                 Wide(to.v - from.v) * (pu - from.u));
    };
    const double for_c = weight(a, b), for_a = weight(b, c), for_b = weight(c, a);
    const double w = (for_a * a.w + for_b * b.w + for_c * c.w) / (for_a + for_b + for_c);
    return std::clamp(w, std::min({a.w, b.w, c.w}), std::max({a.w, b.w, c.w}));
  };
  span.w_mm = height(span.begin);
  const std::uint32_t steps = span.end - span.begin - 1;
  span.step_w_mm = steps == 0 ? 0 : (height(span.end - 1) - span.w_mm) / steps;
}

}  // namespace intaglio::discretize
