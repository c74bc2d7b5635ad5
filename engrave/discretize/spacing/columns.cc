#include "engrave/discretize/spacing/columns.h"

namespace intaglio::discretize {
namespace {

// So that a tiny spacing in a large block does not use more memory, and time to clear it,
// than the points justify.
constexpr double kColumnsPerPoint = 0.5, kMinColumns = 512;
// A coordinate's last place in single precision, 2^-24, times: two points, three axes,
// the squares and their sums.
constexpr double kSingleError = 16 * 0x1p-24;
constexpr float kVeryFar = 1e15F, kVeryFarSquare = kVeryFar * kVeryFar;

// Lanes as GCC and Clang have them on every processor.
using Four [[gnu::vector_size(16), gnu::may_alias]] = float;
using Eight [[gnu::vector_size(32), gnu::may_alias]] = float;

double SideOf(const Vec3& size_mm, double reach_mm, std::size_t point_count) {
  const double largest =
      std::max(kMinColumns, kColumnsPerPoint * static_cast<double>(point_count));
  // Two points nearer than a reach differ by less than half a column's width even after
  // the rounding of their column numbers.
  double side_mm = 2 * reach_mm * kReachAllowance;
  while ((size_mm.x() / side_mm + 3) * (size_mm.y() / side_mm + 3) > largest) {
    side_mm *= 1.25;
  }
  return side_mm;
}

float SmallestOf(float a, float b, float c, float d) {
  return std::min(std::min(a, b), std::min(c, d));
}

}  // namespace

Columns::Columns(const Box3& bounds, double reach_mm, double height_ratio,
                 std::size_t point_count, const Vec3& rise)
    : origin_(bounds.min_mm),
      rise_(rise),
      flatten_(1 / height_ratio),
      side_mm_(SideOf(bounds.size_mm(), reach_mm, point_count)),
      per_side_(1 / side_mm_),
      error_mm_(kSingleError * std::max({2 * side_mm_, bounds.size_mm().z() * flatten_,
                                         rise.dot(bounds.size_mm()) * flatten_})),
      width_(static_cast<std::size_t>(bounds.size_mm().x() * per_side_) + 3),
      depth_(static_cast<std::size_t>(bounds.size_mm().y() * per_side_) + 3) {
  Newest none{{}, {}, {}, -kVeryFar, kNone, 0};
  std::fill_n(none.x, kNewest, -kVeryFar);
  std::fill_n(none.y, kNewest, -kVeryFar);
  std::fill_n(none.z, kNewest, -kVeryFar);
  newest_.assign(width_ * depth_, none);
}

void Columns::Add(const Vec3& p_mm, float spacing_mm) {
  const Vec3 d = p_mm - origin_;
  const auto i = static_cast<std::size_t>(d.x() * per_side_);
  const auto j = static_cast<std::size_t>(d.y() * per_side_);
  Newest& newest = newest_[(j + 1) * width_ + i + 1];
  entries_.push_back({p_mm, newest.entry, spacing_mm});
  newest.entry = static_cast<std::uint32_t>(entries_.size() - 1);
  const std::uint32_t lane = newest.next_lane;
  newest.x[lane] = static_cast<float>(d.x() - static_cast<double>(i) * side_mm_);
  newest.y[lane] = static_cast<float>(d.y() - static_cast<double>(j) * side_mm_);
  newest.z[lane] = static_cast<float>(d.z() * flatten_);
  newest.next_lane = (lane + 1) % kNewest;
  const std::uint32_t oldest = newest.next_lane;
  const double oldest_x = newest.x[oldest] + static_cast<double>(i) * side_mm_;
  const double oldest_y = newest.y[oldest] + static_cast<double>(j) * side_mm_;
  const double across = rise_.x() * oldest_x + rise_.y() * oldest_y;
  newest.older_height =
      static_cast<float>(across * flatten_ + rise_.z() * newest.z[oldest]);
}

void Columns::Ask(std::span<const ThinningPoint> points, const Distances& distances,
                  Question* questions) const {
  const auto error = static_cast<float>(error_mm_), side = static_cast<float>(side_mm_);
  const auto row = static_cast<std::uint32_t>(width_);
  for (const ThinningPoint& point : points) {
    const double own_mm = distances.by_own ? point.spacing_mm : 0;
    const float near =
        std::max(0.0F, static_cast<float>(std::max(own_mm, distances.near_mm)) - error);
    const float far = static_cast<float>(std::max(own_mm, distances.far_mm)) + error;
    const Vec3 d = point.p_mm - origin_;
    const double u = d.x() * per_side_, v = d.y() * per_side_;
    const auto i = static_cast<std::uint32_t>(u), j = static_cast<std::uint32_t>(v);
    const bool left = u - i < 0.5, before = v - j < 0.5;
    const auto x = static_cast<float>(d.x() - i * side_mm_);
    const auto y = static_cast<float>(d.y() - j * side_mm_);
    const auto z = static_cast<float>(d.z() * flatten_);
    const std::uint32_t own = (j + 1) * row + i + 1;
    const std::uint32_t beside = left ? own - 1 : own + 1;
    const std::uint32_t behind = before ? 0 - row : row;
    *questions++ = {.x = x,
                    .other_x = left ? x + side : x - side,
                    .y = y,
                    .other_y = before ? y + side : y - side,
                    .z = z,
                    .near_square = near * near,
                    .far_square = far * far,
                    .low_height = static_cast<float>(rise_.dot(d) * flatten_) - far,
                    .columns = {own, beside, own + behind, beside + behind}};
    for (const std::uint32_t at : {own, beside, own + behind, beside + behind}) {
      __builtin_prefetch(newest_[at].x);
      __builtin_prefetch(newest_[at].z);
    }
  }
}

void Columns::QueryByFour(std::span<const ThinningPoint> points,
                          const Distances& distances, Hasty* answers) const {
  std::array<Question, kMaxAtOnce> questions;
  Ask(points, distances, questions.data());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Question& q = questions[k];
    Four smallest = Four{} + kVeryFarSquare;
    float older_height = -kVeryFar;
    for (std::size_t i = 0; i < 4; ++i) {
      const Newest& column = newest_[q.columns[i]];
      const float q_x = i % 2 == 0 ? q.x : q.other_x, q_y = i < 2 ? q.y : q.other_y;
      for (std::size_t lane = 0; lane < kNewest; lane += 4) {
        const Four x = *reinterpret_cast<const Four*>(column.x + lane) - q_x;
        const Four y = *reinterpret_cast<const Four*>(column.y + lane) - q_y;
        const Four z = *reinterpret_cast<const Four*>(column.z + lane) - q.z;
        const Four square = x * x + y * y + z * z;
        smallest = square < smallest ? square : smallest;
      }
      older_height = std::max(older_height, column.older_height);
    }
    answers[k] = AnswerTo(
        q, SmallestOf(smallest[0], smallest[1], smallest[2], smallest[3]), older_height);
  }
}

