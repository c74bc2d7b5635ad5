#pragma once

// Paths for the stage of the virtual engraver to follow.

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "services/virtual_engraver/stage.h"

namespace intaglio::virtual_engraver {

inline constexpr double kRateHz = 100;
inline constexpr std::uint32_t kTick = 65536;  // subticks
inline constexpr std::uint64_t kStartTick = 3;

/// Whole um and um/s, so that what travels in nm is exact.
struct Knot {
  Vec3 at_um, speed_um_s;
  std::uint32_t subticks;
  bool pulse = false, end = false;
};

inline link::WireSegment ToWire(const Knot& knot) {
  const auto nm = [](double um) {
    return static_cast<std::int32_t>(std::lround(um * 1000));
  };
  return {nm(knot.at_um.x()),
          nm(knot.at_um.y()),
          nm(knot.at_um.z()),
          nm(knot.speed_um_s.x()),
          nm(knot.speed_um_s.y()),
          nm(knot.speed_um_s.z()),
          knot.subticks,
          knot.pulse,
          knot.end};
}

inline link::Segments Frame(const std::vector<Knot>& knots,
                            std::uint64_t first_number = 0, std::uint32_t run = 1) {
  link::Segments frame{run, first_number, {}};
  for (const Knot& knot : knots) frame.segments.push_back(ToWire(knot));
  return frame;
}

/// A curved path from rest to rest whose knots do not fall on ticks.
inline const std::vector<Knot> kPath = {
    {{400, -200, 100}, {30000, -20000, 5000}, 2 * kTick + kTick / 3},
    {{900, 300, 50}, {25000, 40000, -9000}, kTick + kTick / 7},
    {{1400, 900, -100}, {-10000, 20000, 0}, 5 * kTick / 2},
    {{1300, 1000, 0}, {0, 0, 0}, 4 * kTick, false, true},
};

inline StageOptions Roomy(double lag_s) {
  StageOptions options;
  options.travel_min_mm = Vec3::Constant(-50);
  options.travel_max_mm = Vec3::Constant(50);
  options.mechanics.lag_s = lag_s;
  return options;
}

inline void Begin(Stage& stage, const std::vector<Knot>& path) {
  stage.BeginRun({1, kStartTick});
  stage.Append(Frame(path));
}

/// Ticks that pass until the stage is at rest; nothing when it never is.
inline std::optional<int> TicksToRest(Stage& stage) {
  for (int ticks = 0; ticks < 10000; ++ticks) {
    if (!stage.running()) return ticks;
    stage.AdvanceTick(kRateHz);
  }
  return std::nullopt;
}

}  // namespace intaglio::virtual_engraver
