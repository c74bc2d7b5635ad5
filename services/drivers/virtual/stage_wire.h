#pragma once

// Between the motion driver's numbers and those of the motion line: mm and whole nm,
// velocities and counts, the stage's faults and what a person reads of them.

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/motion/segments/segment.h"
#include "idl/motion.h"
#include "services/platform/link/motion_protocol.h"

namespace intaglio::drivers::wire {

inline constexpr double kNmPerMm = 1e6;

/// A wild value or NaN becomes one beyond the travel, which lies within +-2 m.
std::int32_t ToNm(double mm);
Vec3 ToMm(std::int32_t x_nm, std::int32_t y_nm, std::int32_t z_nm);

/// Absent where an axis is too fast for the line, whose velocities count `unit_nm_s`.
std::optional<link::WireSegment> ToWire(const motion::Segment& segment,
                                        std::uint32_t unit_nm_s);
link::WireTimedSegment Timed(const link::WireSegment& wire, std::uint64_t end_ns);

/// Motions by hand, at `speed_mm_s` or the nearest that the line carries.
link::JogMove ToJogMove(const Vec3& axes, double speed_mm_s);
link::MoveBlock ToMoveBlock(const Vec2& place_mm, double speed_mm_s);

struct FaultText {
  intaglio_MotionFault fault;
  std::string message;  ///< what to do, too; empty: no fault
};
/// `axes`: those that the fault is of, as far as it is of some.
FaultText TextOf(link::StageFault fault, const std::array<bool, 3>& axes = {});

}  // namespace intaglio::drivers::wire
