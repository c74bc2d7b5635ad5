#pragma once

// Reads Gerber files of circuit boards (RS-274X; Ucamco, The Gerber Layer Format
// Specification, 2022): the copper of one layer as elements.
//
// What is read: FS, MO (and G70 G71), apertures C R O P with and without a hole, macros
// (AM) of the primitives 1, 4, 5, 7, 20, 21 with variables and arithmetic; D01 D02 D03,
// lines, arcs (G02 G03 with G75), regions (G36 G37) with cut-ins, step and repeat (SR),
// dark and clear polarity (LPD LPC; exposure 0 in macros): what clear objects cover of
// those before them is taken away, and the rest of an element is an outline with its
// name. Names of pins and nets (TO) become names of the elements. Other attributes and
// comments have no meaning here. What would change the copper and is not handled is
// refused with its line: negative images (IPNEG), G74, mirroring, rotation and scaling of
// apertures, blocks (AB), draws with other apertures than C and lines with R. Frame: the
// file's, y up.

#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge.
struct GerberLimits {
  std::uint64_t max_file_bytes = std::uint64_t{64} << 20;
  std::uint64_t max_elements = 1'000'000;  ///< with repeats and the parts of macros
  std::uint64_t max_edges = 3'000'000;     ///< of outlines
};

/// Errors name the file, the line and the remedy: kUnreadable (no Gerber file, a command
/// that is none), kInvalidValue (numbers, an open region), kMissing (format, unit, an
/// aperture, the end M02), kUnsupported (see above), kTooLarge.
Result<std::vector<Element>> ReadGerber(std::string_view text, std::string_view name,
                                        const GerberLimits& limits = {});

}  // namespace intaglio::contour
