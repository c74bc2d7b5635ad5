#include "engrave/core/counted.h"

#include <fmt/format.h>

namespace intaglio {

std::string NounFor(std::uint64_t count, std::string_view noun, std::string_view plural) {
  if (count == 1) return std::string(noun);
  return plural.empty() ? fmt::format("{}s", noun) : std::string(plural);
}

std::string Counted(std::uint64_t count, std::string_view noun, std::string_view plural) {
  return fmt::format("{} {}", count, NounFor(count, noun, plural));
}

}  // namespace intaglio
