// Reversing a part i..j of the order, each mark of it turned, changes the two ways at its
// ends alone.

#include "engrave/mark/visits.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace intaglio::mark {
namespace {

constexpr std::size_t kWindow = 50;
constexpr int kMaxRounds = 30;

/// Which places of an order lie so near that the exact ways are to be compared: in single
/// precision and eight at a time, with a margin beyond its rounding, so that none is
/// passed over.
class NearPlaces {
 public:
  static constexpr std::size_t kGroup = 8;

  explicit NearPlaces(std::size_t places)
      : begin_x_(places + kGroup, kFar),
        begin_y_(places + kGroup, kFar),
        end_x_(places + kGroup, kFar),
        end_y_(places + kGroup, kFar),
        way_(places + kGroup, 0) {}

  void Set(std::size_t place, const Vec2& begin_mm, const Vec2& end_mm, double way_mm) {
    begin_x_[place] = static_cast<float>(begin_mm.x());
    begin_y_[place] = static_cast<float>(begin_mm.y());
    end_x_[place] = static_cast<float>(end_mm.x());
    end_y_[place] = static_cast<float>(end_mm.y());
    way_[place] = static_cast<float>(way_mm);
  }
  /// Of coordinates up to this, mm.
  void SetMargin(double largest_mm) {
    margin_ = static_cast<float>(8e-6 * largest_mm + 1e-6);
  }

  /// Whether of the group from `first` on one ends within `room_mm` and its way of
  /// `to_end` and begins within that of `to_begin`.
  bool Any(std::size_t first, const Vec2& to_end, const Vec2& to_begin,
           double room_mm) const {
    using Group = Eigen::Array<float, kGroup, 1>;
    const auto of = [first](const std::vector<float>& values) {
      return Eigen::Map<const Group>(&values[first]);
    };
    const auto single = [](double value) { return static_cast<float>(value); };
    const Group within = (of(way_) + (single(room_mm) + margin_)).max(0.0F);
    const Group to_ends = (of(end_x_) - single(to_end.x())).square() +
                          (of(end_y_) - single(to_end.y())).square();
    const Group to_begins = (of(begin_x_) - single(to_begin.x())).square() +
                            (of(begin_y_) - single(to_begin.y())).square();
    return (within.square() - to_ends.max(to_begins)).maxCoeff() >= 0;
  }

 private:
  static constexpr float kFar = 1e18F;

  std::vector<float> begin_x_, begin_y_;  // of the mark at a place
  std::vector<float> end_x_, end_y_;      // of the mark before it
  std::vector<float> way_;                // between them
  float margin_ = 0;
};

/// Ends and ways at each place of the order, so that no way is measured twice. Most pairs
/// are too far from each other to be better, which their squared distances show; the
/// margins of these bounds exceed what rounding does, so that the decisions are those of
/// the ways themselves.
class Improver {
 public:
  Improver(const Ends& ends, const Vec2& start, std::vector<Visit>& order)
      : ends_(ends), order_(order), count_(order.size()), near_(count_ + 1) {
    begin_mm_.resize(count_);
    end_mm_.resize(count_ + 1, start);
    way_mm_.resize(count_ + 1, 0);
    double largest_mm = start.cwiseAbs().maxCoeff();
    for (std::uint32_t i = 0; i < count_; ++i)
      for (const bool back : {false, true})
        largest_mm = std::max(largest_mm, ends.Begin({i, back}).cwiseAbs().maxCoeff());
    near_.SetMargin(largest_mm);
    Measure(0, count_);
  }

  void Run(bool may_reverse) {
    for (int round = 0; round < kMaxRounds; ++round) {
      bool better = false;
      for (std::size_t i = 0; i < count_; ++i) {
        if (may_reverse) better = ReverseFrom(i) || better;
        better = MoveAway(i) || better;
      }
      if (!better) return;
    }
  }

 private:
  static constexpr double kGainMm = 1e-9;
  static constexpr std::size_t kGroup = NearPlaces::kGroup;

