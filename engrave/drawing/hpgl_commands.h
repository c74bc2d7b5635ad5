#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "engrave/core/findings.h"

namespace intaglio::drawing {

/// From where to where the pen may draw something in a file. It is searched once, since a
/// file may have a new sheet in every third byte.
class HpglDrawn {
 public:
  explicit HpglDrawn(std::string_view file) {
    for (const std::string_view name : {"PD", "PE"}) {
      first_ = std::min(first_, file.find(name));
      if (const std::size_t last = file.rfind(name); last != file.npos)
        end_ = std::max(end_, last + name.size());
    }
  }
  /// Before this byte, and behind it.
  bool IsAround(std::size_t at) const { return first_ < at && at < end_; }

 private:
  std::size_t first_ = std::string_view::npos, end_ = 0;
};

/// What it means for the piece that the reader does not obey an instruction of HP-GL or
/// HP-GL/2. One that is in no list is missing in the piece. `drawn_around`: the pen may
/// draw something before and behind it.
inline Effect EffectOfHpgl(std::string_view name, bool drawn_around) {
  // A new sheet: what comes behind it is drawn over what is on the sheet before.
  if (name == "PG" || name == "AF" || name == "AH" || name == "FR")
    return drawn_around ? Effect::kChanged : Effect::kNothingSeen;
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
