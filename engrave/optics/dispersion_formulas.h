#pragma once

// The equations behind dispersion.h. Each takes exactly the coefficients that its row in
// the table allows and a wavelength in um; the result may be NaN or infinite at a pole.

#include <cstddef>
#include <span>

#include "engrave/optics/dispersion.h"

namespace intaglio::optics {

struct FormulaRow {
  DispersionFormula formula;
  const char* name;
  /// Allowed: min_count, min_count + count_step, ... max_count.
  std::size_t min_count;
  std::size_t max_count;
  std::size_t count_step;
  double (*index)(std::span<const double> coefficients, double wavelength_um);

  bool Takes(std::size_t count) const {
    return count >= min_count && count <= max_count &&
           (count - min_count) % count_step == 0;
  }
};

/// All formulas, in the order of the enumerators.
std::span<const FormulaRow> FormulaRows();

}  // namespace intaglio::optics
