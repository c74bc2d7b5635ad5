#pragma once

// The common part of the fuzz targets of the readers of drawings.

#include <cstdint>
#include <optional>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/read_options.h"

namespace intaglio::drawing {

/// The bytes are read and flattened: finite points, or an error with a sentence.
template <typename Read>
int FuzzReader(const Read& read, const std::uint8_t* bytes, std::size_t size,
               const std::optional<FontSource>& text_font = {}) {
  ReadOptions options;
  options.text_font = text_font;
  options.limits.max_entities = 1000;
  options.limits.max_points = 10'000;
  options.limits.max_unfolded_bytes = 1 << 20;
  const auto drawing =
      read(std::string_view(reinterpret_cast<const char*>(bytes), size), options, "seed");
  if (!drawing) {
    Require(!drawing.error().message.empty(), "an error without a sentence");
    return 0;
  }
  const FlattenOptions coarse{0.1, 0.5, 200'000};
  auto flat = Flatten(*drawing, coarse);
  if (!flat) return 0;
  JoinOpenCurves(0.001, *flat);
  for (const FlatCurve& curve : flat->curves) {
    Require(!curve.points_mm.empty(), "a curve without points");
    for (const Vec3& p : curve.points_mm) {
      Require(p.allFinite(), "a point that is not finite");
    }
  }
  return 0;
}

}  // namespace intaglio::drawing
