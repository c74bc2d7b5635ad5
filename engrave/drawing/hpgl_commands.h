#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "engrave/core/findings.h"

namespace intaglio::drawing {

/// Whether the pen may draw something in this part of a file.
inline bool MayDrawHpgl(std::string_view part) {
  return part.find("PD") != part.npos || part.find("PE") != part.npos;
}

/// What it means for the piece that the reader does not obey an instruction of HP-GL or
/// HP-GL/2, which begins at this byte of the file. One that is in no list is missing in
/// the piece.
inline Effect EffectOfHpgl(std::string_view name, std::string_view file,
                           std::size_t begin) {
  // A new sheet: what comes behind it is drawn over what is on the sheet before.
  if (name == "PG" || name == "AF" || name == "AH" || name == "FR") {
    const bool covers =
        MayDrawHpgl(file.substr(0, begin)) && MayDrawHpgl(file.substr(begin));
    return covers ? Effect::kChanged : Effect::kNothingSeen;
  }
  // Speed, force, width, colours; the look of letters, which are reported themselves;
  // questions to the plotter; paper.
  constexpr std::array<std::string_view, 59> kNoLines = {
      "VS", "FS", "AS", "PW", "WU", "FT", "AC", "SI", "SR", "DI", "DR", "CS",
      "CA", "SS", "SA", "SD", "AD", "ES", "SL", "LO", "LA", "DV", "DL", "OA",
      "OC", "OD", "OE", "OF", "OH", "OI", "OL", "OO", "OP", "OS", "OT", "OW",
      "IM", "CT", "QL", "PS", "NP", "NR", "CR", "TR", "ST", "BP", "CO", "ESC",
      "MC", "EC", "MT", "PC", "SV", "RF", "SB", "LM", "FN", "NM", "MG"};
  // They clip, dash, shift, or fill what the pen draws.
  constexpr std::array<std::string_view, 11> kChange = {
      "IW", "LT", "UL", "CP", "PM", "SM", "DT", "CM", "PT", "CF", "RP"};
  if (std::ranges::find(kNoLines, name) != kNoLines.end()) return Effect::kNothingSeen;
  if (std::ranges::find(kChange, name) != kChange.end()) return Effect::kChanged;
  return Effect::kLost;
}

}  // namespace intaglio::drawing
