#pragma once

// The places of one mark in hand, one for each servo period, and whether the beam is on
// there:
//
//   where the axes rest --straight, dark--> begin of the contour, until the axes rest
//     --as planned, lit--> its end, until the axes rest --the next pass-->
//
// Frame: axes x, y, z of the machine, mm; z rests.

#include <cstdint>
#include <memory>

#include "services/drivers/linuxcnc/marks/contour_plan.h"
#include "services/drivers/linuxcnc/row_jog.h"

namespace intaglio::drivers {

class MarkRows {
 public:
  /// Limits of the axes on the dark ways: mm/s and mm/s^2, > 0.
  MarkRows(const Vec3& max_speed_mm_s, const Vec3& max_acceleration_mm_s2)
      : max_speed_mm_s_(max_speed_mm_s),
        max_acceleration_mm_s2_(max_acceleration_mm_s2) {}

  struct Row {
    Vec3 place_mm = Vec3::Zero();
    bool lit = false;
    bool last = false;  ///< of the mark
  };

  /// From rest at `from_mm`. `origin_mm`: of the piece in the axes; `passes` >= 1.
  void Begin(std::shared_ptr<const ContourPlan> plan, std::uint32_t passes,
             const Vec3& from_mm, const Vec2& origin_mm);
  /// Only while it is active.
  Row Next(double period_s);
  void End() { plan_.reset(); }
  bool active() const { return plan_ != nullptr; }

 private:
  Vec3 PlaceOf(std::size_t setpoint) const;
  void BeginPass();

  Vec3 max_speed_mm_s_, max_acceleration_mm_s2_;
  std::shared_ptr<const ContourPlan> plan_;
  std::uint32_t passes_left_ = 0;
  Vec3 at_mm_ = Vec3::Zero();
  Vec2 origin_mm_ = Vec2::Zero();
  RowJog way_;
  std::size_t settle_left_ = 0;  ///< before the contour
  std::size_t next_ = 0;         ///< setpoint
  std::size_t rest_left_ = 0;    ///< behind the contour
};

}  // namespace intaglio::drivers
