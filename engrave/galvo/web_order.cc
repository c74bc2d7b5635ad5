#include "engrave/galvo/web_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "engrave/core/try.h"

namespace intaglio::galvo {
namespace {

constexpr std::size_t kMarksAhead = 60;
constexpr int kSpeeds = 25;
// Strips of 0.84 to 0.016 of the field.
constexpr int kStrips = 24;
constexpr double kStripRatio = 0.84;
constexpr double kMaxGain = 4;  // over the order of arrival; 2.1 is the best known

WebOrder TimedBy(std::span<const WebMark> marks, const WebHead& head,
                 std::vector<std::size_t> order) {
  WebOrder timed{std::move(order), {}, 0};
  timed.timed.reserve(timed.order.size());
  for (std::size_t k = 0; k < timed.order.size(); ++k) {
    const WebMark& mark = marks[timed.order[k]];
    const WebMark& before = marks[timed.order[k == 0 ? 0 : k - 1]];
    const double jump_s = (mark.centre_mm - before.centre_mm).norm() / head.jump_mm_s;
    timed.timed.push_back({mark.centre_mm.x(), mark.extent_mm, mark.mark_s + jump_s});
  }
  return timed;
}

Result<WebOrder> WithSpeed(WebOrder order, const WebHead& head) {
  order.max_mm_s = INTAGLIO_TRY(MaxSpeed(order.timed, head.field_mm));
  return order;
}

std::vector<std::size_t> ByArrival(std::span<const WebMark> marks) {
  std::vector<std::size_t> order(marks.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&marks](std::size_t a, std::size_t b) {
    return marks[a].centre_mm.x() < marks[b].centre_mm.x();
  });
  return order;
}

/// Strips across the web, this long: up one, down the next.
std::vector<std::size_t> ByStrips(std::span<const WebMark> marks,
                                  std::vector<std::size_t> order, double strip_mm) {
  const double first_mm = marks[order.front()].centre_mm.x();
  std::vector<std::pair<double, double>> keys(marks.size());  // strip, and way in it
  for (const std::size_t i : order) {
    const double strip = std::floor((marks[i].centre_mm.x() - first_mm) / strip_mm);
    const bool down = std::fmod(strip, 2) != 0;
    const double y_mm = marks[i].centre_mm.y();
    keys[i] = {strip, down ? -y_mm : y_mm};
  }
  std::stable_sort(order.begin(), order.end(),
                   [&keys](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  return order;
}

/// One pass at one speed.
class AheadOrder {
 public:
  AheadOrder(std::span<const WebMark> marks, const WebHead& head,
             const std::vector<std::size_t>& arrival, double speed_mm_s)
      : marks_(marks), head_(head), left_(arrival) {
    times_.reserve(marks.size());
    for (const WebMark& mark : marks) {
      const double half_mm = (head.field_mm - mark.extent_mm) / 2;
      times_.push_back({(mark.centre_mm.x() - half_mm) / speed_mm_s,
                        (mark.centre_mm.x() + half_mm) / speed_mm_s});
    }
  }

  /// Nothing when a mark would be missed.
  std::optional<std::vector<std::size_t>> Order() {
    std::vector<std::size_t> order;
    now_s_ = ArriveS(left_.front());
    for (const std::size_t mark : left_) now_s_ = std::min(now_s_, ArriveS(mark));
    at_mm_ = marks_[left_.front()].centre_mm;
    while (begin_ < left_.size()) {
      const auto next = Next();
      if (!next) return std::nullopt;
      const std::size_t mark = left_[*next];
      now_s_ += CostS(mark, at_mm_);
      at_mm_ = marks_[mark].centre_mm;
      order.push_back(mark);
      // The marks ahead stay in the order of arrival.
      std::rotate(left_.begin() + static_cast<std::ptrdiff_t>(begin_),
                  left_.begin() + static_cast<std::ptrdiff_t>(*next),
                  left_.begin() + static_cast<std::ptrdiff_t>(*next) + 1);
      ++begin_;
    }
    return order;
  }

 private:
  struct InField {
    double arrive_s, leave_s;
  };

  double ArriveS(std::size_t mark) const { return times_[mark].arrive_s; }
  double LeaveS(std::size_t mark) const { return times_[mark].leave_s; }
  double CostS(std::size_t mark, const Vec2& from_mm) const {
    return (marks_[mark].centre_mm - from_mm).norm() / head_.jump_mm_s +
           marks_[mark].mark_s;
  }
  std::size_t End() const { return std::min(begin_ + kMarksAhead, left_.size()); }

  /// Whether the others ahead, in the order of arrival, are all made after this one.
  bool OthersAreMade(std::size_t place) const {
    double then_s = now_s_ + CostS(left_[place], at_mm_);
    Vec2 from_mm = marks_[left_[place]].centre_mm;
    for (std::size_t i = begin_; i < End(); ++i) {
      if (i == place) continue;
      const std::size_t mark = left_[i];
      then_s = std::max(then_s, ArriveS(mark)) + CostS(mark, from_mm);
      from_mm = marks_[mark].centre_mm;
      if (then_s > LeaveS(mark)) return false;
      if (ArriveS(mark) > then_s) break;
    }
    return true;
  }

  /// The place in left_ of the mark that is next; waits for one to arrive.
  std::optional<std::size_t> Next() {
    double arrive_s = ArriveS(left_[begin_]);
    for (std::size_t i = begin_; i < End(); ++i)
      arrive_s = std::min(arrive_s, ArriveS(left_[i]));
    now_s_ = std::max(now_s_, arrive_s);
    near_.clear();
    for (std::size_t i = begin_; i < End(); ++i)
      if (ArriveS(left_[i]) <= now_s_) near_.emplace_back(CostS(left_[i], at_mm_), i);
    std::sort(near_.begin(), near_.end());
    for (const auto& [cost_s, place] : near_) {
      if (now_s_ + cost_s <= LeaveS(left_[place]) && OthersAreMade(place)) return place;
    }
    const double done_s =
        std::max(now_s_, ArriveS(left_[begin_])) + CostS(left_[begin_], at_mm_);
    if (done_s > LeaveS(left_[begin_])) return std::nullopt;
    now_s_ = std::max(now_s_, ArriveS(left_[begin_]));
    return begin_;
  }

  std::span<const WebMark> marks_;
  const WebHead& head_;
  std::vector<InField> times_;  // of each mark
  std::vector<std::size_t> left_;
  std::vector<std::pair<double, std::size_t>> near_;  // cost, place; of one step
  std::size_t begin_ = 0;
  double now_s_ = 0;
  Vec2 at_mm_ = Vec2::Zero();
};

}  // namespace

Result<WebOrder> ArrivalOrder(std::span<const WebMark> marks, const WebHead& head) {
  return WithSpeed(TimedBy(marks, head, ByArrival(marks)), head);
}

Result<WebOrder> FastestOrder(std::span<const WebMark> marks, const WebHead& head,
                              const ProgressSink& progress) {
  const auto goes_on = [&](int tried) -> Status {
    if (!progress || progress(static_cast<std::uint64_t>(tried), kStrips + kSpeeds))
      return {};
    return Fail(ErrorCode::kCancelled, "the ordering of marks was cancelled");
  };
  const std::vector<std::size_t> arrival = ByArrival(marks);
  WebOrder best = INTAGLIO_TRY(WithSpeed(TimedBy(marks, head, arrival), head));
  const auto take = [&](std::vector<std::size_t> order) {
    auto found = WithSpeed(TimedBy(marks, head, std::move(order)), head);
    if (found && found->max_mm_s > best.max_mm_s) best = *std::move(found);
  };
  for (int i = 0; i < kStrips; ++i) {
    INTAGLIO_TRY(goes_on(i));
    take(ByStrips(marks, arrival, head.field_mm * std::pow(kStripRatio, i + 1)));
  }
  double low_mm_s = best.max_mm_s, high_mm_s = kMaxGain * best.max_mm_s;
  for (int i = 0; i < kSpeeds; ++i) {
    INTAGLIO_TRY(goes_on(kStrips + i));
    const double speed_mm_s = std::sqrt(low_mm_s * high_mm_s);
    auto order = AheadOrder(marks, head, arrival, speed_mm_s).Order();
    if (!order) {
      high_mm_s = speed_mm_s;
      continue;
    }
    // Its own largest speed is a little above the one that it was found at.
    low_mm_s = speed_mm_s;
    take(*std::move(order));
  }
  return best;
}

}  // namespace intaglio::galvo
