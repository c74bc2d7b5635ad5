#pragma once

// What a fitted grid says about its head, as lines for people.

#include <string>
#include <vector>

#include "engrave/galvo/correction_table.h"
#include "engrave/galvo/head_fit.h"

namespace intaglio::cli {

/// The ten numbers of the head with their intervals.
std::vector<std::string> ModelLines(const galvo::HeadFit& fit);

/// How good marks and fit are. `as_marked`: places that were to be marked, and measured;
/// `before`: the correction in use, null for none; `width_mm`: holds all commands.
std::vector<std::string> FitLines(const std::vector<galvo::GridMark>& as_marked,
                                  const galvo::HeadFit& fit,
                                  const galvo::CorrectionTable* before, double width_mm);

}  // namespace intaglio::cli
