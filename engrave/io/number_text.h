#pragma once

#include <string>
#include <string_view>

namespace intaglio::io {

/// The shortest decimals that give the same double, with an exponent where that is
/// shorter.
void AppendShortest(double value, std::string& text);

/// The same without an exponent, for readers that know none. 326 characters at most.
void AppendShortestFixed(double value, std::string& text);

/// The number that the word is as a whole, finite or not; a plus sign may stand before
/// it. False, and `value` undefined, when it is none.
bool ParseNumber(std::string_view word, double& value);

}  // namespace intaglio::io
