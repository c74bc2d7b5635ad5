#pragma once

// Secrets that nobody can guess.

#include <string>

namespace intaglio::access {

/// 256 bits at random, as 64 hex digits.
std::string NewKey();

}  // namespace intaglio::access
