#pragma once

// The swings of a path: which corners get one, of which length, and how fast they are
// passed by it. A swing is made for a class of corners, by the direction and the size of
// their turn to kClassRad / 2, and turned to each corner. A table keeps what it has made,
// so that the corners of many contours share it; what it makes depends on the class
// alone. Any thread may call it.

#include <compare>
#include <map>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>

#include "engrave/course/swing_maker.h"

namespace intaglio::course {

/// Corners along the axes and at right angles are in the middle of their classes.
inline constexpr double kClassRad = std::numbers::pi / 16;

class SwingTable {
 public:
  struct Limits {
    double acceleration_mm_s2 = 0;  ///< along the path
    double longest_half = 0;        ///< of a swing on one side, in lengths of the kernel
  };
  /// `speeds` as of FirstSpeeds with this acceleration: nodes that are passed faster with
  /// a swing get it, and its speed, when both legs last long enough. The
  /// axes of `tracking` are the same in all calls.
  void AddTo(const Path& path, const Tracking& tracking, const Allowed& allowed,
             const Limits& limits, Speeds& speeds);

 private:
  struct Key {
    double kernel_s = 0, period_s = 0, error_mm = 0, motor_mm_s2 = 0, jerk_mm_s3 = 0,
           acceleration_mm_s2 = 0, feed_mm_s = 0, half_s = 0;
    int bisector = 0, turn = 0;  ///< in kClassRad, of a turn to the left

    auto operator<=>(const Key&) const = default;
  };
  std::optional<SwingShape> Find(const Key& key, const Tracking& tracking,
                                 const Allowed& allowed);

  std::mutex mutex_;
  std::map<Key, std::optional<SwingShape>> made_;
};

}  // namespace intaglio::course
