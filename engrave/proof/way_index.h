#pragma once

// Which steps of a tool came by a place, and how often. Frame: x and y of the machine,
// mm; depth below the face of the sheet. Time: steps near the place.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "engrave/proof/cut_sheet.h"

namespace intaglio::proof {

class WayIndex {
 public:
  /// `steps` in the order of time; they have to live as long as this.
  explicit WayIndex(std::span<const CutStep> steps);

  /// How many times the tool came nearer than `near_mm` while its tip was within
  /// `near_mm` of `depth_mm`: steps that follow each other count once.
  std::size_t VisitsOf(const Vec2& place_mm, double depth_mm, double near_mm) const;
  /// From the place to the nearest one of the way at that depth; none nearer than that.
  std::optional<Vec2> ToNearest(const Vec2& place_mm, double depth_mm,
                                double near_mm) const;
  /// The way has a place as near at that depth, or deeper.
  bool ReachesTo(const Vec2& place_mm, double depth_mm, double near_mm) const;

 private:
  struct Depths {
    double min_mm, max_mm;
  };
  std::vector<std::uint32_t> StepsNear(const Vec2& place_mm, const Depths& depths,
                                       double near_mm) const;

  std::span<const CutStep> steps_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> buckets_;
};

/// From the place to the nearest one of the step, in the plane.
Vec2 ToStep(const Vec2& place_mm, const CutStep& step);

}  // namespace intaglio::proof
