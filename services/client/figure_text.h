#pragma once

// Figures as people read them.

#include <cstdint>
#include <string>
#include <string_view>

namespace intaglio::client {

/// 1234567 -> "1 234 567".
std::string GroupedDigits(std::uint64_t number);
/// 1234, "point" -> "1 234 points"; as Counted of engrave/core/counted.h.
std::string GroupedCount(std::uint64_t count, std::string_view noun,
                         std::string_view plural = {});
/// 1234567 -> "1.23 M".
std::string ShortNumber(double number);
/// 3725 -> "1 h 02 min", 62 -> "1 min 02 s", 3.2 -> "3.2 s".
std::string ShortDuration(double seconds);
/// 1014, 1000 -> ", at most 1.4 % above the best possible", rounded up; of the bound
/// itself ", the best possible".
std::string AboveBound(std::uint64_t ticks, std::uint64_t bound);

}  // namespace intaglio::client
