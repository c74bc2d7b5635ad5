#pragma once

// A linear drive by two polynomials of the derivative s, lowest power first:
//   a0 x + a1 x' + a2 x'' + ... = b0 c + b1 c' + ...,   c the command, x the actual.
// Both begin with 1: an axis at rest is where it is commanded. a_k and b_k in s^k.

#include <array>
#include <cstddef>

namespace intaglio::drive {

/// Highest order of a drive: a cascade of three loops and mechanics.
inline constexpr std::size_t kMaxOrder = 5;
using Polynomial = std::array<double, kMaxOrder + 1>;

struct Transfer {
  Polynomial numerator = {1};    ///< b
  Polynomial denominator = {1};  ///< a
};

/// The highest power with a coefficient other than 0.
std::size_t OrderOf(const Polynomial& polynomial);

/// Throws PreconditionError when the product is of a higher order than kMaxOrder.
Polynomial Product(const Polynomial& f, const Polynomial& g);
Polynomial Sum(const Polynomial& f, const Polynomial& g);

/// Whether all roots have negative real parts, by the scheme of Routh (1877): its first
/// column is positive. The polynomial begins with 1.
bool IsStable(const Polynomial& polynomial);

/// The first four coefficients of f / g as a series in s; g begins with 1.
std::array<double, 4> SeriesOf(const Polynomial& f, const Polynomial& g);

}  // namespace intaglio::drive
