#pragma once

// Whether measured marks of a grid can be those of their commands, before a head is
// fitted to them: columns that are swapped, a mirrored or turned picture and another unit
// give a fit, too, and a correction that ruins the next piece.

#include <span>

#include "engrave/core/result.h"
#include "engrave/galvo/head_fit.h"

namespace intaglio::galvo {

/// By the linear part of the field, as the smallest squares have it. kInvalidValue: x and
/// y swapped, an axis mirrored, turned by more than 15 degrees, sides of less than half
/// or more than twice of those commanded, or axes whose ratio is beyond 0.8..1.25. Marks
/// that lie on one line pass: FitHead refuses them.
Status CheckGridSense(std::span<const GridMark> marks);

/// Of a finished fit. kInvalidValue: more than a fifth of the marks was left out, or what
/// is left of the others is more than 0.3 % of the field, rms of a coordinate: such a fit
/// explains nothing.
Status CheckFitSense(const HeadFit& fit, double width_mm);

}  // namespace intaglio::galvo
