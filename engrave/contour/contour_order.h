#pragma once

// The order of closed contours, and where the tool enters each. A contour ends where it
// starts, and that place is free: the idle way leads from entry to entry. Frame: drawing,
// mm. The tool comes from `start` and does not return.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/union.h"
#include "engrave/contour/way_order.h"

namespace intaglio::contour {

struct ContourVisit {
  std::uint32_t contour = 0;
  std::uint32_t edge = 0;  ///< of the contour
  double way_mm = 0;       ///< along that edge, 0 .. its length

  bool operator==(const ContourVisit&) const = default;
};

using ContourVisits = std::vector<ContourVisit>;

/// As the published program: to the nearest corner of all contours that are left, of
/// several to the one with the smaller way along Y (Siwiec 2016, ch. 6.3.5 and 8). Every
/// contour has an edge. `progress`, which may be empty: in contours; false leaves the
/// rest in the order of `contours`.
ContourVisits NearestContours(std::span<const Contour> contours, const Vec2& start_mm,
                              const ProgressSink& progress = {});

/// Changes the order as ImproveOrder, and the entries, in turns, until neither shortens
/// the idle way. Entries are corners and places between them, at least 24 on a contour.
void ImproveContours(std::span<const Contour> contours, const Vec2& start_mm,
                     ContourVisits& visits, const ImproveOptions& options = {});

double IdleWay_mm(std::span<const Contour> contours, const Vec2& start_mm,
                  std::span<const ContourVisit> visits);

/// The edges of a closed contour from an entry on; the edge with the entry is divided.
Edges EdgesFrom(const Edges& closed, const ContourVisit& visit);

}  // namespace intaglio::contour
