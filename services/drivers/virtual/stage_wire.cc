#include "services/drivers/virtual/stage_wire.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace intaglio::drivers::wire {
namespace {

/// A velocity on the line; absent where the line cannot carry it.
std::optional<std::int32_t> ToCounts(double mm_s, std::uint32_t unit_nm_s) {
  const double counts = mm_s * kNmPerMm / unit_nm_s;
  if (!(std::abs(counts) <= std::numeric_limits<std::int32_t>::max()))
    return std::nullopt;
  return static_cast<std::int32_t>(std::llround(counts));
}

std::uint32_t SpeedNmS(double mm_s) {
  return static_cast<std::uint32_t>(std::clamp(mm_s * kNmPerMm, 1.0, 4e9));
}

std::string NamesOf(const std::array<bool, 3>& axes) {
  std::string names;
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    if (!axes[axis]) continue;
    if (!names.empty()) names += ", ";
    names += "xyz"[axis];
  }
  return names.empty() ? "an axis" : names;
}

}  // namespace

std::int32_t ToNm(double mm) {
  // Travel lies within +-2 m, so a wild value is outside of it, and a NaN is made to be.
  if (std::isnan(mm)) return std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(
      std::llround(std::clamp(mm * kNmPerMm, -2.1e9, 2.1e9)));
}

Vec3 ToMm(std::int32_t x_nm, std::int32_t y_nm, std::int32_t z_nm) {
  return Vec3(x_nm, y_nm, z_nm) / kNmPerMm;
}

std::optional<link::WireSegment> ToWire(const motion::Segment& segment,
                                        std::uint32_t unit_nm_s) {
  const Vec3& p = segment.end_position_mm;
  const Vec3& v = segment.end_velocity_mm_s;
  const auto vx = ToCounts(v.x(), unit_nm_s), vy = ToCounts(v.y(), unit_nm_s),
             vz = ToCounts(v.z(), unit_nm_s);
  if (!vx || !vy || !vz) return std::nullopt;
  return link::WireSegment{ToNm(p.x()),
                           ToNm(p.y()),
                           ToNm(p.z()),
                           *vx,
                           *vy,
                           *vz,
                           segment.duration_subticks,
                           segment.pulse,
                           segment.program_end};
}

link::WireTimedSegment Timed(const link::WireSegment& wire, std::uint64_t end_ns) {
  return {wire.x_nm,      wire.y_nm, wire.z_nm,  wire.vx_counts,  wire.vy_counts,
          wire.vz_counts, end_ns,    wire.pulse, wire.program_end};
}

link::JogMove ToJogMove(const Vec3& axes, double speed_mm_s) {
  return {ToNm(axes.x()), ToNm(axes.y()), ToNm(axes.z()), SpeedNmS(speed_mm_s)};
}

link::MoveBlock ToMoveBlock(const Vec2& place_mm, double speed_mm_s) {
  return {ToNm(place_mm.x()), ToNm(place_mm.y()), SpeedNmS(speed_mm_s)};
}

FaultText TextOf(link::StageFault fault, const std::array<bool, 3>& axes) {
  using link::StageFault;
  switch (fault) {
    case StageFault::kNone:
      return {intaglio_MOTION_OK, ""};
    case StageFault::kStarved:
      return {intaglio_MOTION_STARVED,
              "the queue of the stage ran empty during a run: the host or the line was "
              "too slow"};
    case StageFault::kLimit:
      return {
          intaglio_MOTION_LIMIT,
          "the stage has met a limit switch, or a target lies outside the axes' travel: "
          "check the stage, block_origin_mm and the block, then resume"};
    case StageFault::kFollowingError:
      return {intaglio_MOTION_FOLLOWING_ERROR,
              "the following error of the stage is too large: free the stage and check "
              "its drive"};
    case StageFault::kLate:
      return {intaglio_MOTION_LATE, "the run reached the stage after its start tick"};
    case StageFault::kRunRefused:
      return {intaglio_MOTION_LATE,
              "the stage was not at rest at the beginning of the run"};
    case StageFault::kSafeState:
      return {intaglio_MOTION_STARVED,
              "the stage received no frame for 250 ms and stopped"};
    case StageFault::kNoAir:
      return {intaglio_MOTION_NO_AIR,
              "the stage has no compressed air and does not move: open the valve, check "
              "the pressure, then resume"};
    case StageFault::kAirReturned:
      return {intaglio_MOTION_SAFE_STATE,
              "the stage had no compressed air and stopped; the air is back"};
    case StageFault::kBadSequence:
      return {intaglio_MOTION_STARVED,
              "segments were lost on the motion line, and the stage stopped"};
    case StageFault::kBlockPlace:
      return {intaglio_MOTION_SAFE_STATE,
              "the stage that carries the block is not at the job's place: check that "
              "nothing holds or pushes it, then resume"};
    case StageFault::kPlaceLost:
      return {intaglio_MOTION_SAFE_STATE,
              "the stage controller does not know where its axes are: home it "
              "(intaglio teach home)"};
    case StageFault::kNoSwitch:
      return {intaglio_MOTION_SAFE_STATE,
              fmt::format("home: the switch of {} was not met within the way that is "
                          "searched: check that the axis moves and its direction, then "
                          "the switch and its cable, and home again",
                          NamesOf(axes))};
    case StageFault::kSwitchStuck:
      return {intaglio_MOTION_SAFE_STATE,
              fmt::format("home: the switch of {} stays pressed while the axis backs "
                          "off: check the switch and its cable, then that the axis "
                          "moves, and home again",
                          NamesOf(axes))};
    case StageFault::kSwitchMet:
      return {intaglio_MOTION_SAFE_STATE,
              fmt::format("the switch of {} was met outside home, so steps were lost or "
                          "its cable is off: find what blocks the axis, and home it "
                          "(intaglio teach home)",
                          NamesOf(axes))};
    case StageFault::kDriveFault:
      return {intaglio_MOTION_SAFE_STATE,
              "an amplifier of the stage reports a fault: switch the drives off and on, "
              "then home the stage (intaglio teach home)"};
    case StageFault::kTooFast:
      return {intaglio_MOTION_LIMIT,
              fmt::format("the plan is faster than the stage controller can step {}: "
                          "reduce max_speed_mm_s of the axis in the machine profile to "
                          "that of its board file",
                          NamesOf(axes))};
    case StageFault::kStopPressed:
      return {intaglio_MOTION_SAFE_STATE,
              "the stop button of the stage is pressed: release it, then home the stage "
              "(intaglio teach home)"};
  }
  return {intaglio_MOTION_SAFE_STATE, "the stage reports an unknown fault"};
}

}  // namespace intaglio::drivers::wire
