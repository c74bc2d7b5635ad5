#pragma once

// Reads circuit boards of KiCad (.kicad_pcb, an s-expression; KiCad, Board File Format,
// 2023; versions 20171130 .. 20241229, KiCad 5 to 9).
//
// What is read: nets; segments, arcs and vias; the pads of footprints (circle, rect,
// oval, roundrect, trapezoid as rect, custom with polygons) with their drills; the filled
// polygons of zones; graphics of copper layers; the outline of the board on Edge.Cuts
// (gr_line, gr_arc, gr_circle, gr_rect, gr_poly and those of footprints, fp_...). Text on
// copper, zones that are not filled, and what else changes the copper but is not read are
// findings. Frame: drawing, mm, y up;
// KiCad's y points down, so y changes its sign.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/contour/drill_plan.h"
#include "engrave/contour/milling/nets.h"
#include "engrave/core/findings.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge.
struct KicadLimits {
  std::uint64_t max_file_bytes = std::uint64_t{256} << 20;
  std::uint64_t max_expressions = 20'000'000;
  int max_nesting = 100;
  std::uint64_t max_elements = 1'000'000;
};

struct KicadBoard {
  std::vector<std::string> layers;   ///< copper layers, front first; bit 1 << k each
  std::vector<NetElement> elements;  ///< pads named "R1-2", nets as in the file
  std::vector<Hole> holes;           ///< of vias and pads
  std::vector<Element> slots;        ///< drills longer than wide
  std::vector<Edges> outline;        ///< of the board: closed loops, may be empty
  FileFindings findings;             ///< expressions that are not read
};

/// Errors name the file, the line and the remedy: kUnreadable (no board, brackets that do
/// not match), kInvalidValue (numbers, an open outline), kMissing (layers, a net),
/// kUnsupported (see above), kTooLarge.
Result<KicadBoard> ReadKicadBoard(std::string_view text, std::string_view name,
                                  const KicadLimits& limits = {});

/// What is drawn on one layer.
std::vector<Element> ElementsOfLayer(const KicadBoard& board, std::uint32_t layer);

}  // namespace intaglio::contour