  /// Of the places `from` to before `to`, and the way behind them.
  void Measure(std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < to; ++i) {
      begin_mm_[i] = ends_.Begin(order_[i]);
      end_mm_[i + 1] = ends_.End(order_[i]);
    }
    for (std::size_t i = from; i < std::min(to + 1, count_); ++i) {
      way_mm_[i] = (begin_mm_[i] - end_mm_[i]).norm();
      near_.Set(i, begin_mm_[i], end_mm_[i], way_mm_[i]);
    }
  }
  /// From `from` to the mark at i; behind the last one nothing.
  double WayTo(const Vec2& from, std::size_t i) const {
    return i < count_ ? (begin_mm_[i] - from).norm() : 0;
  }
  double SquareTo(const Vec2& from, std::size_t i) const {
    return i < count_ ? (begin_mm_[i] - from).squaredNorm() : 0;
  }
  /// What comes behind the last place is near everything.
  bool AnyNear(std::size_t first, std::size_t end, const Vec2& to_end,
               const Vec2& to_begin, double room_mm) const {
    return end > count_ || near_.Any(first, to_end, to_begin, room_mm);
  }

  bool ReverseFrom(std::size_t i) {
    bool better = false;
    const std::size_t last = std::min(count_, i + kWindow);
    for (std::size_t j = i; j < last;) {
      const std::size_t end = std::min(last, j + kGroup);
      if (AnyNear(j + 1, end + 1, end_mm_[i], begin_mm_[i], way_mm_[i]))
        for (std::size_t k = j; k < end; ++k) better = ReverseIfBetter(i, k) || better;
      j = end;
    }
    return better;
  }

  /// The marks from i to j.
  bool ReverseIfBetter(std::size_t i, std::size_t j) {
    const Vec2 &before = end_mm_[i], &first = begin_mm_[i], &end = end_mm_[j + 1];
    const double is = way_mm_[i] + way_mm_[j + 1];
    const double far = (1 + kMargin) * is * is;
    if ((end - before).squaredNorm() > far || SquareTo(first, j + 1) > far) return false;
    const double would_be = (end - before).norm() + WayTo(first, j + 1);
    if (would_be > is - kGainMm) return false;
    std::reverse(order_.begin() + static_cast<std::ptrdiff_t>(i),
                 order_.begin() + static_cast<std::ptrdiff_t>(j + 1));
    for (std::size_t k = i; k <= j; ++k) order_[k].back = !order_[k].back;
    Measure(i, j + 1);
    return true;
  }

  /// The mark at i, behind a later one or before an earlier one.
  bool MoveAway(std::size_t i) {
    const double saved = way_mm_[i] + way_mm_[i + 1] - WayTo(end_mm_[i], i + 1);
    std::size_t best = i;
    double lowest_mm = saved - kGainMm;
    const std::size_t last = std::min(count_, i + kWindow) + 1;
    for (std::size_t k = i < kWindow ? 0 : i - kWindow; k < last;) {
      const std::size_t end = std::min(last, k + kGroup);
      if (AnyNear(k, end, begin_mm_[i], end_mm_[i + 1], lowest_mm))
        for (; k < end; ++k) CompareMove(i, k, best, lowest_mm);
      k = end;
    }
    if (best == i) return false;
    const auto at = [&](std::size_t k) {
      return order_.begin() + static_cast<std::ptrdiff_t>(k);
    };
    if (best > i) {
      std::rotate(at(i), at(i + 1), at(best));
      Measure(i, best);
    } else {
      std::rotate(at(best), at(i), at(i + 1));
      Measure(best, i + 1);
    }
    return true;
  }

  /// The mark at i between k - 1 and k costs the ways to and from it less the way that
  /// is.
  void CompareMove(std::size_t i, std::size_t k, std::size_t& best,
                   double& lowest_mm) const {
    if (k == i || k == i + 1) return;
    const Vec2 &begin = begin_mm_[i], &end = end_mm_[i + 1];
    const double way_mm = way_mm_[k], room_mm = lowest_mm + way_mm;
    if (room_mm < 0) return;
    const double near = room_mm + kMargin * (way_mm + std::abs(lowest_mm));
    if ((begin - end_mm_[k]).squaredNorm() > near * near ||
        SquareTo(end, k) > near * near)
      return;
    const double cost_mm = (begin - end_mm_[k]).norm() + WayTo(end, k) - way_mm;
    if (cost_mm < lowest_mm) lowest_mm = cost_mm, best = k;
  }

  const Ends& ends_;
  std::vector<Visit>& order_;
  const std::size_t count_;
  NearPlaces near_;
  std::vector<Vec2> begin_mm_;  // of the mark at each place
  std::vector<Vec2> end_mm_;    // where the beam is before each place
  std::vector<double> way_mm_;  // between them; behind the last place 0
};

}  // namespace

void ImproveVisits(const Ends& ends, const Vec2& start_mm, bool may_reverse,
                   std::vector<Visit>& order) {
  Improver(ends, start_mm, order).Run(may_reverse);
}

}  // namespace intaglio::mark
