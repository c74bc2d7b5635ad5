#pragma once

// The texts of a job: their fonts, their letters, and the height that lets them fit.

#include <span>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/drawing/drawing.h"
#include "engrave/drawing/font_source.h"
#include "proto/job.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// "none" in the place of all fallback fonts.
inline constexpr const char* kNoFallback = "none";

/// A text as it is engraved.
struct OutlinedText {
  /// One, or one for each copy when they are numbered.
  std::vector<drawing::Drawing> outlines;
  double height_mm = 0;  ///< of capitals; less than asked when it was shrunk
  Warnings warnings;     ///< letters of other fonts, and a smaller height
};

/// Whether the copies of a text differ by their numbers.
bool IsNumbered(const Text& text);

/// The letters of a model with a text, all copies of one height. `fonts`: the model's
/// font, then its fallback fonts. `job` with its defaults filled in. Errors: those of the
/// fonts; kMissing: a character is in no font; kOutsideBlock: the text is larger than its
/// limits and may not be shrunk, with the height that fits.
Result<OutlinedText> OutlineText(const JobSpec& job, const Model& model,
                                 std::span<const drawing::FontSource> fonts);

/// What the texts need of this computer's fonts: families become files, and each text
/// gets those of its fallback fonts, or of the usual ones, that have a character which
/// its font lacks. Returns what is not installed or cannot be read.
std::vector<Finding> ResolveFonts(JobSpec& job);

/// What of the texts cannot be engraved, each with its field. Reads the fonts; a font
/// that is not there is not reported again. `notes`: the warnings of those that can be.
std::vector<Finding> CheckTexts(const JobSpec& job, Warnings& notes);

}  // namespace intaglio
