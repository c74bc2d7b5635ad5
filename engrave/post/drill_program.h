#pragma once

// The program of holes for a controller of another maker, by a template of drilling
// (Siwiec 2016, ch. 4.3 and figure 4.10).
//
// Fragments: `start`, `cycle` (required: a hole), `tool-change` and `end`. Variables
// beside the common ones (cutting.h), of which DIAMETER is that of the tool:
//   X Y        cycle: the hole
//   TOOL       its number, from 1, in every fragment
// Settings: the common ones.

#include <span>
#include <string_view>

#include "engrave/post/cutting.h"
#include "engrave/post/height_map.h"

namespace intaglio::post {

/// Errors as of ParseTemplate.
Result<Template> ParseDrillTemplate(std::string_view text, std::string_view file,
                                    const Parameters& given = {});

/// The holes of one tool, in their order.
struct DrillRound {
  double diameter_mm = 0;
  std::vector<Vec2> places_mm;
};

/// The rounds in their order, a tool change between them; each tool gets a separate
/// program by a template that has no `tool-change`. The tool's diameter is that of the
/// round, the depth the last of `cutting`. A program longer than its maximum size is
/// divided between holes.
///
/// `heights`: a surface, from which each hole has the depth; null: it is flat.
///
/// kUnsupported: the template does not suit (RequireSuited), or has the depth itself and
/// the surface is not flat. kInvalidValue: a maximum size that not even one hole fits in.
Result<ProgramTexts> DrillPrograms(const Template& program,
                                   std::span<const DrillRound> rounds,
                                   const Cutting& cutting,
                                   const Vec2& origin_mm = Vec2::Zero(),
                                   std::optional<std::size_t> max_bytes = {},
                                   const HeightMap* heights = nullptr);

/// Whether no fragment uses DEPTH: how deep the holes are is in the template.
bool HasOwnDepth(const Template& program);

}  // namespace intaglio::post
