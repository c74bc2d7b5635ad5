#include "engrave/optics/dispersion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/optics/dispersion_formulas.h"

namespace intaglio::optics {
namespace {

constexpr int kAgfCount = 13;
constexpr int kRiiCount = 9;

// Fraunhofer lines.
constexpr double kLineDNm = 587.5618, kLineFNm = 486.1327, kLineCNm = 656.2725;

// A wavelength that was written in nm and a limit written in um may differ in the last
// bit; 1e-9 um is far below any line's width.
constexpr double kRangeSlackUm = 1e-9;

const FormulaRow& RowOf(DispersionFormula formula) {
  const auto index = static_cast<std::size_t>(formula);
  const auto rows = FormulaRows();
  Require(index < rows.size(), "there is no dispersion formula {}", index);
  return rows[index];
}

/// The coefficients without the zeros that a catalog pads with.
std::span<const double> Unpadded(const std::vector<double>& coefficients,
                                 std::size_t max_count) {
  std::size_t count = coefficients.size();
  while (count > max_count && coefficients[count - 1] == 0) --count;
  return {coefficients.data(), count};
}

std::string AllowedCounts(const FormulaRow& row) {
  std::string text;
  for (std::size_t count = row.min_count; count <= row.max_count;
       count += row.count_step) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", count);
  }
  return text;
}

}  // namespace

const char* DispersionFormulaName(DispersionFormula formula) {
  return RowOf(formula).name;
}

Result<DispersionFormula> DispersionFormulaFromName(std::string_view name) {
  std::string known;
  for (const FormulaRow& row : FormulaRows()) {
    if (name == row.name) return row.formula;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", row.name);
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("unknown dispersion formula \"{}\"; known are {}", name, known),
              std::string(name));
}

Result<DispersionFormula> DispersionFormulaFromAgf(int number) {
  if (number < 1 || number > kAgfCount) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("AGF dispersion formula {} is outside 1..{}", number, kAgfCount),
        std::to_string(number));
  }
  return FormulaRows()[static_cast<std::size_t>(number - 1)].formula;
}

Result<DispersionFormula> DispersionFormulaFromRii(int number) {
  if (number < 1 || number > kRiiCount) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("refractiveindex.info formula {} is outside 1..{}", number,
                            kRiiCount),
                std::to_string(number));
  }
  return FormulaRows()[static_cast<std::size_t>(kAgfCount + number - 1)].formula;
}

Status CheckDispersion(const Dispersion& dispersion) {
  const FormulaRow& row = RowOf(dispersion.formula);
  const auto coefficients = Unpadded(dispersion.coefficients, row.max_count);
  if (!row.Takes(coefficients.size())) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("dispersion formula {} takes {} coefficients, not {}",
                            row.name, AllowedCounts(row), coefficients.size()),
                std::to_string(coefficients.size()));
  }
  for (const double coefficient : coefficients) {
    if (std::isfinite(coefficient)) continue;
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a coefficient of dispersion formula {} is not a number", row.name),
        fmt::format("{}", coefficient));
  }
  if (!(dispersion.min_wavelength_um > 0) ||
      !std::isfinite(dispersion.max_wavelength_um) ||
      !(dispersion.min_wavelength_um <= dispersion.max_wavelength_um)) {
    return Fail(ErrorCode::kInvalidValue,
                "the wavelength range of a dispersion formula must have 0 < min <= max",
                fmt::format("{}..{} um", dispersion.min_wavelength_um,
                            dispersion.max_wavelength_um));
  }
  return {};
}

Result<double> RefractiveIndex(const Dispersion& dispersion, double wavelength_nm) {
  INTAGLIO_TRY(CheckDispersion(dispersion));
  const double wavelength_um = wavelength_nm / 1000;
  if (!(wavelength_um >= dispersion.min_wavelength_um - kRangeSlackUm &&
        wavelength_um <= dispersion.max_wavelength_um + kRangeSlackUm)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("wavelength {} nm is outside the glass's range {}..{} nm",
                            wavelength_nm, dispersion.min_wavelength_um * 1000,
                            dispersion.max_wavelength_um * 1000),
                fmt::format("{}", wavelength_nm));
  }
  const FormulaRow& row = RowOf(dispersion.formula);
  const double n =
      row.index(Unpadded(dispersion.coefficients, row.max_count), wavelength_um);
  if (!std::isfinite(n) || n < 1) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("dispersion formula {} gives no refractive index of at least 1 at "
                    "{} nm; check its coefficients",
                    row.name, wavelength_nm),
        fmt::format("{}", n));
  }
  return n;
}

Result<double> TotalDispersion(const Dispersion& dispersion) {
  const double n_f = INTAGLIO_TRY(RefractiveIndex(dispersion, kLineFNm));
  const double n_c = INTAGLIO_TRY(RefractiveIndex(dispersion, kLineCNm));
  if (n_f == n_c) {
    return Fail(
        ErrorCode::kInvalidValue,
        "the glass has the same index at 486.1 and 656.3 nm and so no Abbe number");
  }
  return n_f - n_c;
}

Result<double> AbbeNumber(const Dispersion& dispersion) {
  const double n_d = INTAGLIO_TRY(RefractiveIndex(dispersion, kLineDNm));
  const double total = INTAGLIO_TRY(TotalDispersion(dispersion));
  return (n_d - 1) / total;
}

Result<double> PartialDispersionRatio(const Dispersion& dispersion, double short_nm,
                                      double long_nm) {
  const double n_short = INTAGLIO_TRY(RefractiveIndex(dispersion, short_nm));
  const double n_long = INTAGLIO_TRY(RefractiveIndex(dispersion, long_nm));
  const double total = INTAGLIO_TRY(TotalDispersion(dispersion));
  return (n_short - n_long) / total;
}

}  // namespace intaglio::optics
