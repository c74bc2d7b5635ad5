#pragma once

// The program of contours for a controller of another maker, by a template of milling
// (Siwiec 2016, ch. 4.3 and figures 4.11, 4.12), which also serves lasers and plotters.
//
// clang-format off
// Fragments:
//   start
//   approach               required: to the begin of a contour and down
//   line                   required
//   line-z                 a line on a surface that was probed (height_map.h)
//   arc-clockwise          with the next one, or neither: without them arcs become chords
//   arc-counterclockwise
//   speed                  before a move with another speed than the one before
//   rest                   of contours whose moves have speeds: the tool comes to rest
//                          behind the approach and before the retract
//   retract                required: up from the end of a contour
//   end
// Variables beside the common ones (cutting.h):
//   X Y     approach: where the contour begins; a move: its end; retract: where it ends
//   Z       line-z: the height of the tool at its end
//   AX AY   arcs: the place half way along the arc
//   I J     arcs: centre minus begin
//   R       arcs: radius
//   CR      arcs: radius, negative over 180 degrees
//   P       arcs: opening angle, degrees, positive
// Settings beside the common ones:
//   tool-radius  of the tool that the template is for, mm, 0..50; for whoever makes the
//                contours
//   chord        maximum distance of a chord from its arc, mm, 0.0001..1, default 0.001
//   axis-x axis-y axis-speed   of a lathe: where its turning axis is, in the places of
//                the program, and how fast it turns at most, deg/s, 0.01..100000
// clang-format on

#include <span>
#include <string_view>

#include "engrave/post/cutting.h"
#include "engrave/post/height_map.h"
#include "engrave/post/tool_path.h"

namespace intaglio::post {

/// Errors as of ParseTemplate; besides one arc fragment without the other, or an arc that
/// its variables do not determine.
Result<Template> ParseMillTemplate(std::string_view text, std::string_view file,
                                   const Parameters& given = {});

struct MillOptions {
  /// The surface; the tool is so much higher everywhere. Paths become lines, as by
  /// `chords`, and are divided within the tolerance of chords.
  const HeightMap* heights = nullptr;
  bool chords = false;                       ///< although the template has arcs
  std::optional<double> chord_tolerance_mm;  ///< default: the template's
  std::optional<std::size_t> max_bytes;      ///< default: the template's
  std::optional<double> axis_speed_deg_s;    ///< default: the template's
  Vec2 origin_mm = Vec2::Zero();             ///< subtracted, beside the template's
};

/// Whether programs can have a speed of each move: both fragments, `speed` and `rest`.
bool HasSpeeds(const Template& program);

/// Each path once for each depth, the first paths first; over its tabs as tab_parts.h has
/// it. A program longer than its
/// maximum size is divided between paths, and within one that is longer itself: the tool
/// is retracted there, and the next part goes on at the same place.
///
/// kUnsupported: the template does not suit (RequireSuited, heights without line-z, or
/// moves with speeds without HasSpeeds), or a contour that the turning axis of a lathe
/// cannot follow, by name. kInvalidValue: a maximum size that not even one move fits in.
Result<ProgramTexts> MillPrograms(const Template& program,
                                  std::span<const ToolPath> paths, const Cutting& cutting,
                                  const MillOptions& options = {});

}  // namespace intaglio::post
