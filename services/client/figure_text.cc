#include "services/client/figure_text.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/counted.h"

namespace intaglio::client {

std::string GroupedDigits(std::uint64_t number) {
  std::string digits = std::to_string(number);
  for (int at = static_cast<int>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), " ");
  }
  return digits;
}

std::string GroupedCount(std::uint64_t count, std::string_view noun,
                         std::string_view plural) {
  return GroupedDigits(count) + " " + NounFor(count, noun, plural);
}

std::string ShortNumber(double number) {
  if (number >= 1e6) return fmt::format("{:.2f} M", number / 1e6);
  if (number >= 1e4) return fmt::format("{:.0f} k", number / 1e3);
  return number >= 100 ? fmt::format("{:.0f} ", number) : fmt::format("{:.1f} ", number);
}

std::string ShortDuration(double seconds) {
  if (!(seconds >= 0) || seconds > 1e8) return "?";
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::uint64_t>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

std::string AboveBound(std::uint64_t ticks, std::uint64_t bound) {
  if (ticks <= bound) return ", the best possible";
  // Tenths of a per cent, in whole numbers: what divides evenly is not rounded up.
  const std::uint64_t tenths = (1000 * (ticks - bound) + bound - 1) / bound;
  return fmt::format(", at most {}.{} % above the best possible", tenths / 10,
                     tenths % 10);
}

}  // namespace intaglio::client
