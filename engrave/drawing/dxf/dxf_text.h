#pragma once

// TEXT, ATTRIB and MTEXT as lines of letters (DXF reference, R2018).

#include <string>
#include <vector>

#include "engrave/drawing/dxf/dxf_groups.h"
#include "engrave/drawing/dxf/dxf_insert.h"
#include "engrave/drawing/typesetter.h"

namespace intaglio::drawing {

/// Letters of one height and form.
struct DxfTextRun {
  std::u32string text;
  /// Of the entity's height; negative: minus the height in units of the file (\\H).
  double height_ratio = 1;
  double width_ratio = 1;  ///< of the letters
};
using DxfTextLine = std::vector<DxfTextRun>;

bool IsDxfText(std::string_view type);

/// Control codes of TEXT: %%c %%d %%p %%nnn, \U+XXXX; %%u and %%o are left out.
std::u32string PlainDxfText(std::u32string_view text);

/// Formatting codes of MTEXT as well: \P \N \X, \H \W with groups in braces, \S, \~; the
/// font, colour, lines under or over letters, slant and spacing of a code (\f \F \C \c \L
/// \l \O \o \K \k \Q \T \A \p) are left out, so that all letters are of one font.
std::vector<DxfTextLine> DxfMtextLines(std::u32string_view text);

struct DxfLettering {
  DxfCommon common;
  std::vector<Curve> curves;  ///< closed, in the drawing's frame
  std::string left_out;       ///< why there are none: kind of Drawing::left_out
};

/// Heights, widths, turn, slant, mirrors and alignment of the entity. Lines of MTEXT are
/// broken at its width and lie 5/3 of their height apart, times its line spacing. False:
/// the builder has the error.
bool SetDxfText(const DxfEntity& entity, const Typesetter& typesetter,
                DrawingBuilder& builder, DxfLettering& lettering);

}  // namespace intaglio::drawing
