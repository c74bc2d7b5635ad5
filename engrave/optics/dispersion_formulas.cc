// With l the wavelength in um, c the coefficients in the catalog's order, from c0.
//
// AGF (formula number, name):
//  1 Schott      n^2 = c0 + c1 l^2 + c2 l^-2 + c3 l^-4 + c4 l^-6 + c5 l^-8
//  2 Sellmeier 1 n^2 - 1 = sum of 3: K l^2 / (l^2 - L), pairs K, L
//  3 Herzberger  n = c0 + c1 L + c2 L^2 + c3 l^2 + c4 l^4 + c5 l^6, L = 1 / (l^2 - 0.028)
//  4 Sellmeier 2 n^2 - 1 = c0 + c1 l^2 / (l^2 - c2^2) + c3 / (l^2 - c4^2)
//  5 Conrady     n = c0 + c1 / l + c2 / l^3.5
//  6 Sellmeier 3 as 2 with 4 pairs
//  7 Handbook 1  n^2 = c0 + c1 / (l^2 - c2) - c3 l^2
//  8 Handbook 2  n^2 = c0 + c1 l^2 / (l^2 - c2) - c3 l^2
//  9 Sellmeier 4 n^2 = c0 + c1 l^2 / (l^2 - c2) + c3 l^2 / (l^2 - c4)
// 10 Extended    as 1, then + c6 l^-10 + c7 l^-12
// 11 Sellmeier 5 as 2 with 5 pairs
// 12 Extended 2  as 1, then + c6 l^4 + c7 l^6
// 13 Extended 3  n^2 = c0 + c1 l^2 + c2 l^4 + c3 l^-2 + c4 l^-4 + ... + c8 l^-12
//
// refractiveindex.info ("Dispersion formulas", 2014), pairs from c1 on:
//  1 n^2 - 1 = c0 + sum a l^2 / (l^2 - b^2)
//  2 n^2 - 1 = c0 + sum a l^2 / (l^2 - b)
//  3 n^2 = c0 + sum a l^b
//  4 n^2 = c0 + c1 l^c2 / (l^2 - c3^c4) + c5 l^c6 / (l^2 - c7^c8) + sum a l^b from c9
//  5 n = c0 + sum a l^b
//  6 n - 1 = c0 + sum a / (b - l^-2)
//  7 n = c0 + c1 L + c2 L^2 + c3 l^2 + c4 l^4 + c5 l^6, L as above; later ones may lack
//  8 (n^2 - 1) / (n^2 + 2) = r = c0 + c1 l^2 / (l^2 - c2) + c3 l^2,
//    so n^2 = (1 + 2 r) / (1 - r)
//  9 n^2 = c0 + c1 / (l^2 - c2) + c3 (l - c4) / ((l - c4)^2 + c5)
// A term whose factor is 0 is absent: catalogs fill unused terms with zeros, and their
// pole must not count.

#include "engrave/optics/dispersion_formulas.h"

#include <array>
#include <cmath>

