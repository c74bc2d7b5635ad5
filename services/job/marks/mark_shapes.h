#pragma once

// What an item of marks is made of before it is placed and filled.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/mark/hatch.h"
#include "proto/mark.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

struct MarkShape {
  std::vector<Vec2> places_mm;  ///< two or more; a closed one does not repeat its first
  bool closed = false;
  bool dashed = false;  ///< each second way is dark: a row of dots (mark::IsRow)
};

/// How a head makes the dots of an image in rows.
struct DotRows {
  double max_gap_mm = 0;  ///< a longer gap is jumped
  double max_mm = 0;      ///< a longer row is divided
};

/// Frame of the item, mm, x to the right, y up.
struct MarkShapes {
  std::vector<MarkShape> shapes;
  mark::InsideRule rule = mark::InsideRule::kEvenOdd;  ///< of its kind
  double module_mm = 0;                                ///< of a code; else 0
  /// Of an image all of it, marked or not; of others that of the shapes.
  std::optional<Box3> extent_mm;
  bool is_scaled = false;  ///< the placement's scale and fit are in it already
};

/// A file of an item with its bytes, which outlive it.
struct MarkFile {
  std::string name;
  std::string_view bytes;
};

/// The fonts of a text, from the first time that it is made on.
using OpenFonts = std::optional<drawing::TextOutliner>;

/// `item` with its defaults and with the text of this repeat, plain; `files` those that
/// ForEachFile (model_kind.h) names for the item. Errors begin with the field within the
/// item, "drawing.file: ...". What a file holds that is not marked is added to
/// `warnings`. `fonts`: those of the item in all repeats. `rows`: of an image of dots;
/// none: each dot is a shape.
Result<MarkShapes> ShapesOf(const MarkItem& item, std::span<const MarkFile> files,
                            const ReadLimits& limits, const std::optional<DotRows>& rows,
                            OpenFonts& fonts, Warnings& warnings);

}  // namespace intaglio
