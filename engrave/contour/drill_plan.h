#pragma once

// The holes of a board by tool: growing diameters, a tool change between them (Siwiec
// 2016, ch. 6.3.6).

#include <span>
#include <vector>

#include "engrave/contour/way_order.h"

namespace intaglio::contour {

struct Hole {
  Vec2 center_mm = Vec2::Zero();
  double diameter_mm = 0;
  /// Of one tool, those of a lower turn are drilled first: ends of a slot before what is
  /// between them.
  int turn = 0;
};

enum class OrderKind {
  kNearest,   ///< as published
  kImproved,  ///< never longer
};

struct DrillTool {
  double diameter_mm = 0;
  VisitOrder holes;  ///< numbers of holes, in their order
};

/// One tool for all diameters within 1 um. The first begins at `start`, each other one
/// where the one before ended. Every hole is drilled once, after all of this tool that
/// have a lower turn.
std::vector<DrillTool> PlanDrilling(std::span<const Hole> holes, const Vec2& start_mm,
                                    OrderKind kind = OrderKind::kImproved,
                                    const ImproveOptions& options = {});

}  // namespace intaglio::contour
