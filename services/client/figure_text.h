#pragma once

// Figures as people read them.

#include <cstdint>
#include <string>

namespace intaglio::client {

/// 1234567 -> "1 234 567".
std::string GroupedDigits(std::uint64_t number);
/// 1234567 -> "1.23 M".
std::string ShortNumber(double number);
/// 3725 -> "1 h 02 min", 62 -> "1 min 02 s", 3.2 -> "3.2 s".
std::string ShortDuration(double seconds);

}  // namespace intaglio::client
