#pragma once

// Nouns behind their number, in what people read.

#include <cstdint>
#include <string>
#include <string_view>

namespace intaglio {

/// "point" of one, "points" of every other count. `plural`: where it is not the noun and
/// an s, e.g. "passes".
std::string NounFor(std::uint64_t count, std::string_view noun,
                    std::string_view plural = {});

/// "1 point", "0 points", "1240 points".
std::string Counted(std::uint64_t count, std::string_view noun,
                    std::string_view plural = {});

/// "belongs" of one, "belong" of every other count.
inline const char* VerbFor(std::uint64_t count, const char* of_one, const char* of_more) {
  return count == 1 ? of_one : of_more;
}
inline const char* IsOrAre(std::uint64_t count) { return VerbFor(count, "is", "are"); }
inline const char* WasOrWere(std::uint64_t count) {
  return VerbFor(count, "was", "were");
}
inline const char* HasOrHave(std::uint64_t count) {
  return VerbFor(count, "has", "have");
}

}  // namespace intaglio
