#pragma once

// A local search of a stretch of an order (stretch.h) in the way of Lin and Kernighan,
// with the don't-look bits of Bentley and with kicks, for ticks in the place of lengths.
//
// Points whose surroundings have changed wait in a queue. For each, the step behind it
// and the one before it are replaced: by a step to one of the near points to which the
// axes come in the fewest ticks with the velocity that they have there, and then by a
// second and a third new step that close the order again (2-opt, Or-opt and the other
// sequential exchanges of three steps that turn at most one piece). The first change that
// costs less is made, and the points around it wait again. Behind an empty queue comes a
// kick, a random change that may lose some ticks; where the search cannot gain them
// again, all is undone.
//
// Beside annealing, it gains more in the same time once an order is good, because nearly
// each of its tries is where something can be gained.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/sort/stretch.h"

namespace intaglio::sort {

class StretchSearch {
 public:
  /// `stretch` outlives this and has no tube.
  explicit StretchSearch(Stretch& stretch);

  /// Ends after so many tried changes. The cost of the stretch does not grow.
  void Run(std::uint64_t tries, std::uint64_t seed);

 private:
  using Change = Stretch::Change;

  /// A change to be undone, with the ticks that its steps had.
  struct Undoing {
    Change back;
    Stretch::Window windows[3];
    std::size_t window_count;
  };
  /// Where the third joint can be: at ends of pieces that begin or end at `there`, and
  /// beside points near to two others. Places as they are seen.
  struct Joints {
    std::size_t there;
    bool with_lengths;
    bool forwards;
    std::size_t x, beside_x;  ///< 1: behind the points near to x, 0: before them
    std::size_t y, beside_y;
  };

  static std::vector<Scaled> PointsOf(const Stretch& stretch);
  std::size_t Seen(std::size_t place) const {
    return backwards_ ? stretch_.at_.size() - 1 - place : place;
  }
  Change Seen(const Change& change) const;
  void Wait(std::size_t place);
  void Empty();
  void SearchQueue();
  bool Improve(std::uint32_t point);
  bool ReplaceStepBehind(std::uint32_t point);
  bool Close(std::size_t here, std::size_t there);
  bool CloseForwards(std::size_t here, std::size_t there);
  bool CloseBackwards(std::size_t here, std::size_t there);
  void FindJoints(const Joints& where);
  std::size_t SmoothLength(std::size_t there, bool forwards) const;
  bool Try(const Change& seen);
  void Make(const Change& change);
  void Undo();
  bool Kick();

  Stretch& stretch_;
  NearPoints near_;
  std::uint64_t tries_left_ = 0;
  bool backwards_ = false;  ///< The order is seen from its end to its begin.
  std::vector<std::uint32_t> queue_;
  std::size_t queue_begin_ = 0;
  std::vector<bool> waits_;  ///< of each point
  std::vector<std::size_t> joints_;
  std::vector<Undoing> made_;  ///< since the kick
  bool records_ = false;
  double cost_ = 0;  ///< since the kick
};

}  // namespace intaglio::sort
