#pragma once

// What the codes of NCI records mean for a drawing.
//
// Sources: CNC Software, Mastercam Version 9.1 MP Post Reference Guide, Volume 3, Chapter
// 6, The NCI File, November 2002 (the codes, and the parameters of linear moves). The
// places of the parameters of arcs, five-axis moves and tool records are those on which
// two independent published readers of the format agree; docs/formats.md.

#include <cstdint>
#include <optional>
#include <string>

#include "engrave/core/findings.h"

namespace intaglio::drawing {

enum class NciCode : std::uint32_t {
  kRapid = 0,
  kLine = 1,
  kClockwise = 2,
  kCounterClockwise = 3,
  kDwell = 4,
  kFiveAxis = 11,
  kEndCycle = 80,
  kDrill = 81,
  kDrillAgain = 100,
  kFirstTool = 1000,
  kLastTool = 1002,
  kEnd = 1003,
  kToolPlane = 1014,
  kBeginSubprogram = 1018,
  kEndSubprogram = 1019,
};

struct NciMeaning {
  std::string name;
  Effect effect = Effect::kLost;
};

/// What it means that no line comes of a record of this code; none: the record draws
/// nothing and changes no line (comments, settings of the tool, the stock, headers).
inline std::optional<NciMeaning> MeaningOfUndrawn(std::uint32_t code) {
  const std::string number = std::to_string(code);
  switch (static_cast<NciCode>(code)) {
    case NciCode::kDrill:
    case NciCode::kDrillAgain:
      return NciMeaning{"hole of a drilling cycle (code " + number + ")", Effect::kLost};
    case NciCode::kBeginSubprogram:
      return NciMeaning{"subprogram, drawn once (code 1018)", Effect::kChanged};
    default:
      break;
  }
  constexpr std::uint32_t kNoLines[] = {4,    80,   1000, 1001, 1002, 1003, 1005,
                                        1006, 1007, 1008, 1011, 1012, 1013, 1014,
                                        1016, 1017, 1019, 1020, 1025, 1027, 1050};
  for (const std::uint32_t known : kNoLines) {
    if (code == known) return std::nullopt;
  }
  // Parameters of operations and of tools.
  if (code >= 10'000 && code < 30'000) return std::nullopt;
  return NciMeaning{"record of the unknown code " + number, Effect::kLost};
}

/// Whether the tool may be elsewhere after the record. Codes of moves are below 1000; at
/// a change of the tool it goes to its place of change.
inline bool MayMove(std::uint32_t code) {
  return code < 1000 ? code != static_cast<std::uint32_t>(NciCode::kDwell) &&
                           code != static_cast<std::uint32_t>(NciCode::kEndCycle)
                     : code <= static_cast<std::uint32_t>(NciCode::kLastTool);
}

}  // namespace intaglio::drawing
