#include "services/drivers/interface/motion_driver.h"

#include <string_view>

namespace intaglio::drivers {
namespace {

constexpr std::string_view kThenResume = ", then resume";

}  // namespace

std::string WhyPlaceIsUnknown(const DriverState& state) {
  if (!state.place_lost.empty() || state.homed) return state.place_lost;
  return "the controller does not know where its axes are: home it" +
         std::string(state.how_to_home);
}

MotionHindrance FindHindrance(const DriverState& state) {
  const std::string unknown = WhyPlaceIsUnknown(state);
  if (unknown.empty() || !state.link_up || state.fault == intaglio_MOTION_NO_AIR)
    return {state.fault, state.message};
  std::string why = state.message;
  if (why.ends_with(kThenResume)) why.resize(why.size() - kThenResume.size());
  // The message of a fault whose remedy is to home may name it already.
  const bool is_named =
      why.ends_with(unknown) || why.ends_with("home it" + std::string(state.how_to_home));
  if (!is_named) why += (why.empty() ? "" : "; ") + unknown;
  return {intaglio_MOTION_PLACE_LOST, why.append(kThenResume)};
}

Status HandMotion::Jog(const Vec3& /*axes*/, double /*speed_mm_s*/) {
  return Fail(ErrorCode::kUnsupported,
              "the driver of this motion controller cannot move it by hand: use the "
              "controller's own panel");
}

Status HandMotion::Home() {
  return Fail(ErrorCode::kUnsupported,
              "the driver of this motion controller cannot home it: use the "
              "controller's own panel");
}

Status HandMotion::SetZero(const Vec3& /*here*/, const std::array<bool, 3>& /*sets*/) {
  return Fail(ErrorCode::kUnsupported, "this controller keeps no zero of a person's");
}

Status HandMotion::DrawOutline(std::span<const Vec2> /*corners_mm*/,
                               double /*speed_mm_s*/) {
  return Fail(ErrorCode::kUnsupported,
              "the driver of this machine has no guide laser that draws an outline: one "
              "at a BJJCZ board does (docs/machines/bjjcz.md)");
}

Status HandMotion::MoveBlock(const Vec2& /*place_mm*/, double /*speed_mm_s*/) {
  return Fail(
      ErrorCode::kUnsupported,
      "the driver of this motion controller moves no stage that carries the block");
}

Status MotionDriver::RequireBlockAt(const Vec2& place_mm) {
  return place_mm == Vec2::Zero() ? Status() : HandMotion::MoveBlock(place_mm, 0);
}

Box3 TravelOf(const MachineSpec& machine) {
  Box3 travel;
  const AxisLimits* axes[] = {&machine.x(), &machine.y(), &machine.z()};
  for (int i = 0; i < 3; ++i) {
    travel.min_mm[i] = axes[i]->travel_min_mm();
    travel.max_mm[i] = axes[i]->travel_max_mm();
  }
  return travel;
}

}  // namespace intaglio::drivers
