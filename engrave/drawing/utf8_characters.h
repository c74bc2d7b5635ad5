#pragma once

// Text as Unicode characters and back (UTF-8, RFC 3629).

#include <string>
#include <string_view>

#include "engrave/core/result.h"

namespace intaglio::drawing {

/// kUnreadable: the bytes are not UTF-8.
Result<std::u32string> CharactersOf(std::string_view utf8);

/// Precondition: Unicode scalar values.
std::string Utf8Of(std::u32string_view characters);

/// For people: "'Ł' (U+0141)"; of what cannot be printed the code point alone.
std::string NameOfCharacter(char32_t character);

}  // namespace intaglio::drawing
