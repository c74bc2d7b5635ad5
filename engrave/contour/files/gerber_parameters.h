#pragma once

// The parameters of Gerber files, between '%' and '*'. All errors are sentences without a
// place and a remedy.

#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "engrave/contour/files/gerber_aperture.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// FSLAX46Y46: four digits before and six behind the point, those in front left out.
struct GerberFormat {
  int digits = 0;  ///< 0: not declared
  int behind = 0;
  bool trailing_left_out = false;
};
Result<GerberFormat> ParseGerberFormat(std::string_view block);

/// MOMM or MOIN: 1 or 25.4 mm.
Result<double> ParseGerberUnit(std::string_view block);

/// SRX3Y2I5.0J4.0; SR: once.
struct GerberRepeat {
  int columns = 1;
  int rows = 1;
  Vec2 step_mm = Vec2::Zero();
};
Result<GerberRepeat> ParseGerberRepeat(std::string_view block, double unit_mm);

using GerberMacros = std::map<std::string, GerberMacro, std::less<>>;

/// ADD10C,0.5X0.2: its number and the aperture.
Result<std::pair<int, GerberAperture>> ParseGerberAperture(std::string_view block,
                                                           const GerberMacros& macros,
                                                           double unit_mm);

/// Attributes, names, and rotations by 0 and the like.
bool HasNoEffect(std::string_view block);

/// Whether the file declares to be the copper of the back, as an attribute or as a
/// comment of older programs: %TF.FileFunction,Copper,L2,Bot*% (Ucamco 2022, ch. 5.6.3).
bool DrawsBackOfBoard(std::string_view text);

}  // namespace intaglio::contour
