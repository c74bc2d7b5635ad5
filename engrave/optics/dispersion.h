#pragma once

// Refractive index of a glass from its catalog's dispersion formula.
//
// Two families are known, and both number their formulas from 1 with different meanings:
// the formulas of AGF files (Zemax glass catalogs, formula number in the NM line) and
// those of refractiveindex.info ("formula N" in a record's DATA). Wavelengths inside the
// formulas are in um; the equations are in dispersion_formulas.cc.

#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::optics {

enum class DispersionFormula {
  // AGF, in the order of their numbers 1..13.
  kSchott,
  kSellmeier1,
  kHerzberger,
  kSellmeier2,
  kConrady,
  kSellmeier3,
  kHandbook1,
  kHandbook2,
  kSellmeier4,
  kExtended,
  kSellmeier5,
  kExtended2,
  kExtended3,
  // refractiveindex.info, in the order of their numbers 1..9.
  kRiiSellmeier,
  kRiiSellmeier2,
  kRiiPolynomial,
  kRiiMixed,
  kRiiCauchy,
  kRiiGases,
  kRiiHerzberger,
  kRiiRetro,
  kRiiExotic,
};

struct Dispersion {
  DispersionFormula formula = DispersionFormula::kSellmeier1;
  /// In the catalog's order. AGF files pad with zeros: zeros beyond the formula's own
  /// coefficients are ignored.
  std::vector<double> coefficients;
  double min_wavelength_um = 0;  ///< the range for which the coefficients were fitted
  double max_wavelength_um = 0;

  bool operator==(const Dispersion&) const = default;
};

/// The name under which a formula is stored: "schott", "sellmeier_1" .. "extended_3" for
/// AGF, "rii_formula_1" .. "rii_formula_9" for refractiveindex.info. Names never change.
const char* DispersionFormulaName(DispersionFormula formula);
Result<DispersionFormula> DispersionFormulaFromName(std::string_view name);

/// From the number in an AGF file (1..13) or a refractiveindex.info record (1..9).
Result<DispersionFormula> DispersionFormulaFromAgf(int number);
Result<DispersionFormula> DispersionFormulaFromRii(int number);

/// Whether the coefficients are finite and of a count that the formula takes, and the
/// range is one.
Status CheckDispersion(const Dispersion& dispersion);

/// n at a wavelength, in the medium to which the catalog refers (air, as a rule). Fails
/// when CheckDispersion does, when the wavelength is outside the glass's range, or when
/// the formula gives no finite n >= 1 there.
Result<double> RefractiveIndex(const Dispersion& dispersion, double wavelength_nm);

/// Vd = (nd - 1) / (nF - nC) at the Fraunhofer lines 587.5618, 486.1327 and 656.2725 nm.
/// Fails when one of them is outside the range, or when there is no dispersion.
Result<double> AbbeNumber(const Dispersion& dispersion);

/// nF - nC, the total dispersion (Trochimczuk 2008, 5.3), at the lines of the Abbe
/// number.
Result<double> TotalDispersion(const Dispersion& dispersion);

/// (n_short - n_long) / (nF - nC) for two wavelengths; of the lines g (435.8343 nm) and F
/// it is P(g,F) of the catalogs. Errors as of AbbeNumber.
Result<double> PartialDispersionRatio(const Dispersion& dispersion, double short_nm,
                                      double long_nm);

}  // namespace intaglio::optics
