#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "engrave/core/findings.h"

namespace intaglio::drawing {

/// What it means for the piece that the reader does not obey an instruction of HP-GL or
/// HP-GL/2. One that is in neither is missing in the piece.
inline Effect EffectOfHpgl(std::string_view name) {
  // Speed, force, width, colours; the look of letters, which are reported themselves;
  // questions to the plotter; paper.
  constexpr std::array<std::string_view, 61> kNoLines = {
      "VS", "FS", "AS", "PW", "WU", "FT", "AC", "SI", "SR", "DI",  "DR", "CS", "CA",
      "SS", "SA", "SD", "AD", "ES", "SL", "LO", "LA", "DV", "DL",  "OA", "OC", "OD",
      "OE", "OF", "OH", "OI", "OL", "OO", "OP", "OS", "OT", "OW",  "IM", "CT", "QL",
      "PG", "PS", "NP", "NR", "CR", "TR", "ST", "BP", "CO", "ESC", "MC", "EC", "MT",
      "PC", "SV", "RF", "SB", "LM", "FN", "NM", "MG", "AF"};
  // They clip, dash, shift, or fill what the pen draws.
  constexpr std::array<std::string_view, 11> kChange = {
      "IW", "LT", "UL", "CP", "PM", "SM", "DT", "CM", "PT", "CF", "RP"};
  if (std::ranges::find(kNoLines, name) != kNoLines.end()) return Effect::kNothingSeen;
  if (std::ranges::find(kChange, name) != kChange.end()) return Effect::kChanged;
  return Effect::kLost;
}

}  // namespace intaglio::drawing