#ifdef __x86_64__
// The same code for another vector width: the compiler has to see it in a function for
// that processor.
[[gnu::target("avx2")]] void Columns::QueryByEight(std::span<const ThinningPoint> points,
                                                   const Distances& distances,
                                                   Hasty* answers) const {
  std::array<Question, kMaxAtOnce> questions;
  Ask(points, distances, questions.data());
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Question& q = questions[k];
    Eight smallest = Eight{} + kVeryFarSquare;
    float older_height = -kVeryFar;
    for (std::size_t i = 0; i < 4; ++i) {
      const Newest& column = newest_[q.columns[i]];
      const float q_x = i % 2 == 0 ? q.x : q.other_x, q_y = i < 2 ? q.y : q.other_y;
      const Eight x = *reinterpret_cast<const Eight*>(column.x) - q_x;
      const Eight y = *reinterpret_cast<const Eight*>(column.y) - q_y;
      const Eight z = *reinterpret_cast<const Eight*>(column.z) - q.z;
      const Eight square = x * x + y * y + z * z;
      smallest = square < smallest ? square : smallest;
      older_height = std::max(older_height, column.older_height);
    }
    const Four low = {smallest[0], smallest[1], smallest[2], smallest[3]};
    const Four high = {smallest[4], smallest[5], smallest[6], smallest[7]};
    const Four half = low < high ? low : high;
    answers[k] =
        AnswerTo(q, SmallestOf(half[0], half[1], half[2], half[3]), older_height);
  }
}
#endif

Columns::QueryFunction Columns::FastestQuery() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2")) return &Columns::QueryByEight;
#endif
  return &Columns::QueryByFour;
}

}  // namespace intaglio::discretize
