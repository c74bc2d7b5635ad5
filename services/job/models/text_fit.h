#pragma once

// How small a text has to be for its place.

#include <span>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"
#include "proto/job.pb.h"

namespace intaglio {

struct TextFit {
  double scale_ratio = 1;  ///< 0..1, the largest that fits; 0: none does
  std::string obstacle;    ///< what is in the way at 1: "reaches from x = ..."; or empty
};

/// Of a model's text in its block, with the copies; `outline` in the drawing's frame.
/// `copy`: the number of the copy from 0; below 0: all copies have this outline.
Result<TextFit> FitText(const JobSpec& job, const Model& model,
                        const drawing::Drawing& outline, int copy);

}  // namespace intaglio
