#include "services/drivers/linuxcnc/marks/mark_rows.h"

#include <utility>

namespace intaglio::drivers {

void MarkRows::Begin(std::shared_ptr<const ContourPlan> plan, std::uint32_t passes,
                     const Vec3& from_mm, const Vec2& origin_mm) {
  plan_ = std::move(plan);
  passes_left_ = passes;
  at_mm_ = from_mm;
  origin_mm_ = origin_mm;
  BeginPass();
}

Vec3 MarkRows::PlaceOf(std::size_t setpoint) const {
  const Vec2 place_mm = plan_->setpoints_mm[setpoint] + origin_mm_;
  return {place_mm.x(), place_mm.y(), at_mm_.z()};
}

void MarkRows::BeginPass() {
  --passes_left_;
  way_.Begin(at_mm_, PlaceOf(0), max_speed_mm_s_.norm(), max_speed_mm_s_,
             max_acceleration_mm_s2_);
  settle_left_ = rest_left_ = plan_->settle_count;
  next_ = 0;
}

MarkRows::Row MarkRows::Next(double period_s) {
  if (way_.active()) {
    at_mm_ = way_.Next(period_s);
    return {at_mm_};
  }
  if (settle_left_ > 0) {
    --settle_left_;
    return {at_mm_};
  }
  Row row;
  if (next_ < plan_->setpoints_mm.size()) {
    row.lit = next_ >= plan_->lit_begin && next_ < plan_->lit_end;
    at_mm_ = PlaceOf(next_++);
  } else {
    --rest_left_;
  }
  row.place_mm = at_mm_;
  if (next_ < plan_->setpoints_mm.size() || rest_left_ > 0) return row;
  if (passes_left_ > 0) {
    BeginPass();
  } else {
    row.last = true;
    End();
  }
  return row;
}

}  // namespace intaglio::drivers
