#pragma once

#include <string>
#include <string_view>

namespace intaglio::materials_db {

/// Whether all of it is well formed UTF-8 and text: no Unicode noncharacters.
bool IsUtf8(std::string_view bytes);

/// UTF-16 by its byte order mark, UTF-8 with or without one; bytes that are neither are
/// taken as Latin-1, in which they always have a meaning.
std::string ToUtf8(std::string_view bytes);

/// `c`: one of those that IsCharacter allows.
void AppendUtf8(std::string& text, char32_t c);

/// Whether `c` is allowed in text: not a surrogate, and not one of Unicode's
/// noncharacters (YAML cannot contain them).
constexpr bool IsCharacter(char32_t c) {
  return c <= 0x10FFFF && !(c >= 0xD800 && c <= 0xDFFF) && (c & 0xFFFE) != 0xFFFE &&
         !(c >= 0xFDD0 && c <= 0xFDEF);
}

}  // namespace intaglio::materials_db