namespace intaglio::optics {
namespace {

using Coefficients = std::span<const double>;

double Term(double factor, double denominator) {
  return factor == 0 ? 0 : factor / denominator;
}

/// Sum over the pairs (a, b) that start at `first`.
template <typename F>
double SumPairs(Coefficients c, std::size_t first, F term) {
  double sum = 0;
  for (std::size_t i = first; i + 1 < c.size(); i += 2) {
    if (c[i] != 0) sum += term(c[i], c[i + 1]);
  }
  return sum;
}

double SumPowers(Coefficients c, std::size_t first, double l) {
  return SumPairs(c, first, [l](double a, double b) { return a * std::pow(l, b); });
}

/// Sellmeier terms with the squared resonance as coefficient.
double SumResonances(Coefficients c, std::size_t first, double l2) {
  return SumPairs(c, first, [l2](double a, double b) { return a * l2 / (l2 - b); });
}

/// c[0] + c[1] l^2 + c[2] l^-2 + c[3] l^-4 ...: common to the Schott-like formulas.
double SchottSeries(Coefficients c, double l2) {
  double sum = c[0] + c[1] * l2;
  double power = 1;
  for (std::size_t i = 2; i < c.size(); ++i) {
    power /= l2;
    sum += c[i] * power;
  }
  return sum;
}

double Schott(Coefficients c, double l) { return std::sqrt(SchottSeries(c, l * l)); }

double Sellmeier(Coefficients c, double l) {
  return std::sqrt(1 + SumResonances(c, 0, l * l));
}

double Herzberger(Coefficients c, double l) {
  const double l2 = l * l;
  const double pole = 1 / (l2 - 0.028);
  double sum = c[0] + c[1] * pole + c[2] * pole * pole;
  double power = 1;
  for (std::size_t i = 3; i < c.size(); ++i) {
    power *= l2;
    sum += c[i] * power;
  }
  return sum;
}

double Sellmeier2(Coefficients c, double l) {
  const double l2 = l * l;
  return std::sqrt(1 + c[0] + Term(c[1] * l2, l2 - c[2] * c[2]) +
                   Term(c[3], l2 - c[4] * c[4]));
}

double Conrady(Coefficients c, double l) {
  return c[0] + c[1] / l + c[2] / std::pow(l, 3.5);
}

double Handbook1(Coefficients c, double l) {
  const double l2 = l * l;
  return std::sqrt(c[0] + Term(c[1], l2 - c[2]) - c[3] * l2);
}

double Handbook2(Coefficients c, double l) {
  const double l2 = l * l;
  return std::sqrt(c[0] + Term(c[1] * l2, l2 - c[2]) - c[3] * l2);
}

double Sellmeier4(Coefficients c, double l) {
  return std::sqrt(c[0] + SumResonances(c, 1, l * l));
}

double Extended2(Coefficients c, double l) {
  const double l2 = l * l;
  return std::sqrt(SchottSeries(c.first(6), l2) + c[6] * l2 * l2 + c[7] * l2 * l2 * l2);
}

double Extended3(Coefficients c, double l) {
  const double l2 = l * l;
  const std::array<double, 8> series = {c[0], c[1], c[3], c[4], c[5], c[6], c[7], c[8]};
  return std::sqrt(SchottSeries(series, l2) + c[2] * l2 * l2);
}

double RiiSellmeier(Coefficients c, double l) {
  const double l2 = l * l;
  return std::sqrt(1 + c[0] + SumPairs(c, 1, [l2](double a, double b) {
                     return a * l2 / (l2 - b * b);
                   }));
}

double RiiSellmeier2(Coefficients c, double l) {
  return std::sqrt(1 + c[0] + SumResonances(c, 1, l * l));
}

double RiiPolynomial(Coefficients c, double l) {
  return std::sqrt(c[0] + SumPowers(c, 1, l));
}

double RiiMixed(Coefficients c, double l) {
  double sum = c[0];
  for (std::size_t i = 1; i + 3 < c.size() && i < 9; i += 4) {
    sum += Term(c[i] * std::pow(l, c[i + 1]), l * l - std::pow(c[i + 2], c[i + 3]));
  }
  return std::sqrt(sum + SumPowers(c, 9, l));
}

double RiiCauchy(Coefficients c, double l) { return c[0] + SumPowers(c, 1, l); }

double RiiGases(Coefficients c, double l) {
  const double wavenumber2 = 1 / (l * l);
  return 1 + c[0] + SumPairs(c, 1, [wavenumber2](double a, double b) {
           return a / (b - wavenumber2);
         });
}

double RiiRetro(Coefficients c, double l) {
  const double l2 = l * l;
  const double r = c[0] + Term(c[1] * l2, l2 - c[2]) + c[3] * l2;
  return std::sqrt((1 + 2 * r) / (1 - r));
}

double RiiExotic(Coefficients c, double l) {
  const double shift = l - c[4];
  return std::sqrt(c[0] + Term(c[1], l * l - c[2]) +
                   Term(c[3] * shift, shift * shift + c[5]));
}

using enum DispersionFormula;

// refractiveindex.info allows up to 17 coefficients in formulas 1-4, 11 in 5 and 6.
constexpr std::array kRows = {
    FormulaRow{kSchott, "schott", 6, 6, 1, Schott},
    FormulaRow{kSellmeier1, "sellmeier_1", 6, 6, 1, Sellmeier},
    FormulaRow{kHerzberger, "herzberger", 6, 6, 1, Herzberger},
    FormulaRow{kSellmeier2, "sellmeier_2", 5, 5, 1, Sellmeier2},
    FormulaRow{kConrady, "conrady", 3, 3, 1, Conrady},
    FormulaRow{kSellmeier3, "sellmeier_3", 8, 8, 1, Sellmeier},
    FormulaRow{kHandbook1, "handbook_1", 4, 4, 1, Handbook1},
    FormulaRow{kHandbook2, "handbook_2", 4, 4, 1, Handbook2},
    FormulaRow{kSellmeier4, "sellmeier_4", 5, 5, 1, Sellmeier4},
    FormulaRow{kExtended, "extended", 8, 8, 1, Schott},
    FormulaRow{kSellmeier5, "sellmeier_5", 10, 10, 1, Sellmeier},
    FormulaRow{kExtended2, "extended_2", 8, 8, 1, Extended2},
    FormulaRow{kExtended3, "extended_3", 9, 9, 1, Extended3},
    FormulaRow{kRiiSellmeier, "rii_formula_1", 1, 17, 2, RiiSellmeier},
    FormulaRow{kRiiSellmeier2, "rii_formula_2", 1, 17, 2, RiiSellmeier2},
    FormulaRow{kRiiPolynomial, "rii_formula_3", 1, 17, 2, RiiPolynomial},
    FormulaRow{kRiiMixed, "rii_formula_4", 9, 17, 2, RiiMixed},
    FormulaRow{kRiiCauchy, "rii_formula_5", 1, 11, 2, RiiCauchy},
    FormulaRow{kRiiGases, "rii_formula_6", 1, 11, 2, RiiGases},
    FormulaRow{kRiiHerzberger, "rii_formula_7", 3, 6, 1, Herzberger},
    FormulaRow{kRiiRetro, "rii_formula_8", 4, 4, 1, RiiRetro},
    FormulaRow{kRiiExotic, "rii_formula_9", 6, 6, 1, RiiExotic},
};

}  // namespace

std::span<const FormulaRow> FormulaRows() { return kRows; }

}  // namespace intaglio::optics
