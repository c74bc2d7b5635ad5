#pragma once

// Which conductors a board has in fact: the copper that is left (drawn, or the sheet
// without what a tool has swept) falls into islands, and islands are nets. Compared with
// the nets that the board is to have, short and open circuits are found by geometry.
// Frame: drawing, mm.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engrave/contour/isolation.h"
#include "engrave/contour/region/region.h"

namespace intaglio::contour {

/// The sheet without what the tool of an isolation sweeps on all its passes.
Result<Region> CopperLeft(const Region& sheet, const Isolation& isolation,
                          double tool_diameter_mm);

/// What is drawn on the board, with the net that it belongs to.
struct NetElement {
  Element element;
  std::string net;           ///< empty: not known, or none
  bool terminal = true;      ///< a pad or via that has to be connected; not a track
  std::uint32_t layers = 1;  ///< a bit each; on several: it connects them
};

enum class FaultKind {
  kShort,  ///< two nets are one
  kOpen,   ///< one net is in parts
  kLost,   ///< a terminal without copper at its place
};

struct NetFault {
  FaultKind kind = FaultKind::kShort;
  std::string net;
  std::string other_net;  ///< of a short
  Vec2 place_mm;          ///< in the middle of what is nearest to each other
  std::string sentence;   ///< "nets GND and VCC are connected at (2.54, 5.08)"
};

struct NetReport {
  std::uint32_t island_count = 0;  ///< of all layers
  std::uint32_t net_count = 0;     ///< islands connected by terminals on several layers
                                   ///< count once; only those with a terminal
  std::uint32_t idle_count = 0;    ///< islands without a terminal: copper of no use
  std::vector<NetFault> faults;    ///< by the names of the nets
};

/// `copper`: one region a layer, layer k has the bit 1 << k. A terminal is on the island
/// where a point of its element lies in copper: its centre, or one of its border when the
/// centre has no copper, as of an annular pad. Errors: kInvalidValue for an element that
/// has no size, or a layer that does not exist.
Result<NetReport> CompareNets(std::span<const Region> copper,
                              std::span<const NetElement> drawn);

}  // namespace intaglio::contour
