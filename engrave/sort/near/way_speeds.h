#pragma once

// The velocities with which the places of a way can be passed when each step is made in
// its ticks. What can be reached at a place from its past, and what its future can be
// made from, are boxes, since each axis has its own drive (motion/axis/axis_reach.h): the
// ticks of all steps can be kept exactly when both boxes of a place have a velocity in
// common. Exact for limits of speed and acceleration of each axis.
//
// What a change of some steps does to the boxes fades within some steps, so they are
// computed anew only there. Units: those of TickCost, velocities in A T.

#include <cstddef>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "engrave/motion/axis/axis_reach.h"
#include "engrave/sort/near/tick_cost.h"

namespace intaglio::sort {

struct SpeedBox {
  motion::SpeedEnds axis[3];

  /// Within a hundred thousandth of A T.
  bool IsNear(const SpeedBox& other) const;
  bool Meets(const SpeedBox& other) const;
  /// Those of the same way passed from its end to its begin.
  SpeedBox Reversed() const;
};

class WaySpeeds {
 public:
  explicit WaySpeeds(const TickCost& cost);

  /// Velocities behind a move that begins with one of `from`; false: it cannot be made
  /// in its ticks. `to` may be `from`. By reversal of time these are also the velocities
  /// from which the move leads to `from`.
  bool Pass(const SpeedBox& from, const TimedMove& move, SpeedBox& to) const;

  /// Sets all boxes of a way of `size` places; move_to(i): the move from place i - 1 to
  /// i. Any velocity is possible at the first place and at the last. False: it cannot be
  /// made.
  template <typename MoveTo>
  bool Begin(std::size_t size, const MoveTo& move_to) {
    past_.assign(size, any_);
    future_.assign(size, any_);
    const Steps all{1, size - 1};
    return size < 2 || Settle({&all, 1}, move_to);
  }

  /// The places [begin, end) get the points of others of them, old_of(place), which the
  /// way passes the other way round where is_turned(place).
  template <typename OldOf, typename IsTurned>
  void Rearrange(std::size_t begin, std::size_t end, const OldOf& old_of,
                 const IsTurned& is_turned) {
    moved_.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t old = old_of(i);
      if (is_turned(i)) {
        moved_.push_back({future_[old].Reversed(), past_[old].Reversed()});
      } else {
        moved_.push_back({past_[old], future_[old]});
      }
    }
    for (std::size_t i = begin; i < end; ++i)
      std::tie(past_[i], future_[i]) = moved_[i - begin];
  }

  /// Steps to the places [first, last].
  struct Steps {
    std::size_t first, last;
  };

  /// Sets the boxes that change when these steps have changed, ascending, and no others.
  /// False: the way cannot be made, and no box has a meaning until Begin.
  template <typename MoveTo>
  bool Settle(std::span<const Steps> changed, const MoveTo& move_to) {
    for (const auto [first, last] : changed) {
      for (std::size_t i = first; i < past_.size(); ++i) {
        SpeedBox box;
        if (!Pass(past_[i - 1], move_to(i), box)) return false;
        if (i > last && box.IsNear(past_[i])) break;
        past_[i] = box;
      }
    }
    for (std::size_t k = changed.size(); k-- > 0;) {
      for (std::size_t i = changed[k].last; i > 0; --i) {
        SpeedBox box;
        if (!Pass(future_[i], move_to(i), box)) return false;
        if (i < changed[k].first && box.IsNear(future_[i - 1])) break;
        future_[i - 1] = box;
      }
    }
    return true;
  }

  /// Of a place: the velocities that its past can lead to.
  const SpeedBox& Past(std::size_t place) const { return past_[place]; }
  /// The velocities that its future can be made from.
  const SpeedBox& Future(std::size_t place) const { return future_[place]; }

 private:
  motion::AxisLimits limits_[3];
  SpeedBox any_;
  std::vector<SpeedBox> past_, future_;
  std::vector<std::pair<SpeedBox, SpeedBox>> moved_;
};

}  // namespace intaglio::sort
